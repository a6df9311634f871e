"""`brdf bench models`: both sides compute the same numbers, and the figures are those of the rounds."""

import dataclasses
import json
import os
import pathlib
import subprocess
import sys
from typing import ClassVar

import jax
import jax.numpy as jnp
import numpy as np
import pytest

import brdf
from brdf.frame import Color
from brdf.model import AbstractBRDF
from brdf.parameter import color
from brdf.registry import MODELS
from fitter.bench import measure, mitsuba, report
from fitter.bench.numpy_program import NumpyProgram

COUNT = 8


def arguments(name, dtype="float64"):
    return jax.tree.map(lambda leaf: np.asarray(leaf, dtype), (brdf.build(name), *measure.directions(COUNT, dtype)))


@pytest.mark.parametrize("name", MODELS)
def test_numpy_computes_what_the_model_does(name):
    model, wi, wo = arguments(name)
    (found,) = NumpyProgram(measure.value, model, wi, wo)(model, wi, wo)
    # Oracle: the compiled model through its public door. Both round in float64, in another order.
    np.testing.assert_allclose(found.T, brdf.evaluate(model, wi.T.copy(), wo.T.copy()), rtol=1e-10)


# A model of facets, and one whose unknown in a fit is a square.
@pytest.mark.parametrize("name", ["ggx", "oren_nayar"])
def test_the_gradient_is_that_of_finite_differences(name):
    model, wi, wo = arguments(name)
    value, *found = NumpyProgram(measure.value_and_gradient, model, wi, wo)(model, wi, wo)
    program, step = NumpyProgram(measure.value, model, wi, wo), 1e-6
    np.testing.assert_array_equal(value, program(model, wi, wo)[0])
    assert len(found) == len(brdf.parameters(model)) == 2
    for parameter, derivative in zip(brdf.parameters(model), found, strict=True):
        number = getattr(model, parameter.name)
        above, below = (
            program(dataclasses.replace(model, **{parameter.name: number + sign * step}), wi, wo)[0] for sign in (1, -1)
        )
        np.testing.assert_allclose(derivative, (above - below) / (2 * step), rtol=1e-6, atol=1e-9)


class Mixing(AbstractBRDF):
    """Its red is the green of a colour."""

    mixes_channels: ClassVar[bool] = True
    albedo: Color = color(0.0, 1.0, 0.5, "colour")

    def reflect(self, g):
        return self.albedo[jnp.array([1, 1, 2])]

    def proposals(self, cos_o):
        raise NotImplementedError


def test_a_model_that_mixes_channels_has_three_derivatives_per_colour():
    _, found = measure.value_and_gradient(Mixing(), *map(jnp.asarray, measure.directions(COUNT, "float64")))
    np.testing.assert_array_equal(np.stack(found)[:, :, 0], [[0, 0, 0], [1, 1, 0], [0, 0, 1]])


def test_float32_stays_float32():
    model, wi, wo = arguments("ggx", "float32")
    (found,) = NumpyProgram(measure.value, model, wi, wo)(model, wi, wo)
    assert found.dtype == np.float32


def test_nothing_unused_or_twice_is_computed():
    program = NumpyProgram(lambda x: (x * x + x * x, jnp.sin(x))[0], np.ones(3))
    assert program.size == 2
    np.testing.assert_array_equal(program(np.arange(3.0))[0], [0, 2, 8])


def test_powers_are_products():
    x = np.array([0.5, -2.0, 3.0])
    for exponent in (-3, -1, 1, 2, 5, 12):
        (found,) = NumpyProgram(lambda x, exponent=exponent: jax.lax.integer_pow(x, exponent), x)(x)
        np.testing.assert_allclose(found, x**exponent, rtol=1e-15)


def test_an_operation_without_a_numpy_version_is_named():
    with pytest.raises(NotImplementedError, match="sort"):
        NumpyProgram(jnp.sort, np.ones(3))


