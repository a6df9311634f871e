"""`brdf bench fit`: every contestant minimises the same thing, and the page says what was measured."""

import dataclasses
import json
import math
import types

import jax
import numpy as np
import pytest
from click.testing import CliRunner

import fitter
from brdf.errors import UserError
from fitter.bench import adam, fit_plot, fit_report, fit_run, material, peers, resources
from fitter.bench.problem import LOSS, Problem
from fitter.bench.race import SAME, Race, Row, race
from fitter.cli.bench import command

SIZE = (6, 6, 12)


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    return fitter.read(material.table("lambert+ggx", SIZE, tmp_path_factory.mktemp("tables")))


@pytest.fixture(scope="module")
def raced(data):
    return race("tiny", Problem("ggx", data), peers.names(), 1, 60.0, lambda sentence: None)


def test_all_contestants_reach_the_same_final_cost(raced):
    run = {name: row for name, row in raced.rows.items() if not row.absent}
    # Oracle: one another, and the bounds.
    assert {peers.OURS, "scipy trf", "Optimistix LM"} <= set(run)
    assert {name: row.excess for name, row in run.items() if abs(row.excess) > SAME} == {}
    assert all(row.inside and not row.stopped and row.cpu > 0 for row in run.values())


def test_a_curve_falls_from_the_start_to_the_end(raced, data):
    problem = Problem("ggx", data)
    row = raced.rows["scipy trf"]
    seconds, excess = zip(*row.curve, strict=True)
    assert list(seconds) == sorted(seconds)
    assert list(excess) == sorted(excess, reverse=True)
    with jax.enable_x64(True):
        ratio = problem.cost(problem.start) / (1 + excess[0])
    # The first point is the start: its cost over its excess is the best cost, as of the last point.
    assert excess[-1] == pytest.approx(row.excess, abs=1e-12)
    with jax.enable_x64(True):
        end = fitter.fit("ggx", data, loss=LOSS, max_theta_deg=90.0)
        assert ratio == pytest.approx(problem.cost(problem.vector(end.brdf)), rel=SAME)


def test_the_judge_computes_the_cost_in_plain_numpy(data):
    problem = Problem("lambert", data)
    albedo = np.array([0.2, 0.3, 0.4])
    cosine = data.wi[:, 2:3]
    apart = np.log1p(albedo / np.pi * cosine) - np.log1p(data.value * cosine)
    with jax.enable_x64(True):
        assert problem.cost(albedo) == pytest.approx(0.5 * np.sum(apart**2), rel=1e-12)


def test_weights_count_as_their_share_of_the_mean(data):
    weight = np.linspace(1, 3, len(data))
    problem, plain = (Problem("lambert", one) for one in (dataclasses.replace(data, weight=weight), data))
    y = np.full(3, 0.3)
    with jax.enable_x64(True):
        squares = np.asarray(plain.compiled[0](y)).reshape(-1, 3) ** 2
        assert problem.cost(y) == pytest.approx(0.5 * np.sum(squares * weight[:, None] / weight.mean()), rel=1e-12)


def test_the_jacobian_is_that_of_finite_differences(data):
    problem, step = Problem("ggx", data), 1e-6
    with jax.enable_x64(True):
        residual, rows = problem.compiled
        found = np.asarray(rows(problem.start))
        for i, row in enumerate(found):
            move = step * np.eye(len(found))[i]
            expected = np.asarray(residual(problem.start + move) - residual(problem.start - move)) / (2 * step)
            # Second-order differences err by the step squared times the third derivative.
            np.testing.assert_allclose(row, expected, rtol=1e-5, atol=1e-7)


def test_a_vector_and_its_model_are_inverse_and_the_gauge_is_held(data):
    problem = Problem("disney", data)
    y = np.random.default_rng(1).uniform(0.2, 0.8, len(problem.start))
    with jax.enable_x64(True):
        np.testing.assert_array_equal(problem.vector(problem.brdf(y)), y)
    assert "metallic" not in problem.start_described()
    assert len(y) == 11
    assert problem.inside(y)
    assert not problem.inside(y + 1)


def test_two_lobes_of_a_kind_start_apart(data):
    assert "ggx.alpha 0.15" in (described := Problem("lambert+ggx+ggx", data).start_described())
    assert "ggx_2.alpha 0.5" in described


def test_an_absent_peer_is_a_row(monkeypatch, data):
    found = peers.importlib.util.find_spec
    monkeypatch.setattr(peers.importlib.util, "find_spec", lambda name: None if name == "pyceres" else found(name))
    rows = race("tiny", Problem("lambert", data), ["scipy trf", "Ceres"], 1, 60.0, lambda sentence: None).rows
    assert rows["Ceres"].absent == "not installed: pip install pyceres"
    assert rows["scipy trf"].absent == ""


