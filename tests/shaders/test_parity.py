"""GLSL in float32 against the Python model in float64, on the same rounded directions and parameters."""

from __future__ import annotations

import dataclasses
from typing import Any

import moderngl
import numpy as np
import pytest
from directions import adversarial_pairs
from numpy.typing import NDArray

import brdf
from brdf.microfacet import AbstractMicrofacet
from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters
from brdf.registry import combine, split

pytestmark = pytest.mark.gpu

# Below it float32 itself has fewer digits; a factor of the value underflows earlier at slopes that have no bar.
_NORMAL = 1e-36
MICROFACETS = [name for name in brdf.MODELS if issubclass(brdf.MODELS[name], AbstractMicrofacet)]
ALPHAS = [1e-4, 1e-3, 1e-2, 0.03, 0.1, 0.3, 0.5, 1.0]
UNEQUAL = [0.02, 0.5, 0.97]


def _rounded(value: Any) -> NDArray[np.float64]:
    """A value that float32 holds exactly, in float64."""
    return np.asarray(value, np.float32).astype(np.float64)


def _truth(model: AbstractBRDF, wi: NDArray[np.float32], wo: NDArray[np.float32]) -> NDArray[np.float64]:
    return np.asarray(brdf.evaluate(model, wi.astype(np.float64), wo.astype(np.float64)))


def _glsl(model: AbstractBRDF, wi: NDArray[np.float32], wo: NDArray[np.float32]) -> NDArray[np.float32]:
    from shaders import evaluate

    value = evaluate(model, wi, wo)
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    return value


def _worst(value: NDArray[np.float32], truth: NDArray[np.float64], floor: float) -> float:
    counted = truth > floor
    assert counted.sum() > 1000
    return float(np.max(np.abs(value[counted] - truth[counted]) / truth[counted]))


def _covering(name: str) -> list[dict[str, str]]:
    """Combinations of static choices in which every option of each occurs."""
    declared = choices(brdf.MODELS[name])
    rounds = max((len(choice.options) for choice in declared), default=1)
    return [{choice.name: choice.options[n % len(choice.options)] for choice in declared} for n in range(rounds)]


def _unequal(name: str, alpha: float, **chosen: str) -> AbstractBRDF:
    """A model with every slope at or beside `alpha` and all else inside its bounds, no two channels equal."""
    values: dict[str, Any] = dict(chosen)
    for parameter in parameters(brdf.MODELS[name]):
        low, high = parameter.lower, parameter.upper
        if parameter.slope:
            values[parameter.name] = _rounded(np.clip(alpha * (0.7 if parameter.name == "alpha_x" else 1.0), low, high))
        elif parameter.kind == "color":
            values[parameter.name] = _rounded(low + (high - low) * np.array(UNEQUAL))
        else:
            values[parameter.name] = _rounded(low + 0.6 * (high - low))
    return brdf.MODELS[name](**values)


# Rounding of an exponent, up to 83, multiplied into the value.
_BOUNDS = {"ggx": 2e-6, "beckmann": 2e-6, "gtr": 2e-5, "gaussian": 3e-5}


def _bound(name: str, chosen: dict[str, str]) -> float:
    if chosen["fresnel"] == "schlick_f82":
        # A dark tint is cut at 0, beside which there is no relative accuracy.
        return 5e-3
    if chosen.get("energy") == "multiple":
        # Far from the highlight a table's difference is all there is.
        return 5e-5
    return _BOUNDS[name]


@pytest.mark.parametrize("name", MICROFACETS)
def test_microfacets_agree_with_float64_for_every_choice(name: str):
    for chosen in _covering(name):
        for alpha in ALPHAS:
            wi, wo = adversarial_pairs(1, alpha, 1000)
            model = _unequal(name, alpha, **chosen)
            error = _worst(_glsl(model, wi, wo), _truth(model, wi, wo), _NORMAL)
            assert error <= _bound(name, chosen), (chosen, alpha)


@pytest.mark.parametrize("sigma", [0.0, 0.05, 0.35, 1.0, 1.57])
def test_oren_nayar_agrees_with_float64_down_to_grazing(sigma: float):
    wi, wo = adversarial_pairs(3, 0.3, 4000)
    albedo = _rounded([0.1, 0.5, 0.9])
    model = brdf.MODELS["oren_nayar"](albedo=albedo, sigma=_rounded(sigma))
    truth = _truth(model, wi, wo)
    # The model is a difference that is cut at 0: near the cut the error is measured against a twentieth of albedo/pi.
    error = np.abs(_glsl(model, wi, wo) - truth) / np.maximum(truth, 0.05 * albedo / np.pi)
    assert error.max() <= 1e-5


