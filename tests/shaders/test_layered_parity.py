"""The layered models in GLSL, float32, against JAX in float64, over their whole parameter boxes."""

from __future__ import annotations

import dataclasses
from typing import Any

import jax
import numpy as np
import pytest
from directions import adversarial_pairs
from numpy.typing import NDArray

import brdf
from brdf.model import AbstractBRDF
from brdf.parameter import choices, parameters

pytestmark = pytest.mark.gpu

# Half vectors of the pairs reach 9.5 times these slopes.
SLOPES = (0.3, 0.1, 0.01, 1e-3, 1.0)


def _rounded(model: AbstractBRDF) -> AbstractBRDF:
    """A model whose values float32 holds exactly, in float64."""
    return jax.tree.map(lambda leaf: np.asarray(leaf, np.float32).astype(np.float64), model)


def _box(name: str, seed: int, count: int) -> list[AbstractBRDF]:
    """Models with each value at a corner of its bounds, in three of ten cases, or between them."""
    rng = np.random.default_rng(seed)
    found = []
    for _ in range(count):
        values: dict[str, Any] = {}
        for p in parameters(brdf.MODELS[name]):
            corner, inner = rng.choice([p.lower, p.upper], p.size), rng.uniform(p.lower, p.upper, p.size)
            values[p.name] = np.where(rng.random(p.size) < 0.3, corner, inner).squeeze()
        for choice in choices(brdf.MODELS[name]):
            values[choice.name] = str(rng.choice(choice.options))
        found.append(_rounded(brdf.MODELS[name](**values)))
    return found


def _both(model: AbstractBRDF, wi: Any, wo: Any) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    from shaders import evaluate

    value = evaluate(model, wi, wo).astype(np.float64)
    assert np.isfinite(value).all()
    assert (value >= 0).all()
    return value, _truth(model, wi, wo)


def _truth(model: AbstractBRDF, wi: Any, wo: Any) -> NDArray[np.float64]:
    return np.asarray(brdf.evaluate(model, wi.astype(np.float64), wo.astype(np.float64)))


# What a value may be a difference of, to which the error is compared as well: the base that a full sheen hides, and
# Schlick's term that a metal's tint takes away.
MINUENDS = {"disney": {}, "gltf": {"sheen_color": np.zeros(3)}, "openpbr": {"specular_color": np.ones(3)}}
# Turning the tangent frame rounds the directions: a thin slice of them, across a slope of 1e-4, loses two digits.
BOUNDS = {"disney": 5e-6, "gltf": 1e-4, "openpbr": 1e-4}


@pytest.mark.parametrize("name", list(MINUENDS))
def test_layered_models_agree_with_float64_over_their_boxes(name: str):
    errors = []
    for number, model in enumerate(_box(name, 40, 24)):
        wi, wo = adversarial_pairs(number, SLOPES[number % len(SLOPES)], 500)
        value, truth = _both(model, wi, wo)
        minuend = _truth(dataclasses.replace(model, **MINUENDS[name]), wi, wo)
        # Below 1e-6 of a radiance nothing is left to see, and exponentials of 1 / alpha lose digits.
        errors.append(np.abs(value - truth) / np.maximum(truth + 0.1 * minuend, 1e-6))
    assert np.max(errors) <= BOUNDS[name]
    assert np.quantile(errors, 0.9999) <= 5e-6


@pytest.mark.parametrize("name", list(MINUENDS))
def test_each_parameter_reaches_its_own_place_in_the_shader(name: str):
    # A swap of two parameters would show: every value is its own, all layers are on, and each is moved alone.
    spread = np.linspace(0.25, 0.75, len(parameters(brdf.MODELS[name])))
    values = {
        p.name: p.lower + (p.upper - p.lower) * (s * np.array([0.7, 1.0, 1.3]) if p.kind == "color" else s)
        for p, s in zip(parameters(brdf.MODELS[name]), spread, strict=True)
    }
    wi, wo = adversarial_pairs(7, 0.3, 40)
    start = brdf.MODELS[name](**values)
    base = _truth(_rounded(start), wi, wo)
    for p in parameters(start):
        moved = _rounded(dataclasses.replace(start, **{p.name: 0.9 * values[p.name]}))
        value, truth = _both(moved, wi, wo)
        assert np.max(np.abs(truth - base) / (truth + 1e-6)) > 1e-3
        np.testing.assert_allclose(value, truth, rtol=2e-5, atol=1e-6)


def test_disney_agrees_for_both_masking_remaps():
    wi, wo = adversarial_pairs(8, 0.1, 500)
    for choice in choices(brdf.MODELS["disney"]):
        for option in choice.options:
            model = _rounded(dataclasses.replace(brdf.MODELS["disney"](), **{choice.name: option}))
            value, truth = _both(model, wi, wo)
            np.testing.assert_allclose(value, truth, rtol=5e-6, atol=1e-12)


@pytest.mark.parametrize("expression", ["disney+gltf+openpbr", "eon+openpbr", "ggx+gltf", "burley+disney"])
def test_layered_models_share_a_shader_with_others(expression: str):
    # Oracle: the sum in float64; names of functions and constants must not meet.
    wi, wo = adversarial_pairs(9, 0.3, 200)
    value, truth = _both(_rounded(brdf.build(expression)), wi, wo)
    np.testing.assert_allclose(value, truth, rtol=2e-5, atol=1e-6)
