"""Drawing directions in GLSL against the Python twin, on the same rounded numbers."""

from __future__ import annotations

from typing import Any

import jax
import numpy as np
import pytest
from directions import adversarial_pairs

import brdf
from brdf.parameter import choices, parameters
from brdf.registry import combine, split

pytestmark = pytest.mark.gpu
EXPRESSIONS = [*brdf.MODELS, "lambert+ggx", "oren_nayar+beckmann+ggx"]


def _model(expression: str) -> brdf.AbstractBRDF:
    """The model with its last options, among them anisotropic slopes, and random parameters that float32 holds."""
    rng = np.random.default_rng(33)
    lobes = {}
    for name, lobe in split(brdf.build(expression)).items():
        values: dict[str, Any] = {choice.name: choice.options[-1] for choice in choices(lobe)}
        for one in parameters(type(lobe)):
            # Broad enough that a rounding of the direction does not decide the density.
            low = max(one.lower, 0.1) if one.slope or "roughness" in one.name else one.lower
            high = min(one.upper, 100.0)
            value = rng.uniform(low, high, one.size).astype(np.float32).astype(np.float64)
            values[one.name] = value if one.size == 3 else value[0]
        lobes[name] = type(lobe)(**values)
    return combine(lobes)


@pytest.mark.parametrize("weight", [0.0, 0.5])
def test_where_nothing_is_proposed_the_cosine_is_drawn(weight: float):
    # Oracle: the mean cosine of a cosine-weighted hemisphere, 2/3; a facet without reflectance proposes nothing.
    from shaders import pdf, sample

    model = brdf.MODELS["ggx"](f0=np.full(3, weight), alpha=0.8)
    u = np.random.default_rng(34).random((4000, 3), dtype=np.float32)
    wo = np.broadcast_to(np.array([0.0, 0.0, 1.0], np.float32), u.shape)
    for drawn in (
        sample(model, wo, u),
        np.asarray(jax.vmap(model.sample)(wo.astype(np.float64), u.astype(np.float64))),
    ):
        assert (abs(drawn[:, 2].mean() - 2 / 3) < 0.01) == (weight == 0)
    down = np.array([[0.0, 0.6, 0.8]], np.float32)
    if weight == 0:
        np.testing.assert_allclose(pdf(model, down, wo[:1]), 0.8 / np.pi, rtol=1e-6)


@pytest.mark.parametrize("expression", EXPRESSIONS)
def test_directions_and_densities_are_those_of_python(expression: str):
    from shaders import pdf, sample

    model = _model(expression)
    rng = np.random.default_rng(31)
    wi, wo = adversarial_pairs(32, 0.3, 400)
    wo[:, 2] = np.maximum(wo[:, 2], 1e-6)
    u = rng.random(wo.shape, dtype=np.float32)
    exact = jax.jit(jax.vmap(model.sample))(wo.astype(np.float64), u.astype(np.float64))
    drawn = sample(model, wo, u)
    # GLSL's sine and cosine promise 2^-11; a number beside the border of two parts may choose the other one.
    distance = np.linalg.norm(drawn - np.asarray(exact), axis=1)
    assert np.mean(distance > 2e-3) < 0.003
    np.testing.assert_allclose(np.linalg.norm(drawn, axis=1), 1, atol=1e-5)
    truth = np.asarray(jax.jit(jax.vmap(model.pdf))(wi.astype(np.float64), wo.astype(np.float64)))
    found = pdf(model, wi, wo)
    assert np.isfinite(found).all()
    counted = truth > 1e-30
    error = np.abs(found[counted] - truth[counted]) / truth[counted]
    # The weights of the proposals are fitted albedos, some of them differences.
    assert error.max() < 1e-4