def test_a_choice_leaves_nothing_of_an_absent_lobe():
    def size(model):
        return NumpyProgram(
            measure.value, *jax.tree.map(np.asarray, (model, *measure.directions(COUNT, "float64")))
        ).size

    ashikhmin_shirley = MODELS["ashikhmin_shirley"]
    assert size(ashikhmin_shirley()) < size(ashikhmin_shirley(diffuse="coupled"))
    assert size(brdf.build("ggx")) < size(brdf.build("lambert+ggx"))


def test_rates_are_medians_of_interleaved_rounds(monkeypatch):
    clock, order = [0.0], []
    seconds = {"a": iter([9, 9, 1, 2, 100]), "b": iter([9, 9, 4, 4, 4])}

    def run(name):
        def work():
            order.append(name)
            clock[0] += next(seconds[name])

        return work

    monkeypatch.setattr(measure.time, "process_time", lambda: clock[0])
    # The first two runs of each warm it and decide how many make a round.
    assert measure.rates({"a": (run("a"), 10), "b": (run("b"), 8)}, 3) == {"a": 5, "b": 2}
    assert "".join(order) == "aabb" + "ab" * 3


def bench(**changes):
    one = measure.Speed(2e8, 1e8, 1e8, 2e7, 2, 1e-15)
    costs = {("ggx", "lambert+ggx"): (measure.Cost(136.0, 140, 8e7), measure.Cost(139.0, 144, 7e7))}
    peers = mitsuba.Peers({"ggx": mitsuba.Peer("roughconductor", "fresnel = conductor", 1e8, 2e8, 1e-7, 1e-5)}, "Here")
    settings = {"points": 64, "dtype": "float64", "rounds": 3, "one_core": True}
    return report.Bench(**{"speeds": {"ggx": one}, "costs": costs, "peers": peers, **settings, **changes})


def test_reports_hold_the_ratios():
    assert "| ggx | 200 | 2.0 | 100 | 5.0 | 2 | 1e-15 |" in report.markdown(bench())
    assert "| ggx (fresnel = conductor) | roughconductor | 100 | 200 | 0.50 | 1e-07 | 1e-05 |" in report.markdown(
        bench()
    )
    assert "lambert+ggx              139" in report.text(bench())
    assert "binds no process" in report.text(bench(one_core=False))
    assert json.loads(json.dumps(report.data(bench())))["absent"][0]["with"] == "lambert+ggx"


def test_without_mitsuba_the_report_says_so(monkeypatch):
    monkeypatch.setattr(mitsuba.importlib.util, "find_spec", lambda name: None)
    assert "not installed" in mitsuba.peers(["ggx"], 8, 1).note
    monkeypatch.undo()
    monkeypatch.setattr(mitsuba.importlib.util, "find_spec", lambda name: object())
    assert "none of these" in mitsuba.peers(["burley"], 8, 1).note


def test_what_mitsuba_did_before_it_died_is_kept(monkeypatch):
    row = {"plugin": "diffuse", "choices": "", "ours": 1.0, "theirs": 2.0, "median": 0.0, "largest": 0.0}
    out = "\n".join([json.dumps({"version": "9"}), "a warning", json.dumps({"lambert": row})])
    done = subprocess.CompletedProcess([], -6, out, "LLVM ERROR: Cannot select: fmaximum")
    monkeypatch.setattr(mitsuba.importlib.util, "find_spec", lambda name: object())
    monkeypatch.setattr(mitsuba.subprocess, "run", lambda *arguments, **options: done)
    found = mitsuba.peers(["lambert", "ggx"], 8, 1)
    assert found.rows == {"lambert": mitsuba.Peer(**row)}
    assert "Mitsuba 9" in found.note
    assert "n/a for ggx: LLVM ERROR" in found.note


def test_the_command_measures_and_binds_itself_to_a_core():
    brdf_command = pathlib.Path(sys.executable).parent / "brdf"
    command = [str(brdf_command), "bench", "models", "burley", "--points", "64", "--rounds", "1", "--json", "-q"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=120)
    assert done.returncode == 0, done.stderr
    found = json.loads(done.stdout)
    assert found["one_core"] == hasattr(os, "sched_setaffinity")
    assert found["models"]["burley"]["difference"] < 1e-12
    assert found["models"]["burley"]["value"] > 0