def test_adam_knows_one_model(monkeypatch, data):
    assert adam.prepare(Problem("ggx", data)) is None
    monkeypatch.setattr(peers.importlib.util, "find_spec", lambda name: types.SimpleNamespace())
    assert peers.contestant("torch Adam", Problem("ggx", data)) == "no torch version of ggx"


def test_a_run_beyond_the_limit_is_stopped_and_not_repeated(data):
    said = []
    rows = race("tiny", Problem("lambert", data), ["scipy trf"], 3, 0.0, said.append).rows
    assert rows["scipy trf"].stopped
    assert sum("round" in sentence for sentence in said) == 1


def test_tables_are_reproducible_and_their_slices_are_theirs(tmp_path, data):
    again = fitter.read(material.table("lambert+ggx", SIZE, tmp_path))
    np.testing.assert_array_equal(again.value, data.value)
    other = fitter.read(material.table("lambert+ggx", SIZE, tmp_path, seed=1))
    assert not np.allclose(other.value, data.value, rtol=0.2)
    i, j, k = np.unravel_index(data.grid.index, SIZE)
    use = k == SIZE[2] // 2
    np.testing.assert_array_equal(material.slice_values(data)[j[use], i[use]], data.value[use])
    assert material.table_size(None) == (90, 90, 180)
    # Oracle: a table of that many samples above the horizon.
    assert len(fitter.read(material.table("ggx", material.table_size(2000), tmp_path))) == pytest.approx(2000, rel=0.2)


def test_the_line_through_points_on_a_line_is_that_line():
    found = resources.line([10, 100, 1000], [0.05 + 1e-4 * n for n in (10, 100, 1000)])
    assert found.intercept == pytest.approx(0.05)
    assert found.slope == pytest.approx(1e-4)
    assert found.deviation < 1e-9


def bench():
    curve = ((0.1, 10.0), (0.5, 1e-3), (2.0, 1e-9))
    rows = {
        peers.OURS: Row(0.5, 0.25, 0.0, curve=((0.0, 10.0), (0.5, 0.0))),
        "Optimistix LM": Row(20.0, 10.0, 2e-9, curve=curve),
        "lmfit": Row(30.0, stopped=True, excess=0.25, inside=False, curve=curve),
        "Ceres": Row(absent="not installed: pip install pyceres"),
    }
    races = [Race("ggx, table", "ggx", 1000, "made up", "ggx.alpha 0.2", rows, 3, 30.0)]
    return fit_report.FitBench(
        races=races,
        scaling=resources.Scaling(((10, 0.1), (20, 0.2)), 0.05, 2e-8, 0.03),
        memory=resources.Memory(700.0, 400.0, 200.0),
        process=resources.Process(3.0, 0.9, 0.6),
        many={
            "loop over Optimistix LM": resources.Throughput(2.0, 1.0),
            "fitter.fit_many": resources.Throughput(12.0, 1.9),
        },
        model="ggx",
        rounds=3,
        limit=30.0,
        materials=4,
    )


def test_reports_hold_the_figures():
    page = fit_report.markdown(bench(), "bench_fit.png")
    assert "| brdf-fitter | 0.5 | 0.25 | 1 | < 1e-12 |" in page
    assert "| Optimistix LM | 20 | 10 | 40 | 2e-09 |" in page
    assert "| lmfit | stopped after 30 |  | > 60 | 2e-01, out of bounds, not the same minimum |" in page
    assert "| Ceres | n/a |  |  | not installed: pip install pyceres |" in page
    assert "50 ms + 20 ns per sample" in page
    assert "1.50 times" in page
    assert "| fitter.fit_many | 12 | 1.90 | 6 |" in page
    assert "](bench_fit.png)" in page
    assert "loop over Optimistix LM" in fit_report.text(bench())
    held = json.loads(json.dumps(fit_report.data(bench()), allow_nan=False))
    assert held["races"][0]["rows"]["Ceres"]["cpu"] is None


def test_the_picture_shows_every_contestant_that_ran(tmp_path):
    path = tmp_path / "bench.svg"
    fit_plot.plot(bench().races, path)
    drawn = path.read_text()
    assert len(drawn) > 10_000
    assert math.isclose(drawn.count("<svg"), 1)


def test_the_command_passes_its_options_on(monkeypatch):
    asked = []
    monkeypatch.setattr(fit_run, "bench", lambda settings, say: asked.append(settings) or bench())
    done = CliRunner().invoke(command, ["fit", "--quick", "--only", "table", "-m", "ggx", "-q"], catch_exceptions=False)
    assert "Optimistix LM" in done.output
    assert asked == [fit_run.Settings(None, ("ggx",), 30_000, 1, 30.0, 4, ("table",))]
    with pytest.raises(UserError, match="exclude each other"):
        CliRunner().invoke(command, ["fit", "--json", "--markdown"], catch_exceptions=False)
    with pytest.raises(UserError, match="--samples 500"):
        CliRunner().invoke(command, ["fit", "gold.binary", "--samples", "500"], catch_exceptions=False)
