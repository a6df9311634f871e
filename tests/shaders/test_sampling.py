"""Drawing directions in GLSL against the Python twin, on the same rounded numbers."""

from __future__ import annotations

import jax
import numpy as np
import pytest
from directions import adversarial_pairs

import brdf
from brdf.parameter import choices

pytestmark = pytest.mark.gpu
EXPRESSIONS = [*brdf.MODELS, "lambert+ggx", "oren_nayar+beckmann+ggx"]


def _model(expression: str) -> brdf.AbstractBRDF:
    """The model with its last options, among them anisotropic slopes."""
    model = brdf.build(expression)
    if "+" in expression:
        return model
    return type(model)(**{choice.name: choice.options[-1] for choice in choices(model)})


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