def test_lambert_agrees_to_one_rounding():
    wi, wo = adversarial_pairs(4, 0.3, 1000)
    model = brdf.MODELS["lambert"](albedo=_rounded(UNEQUAL))
    assert _worst(_glsl(model, wi, wo), _truth(model, wi, wo), 0) <= 3e-7


@pytest.mark.parametrize("expression", ["lambert+ggx", "oren_nayar+beckmann", "ggx+beckmann+ggx+lambert"])
def test_a_sum_agrees_with_float64(expression: str):
    lobes: dict[str, AbstractBRDF] = {}
    for number, (name, lobe) in enumerate(split(brdf.build(expression)).items()):
        values: dict[str, Any] = {}
        for parameter in parameters(lobe):
            # Every lobe and channel its own: a swap would show.
            spread = np.array([0.2, 0.35, 0.6]) / (1 + number)
            values[parameter.name] = _rounded(spread if parameter.kind == "color" else 0.1 + 0.07 * number)
        lobes[name] = dataclasses.replace(lobe, **values)
    model = combine(lobes)
    wi, wo = adversarial_pairs(5, 0.1, 4000)
    assert _worst(_glsl(model, wi, wo), _truth(model, wi, wo), _NORMAL) <= 5e-6


def test_two_lobes_of_one_model_keep_their_own_choices():
    first, second, *_ = choices(brdf.MODELS["ggx"])[0].options
    name = choices(brdf.MODELS["ggx"])[0].name
    wi, wo = adversarial_pairs(6, 0.5, 2000)
    lobes = {"ggx": _unequal("ggx", 0.5, **{name: first}), "ggx_2": _unequal("ggx", 0.7, **{name: second})}
    model = combine(lobes)
    assert _worst(_glsl(model, wi, wo), _truth(model, wi, wo), _NORMAL) <= 5e-6


def test_nothing_is_reflected_below_the_horizon():
    wi, wo = adversarial_pairs(7, 0.3, 100)
    model = brdf.build("lambert+ggx")
    down = np.array([1, 1, -1], np.float32)
    assert (_glsl(model, wi, np.abs(wo) * down) == 0).all()
    assert (_glsl(model, np.abs(wi) * down, wo) == 0).all()


def test_a_batch_of_any_size_loses_nothing(monkeypatch: pytest.MonkeyPatch):
    from shaders import evaluation

    monkeypatch.setattr(evaluation, "_CHUNK", 1000)
    wi, wo = adversarial_pairs(8, 0.3, 400)
    model = brdf.build("lambert+ggx")
    whole = _glsl(model, wi, wo)
    assert len(wi) % 1000 != 0
    assert _worst(whole, _truth(model, wi, wo), _NORMAL) <= 5e-6
    assert _glsl(model, wi[:0], wo[:0]).shape == (0, 3)
    np.testing.assert_array_equal(_glsl(model, wi[:1], wo[:1]), whole[:1])


def test_every_dispatch_is_followed_by_a_barrier_before_its_values_are_read(monkeypatch: pytest.MonkeyPatch):
    # Oracle: the rule of glMemoryBarrier. No driver here needs it, so only the order of the calls can be looked at.
    from shaders import evaluation

    calls: list[str] = []
    run, read, barrier = moderngl.ComputeShader.run, moderngl.Buffer.read, moderngl.Context.memory_barrier

    def spy(name: str, call: Any) -> Any:
        def called(self: Any, *arguments: Any) -> Any:
            calls.append(f"{name} {arguments[0]}" if name == "barrier" else name)
            return call(self, *arguments)

        return called

    monkeypatch.setattr(moderngl.ComputeShader, "run", spy("run", run))
    monkeypatch.setattr(moderngl.Buffer, "read", spy("read", read))
    monkeypatch.setattr(moderngl.Context, "memory_barrier", spy("barrier", barrier))
    monkeypatch.setattr(evaluation, "_CHUNK", 1000)
    wi, wo = adversarial_pairs(9, 0.3, 200)
    _glsl(brdf.build("ggx"), wi[:1500], wo[:1500])
    assert calls == ["run", f"barrier {moderngl.BUFFER_UPDATE_BARRIER_BIT}", "read"] * 2


def test_directions_of_the_wrong_shape_are_refused():
    from shaders import evaluate

    with pytest.raises(brdf.UserError, match=r"must both be \(n, 3\)"):
        evaluate(brdf.build("ggx"), np.zeros((4, 3)), np.zeros((5, 3)))
    with pytest.raises(brdf.UserError, match=r"must both be \(n, 3\)"):
        evaluate(brdf.build("ggx"), np.zeros(3), np.zeros(3))
