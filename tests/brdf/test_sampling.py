"""Directions drawn from a model: their density is the one that is told, and it covers what the model reflects."""

import cases
import jax
import jax.numpy as jnp
import numpy as np
import pytest
import scipy.stats

from brdf import evaluate

every_model = pytest.mark.parametrize("expression", cases.EXPRESSIONS)
_BINS = 24
_DRAWS = 200_000


@jax.jit
def drawn(model, wo, u):
    return jax.vmap(model.sample, (None, 0))(wo, u)


@jax.jit
def densities(model, wo, wi):
    return jax.vmap(model.pdf, (0, None))(wi, wo)


def cells(wi):
    """The cell of each direction in an equal-area grid over the sphere."""
    row = np.minimum((0.5 * (1 + wi[:, 2]) * _BINS).astype(int), _BINS - 1)
    column = (np.arctan2(wi[:, 1], wi[:, 0]) / (2 * np.pi) % 1 * _BINS).astype(int)
    return row * _BINS + np.minimum(column, _BINS - 1)


def expected(model, wo, fine=24):
    """The share of each cell of the upper hemisphere, by the midpoint rule on a finer grid."""
    count = _BINS * fine
    z = 2 * (np.arange(count) + 0.5) / count - 1
    phi = 2 * np.pi * (np.arange(count) + 0.5) / count
    z, phi = (a.reshape(-1) for a in np.meshgrid(z[z > 0], phi, indexing="ij"))
    sine = np.sqrt(1 - z * z)
    wi = np.stack([sine * np.cos(phi), sine * np.sin(phi), z], axis=-1)
    pdf = np.asarray(densities(model, wo, wi))
    return np.bincount(cells(wi), pdf * (4 * np.pi / count**2), _BINS * _BINS)


@every_model
@pytest.mark.parametrize("theta", [0.3, 1.3])
def test_directions_are_drawn_with_the_density_that_is_told(expression, theta):
    # Oracle: chi-square over equal-area cells, those with few expected draws pooled, at a seeded p of 1e-4.
    rng = np.random.default_rng(21)
    model = cases.broad(cases.inside(cases.structures(expression)[-1], rng, 0.0))
    wo = np.array([np.sin(theta) * 0.8, np.sin(theta) * 0.6, np.cos(theta)])
    wi = np.asarray(drawn(model, wo, rng.random((_DRAWS, 3))))
    np.testing.assert_allclose(np.linalg.norm(wi, axis=1), 1, rtol=1e-9)
    above = wi[:, 2] > 0
    seen = np.bincount(cells(wi[above]), minlength=_BINS * _BINS)
    told = expected(model, wo) * _DRAWS
    # A narrow lobe fills few cells, whose midpoint rule is not exact: compare their sums alone.
    enough = told > 50
    seen = np.append(seen[enough], _DRAWS - seen[enough].sum())
    told = np.append(told[enough], _DRAWS - told[enough].sum())
    keep = told > 5
    # The midpoint rule's own error, half a percent of a cell, adds to the noise.
    statistic = np.sum((seen[keep] - told[keep]) ** 2 / (told[keep] + (0.005 * told[keep]) ** 2))
    assert scipy.stats.chi2.sf(statistic, keep.sum() - 1) > 1e-4


@every_model
def test_what_a_model_reflects_is_covered(expression):
    # Oracle: quadrature over the draws equals the mean of value over density: no direction is left out, and no draw
    # carries more than a hundred times the mean weight.
    rng = np.random.default_rng(22)
    for model in cases.models(expression, 23, 1)[:3]:
        wo = np.array([0.6, 0.0, 0.8])
        wi = np.asarray(drawn(model, wo, rng.random((20_000, 3))))
        wi = wi[wi[:, 2] > 1e-6]
        value = np.asarray(evaluate(model, wi, np.broadcast_to(wo, wi.shape))).mean(axis=1) * wi[:, 2]
        weight = value / np.asarray(densities(model, wo, wi))
        assert np.isfinite(weight).all()
        assert weight.max() <= max(100 * weight.mean(), 1e-9)


@every_model
def test_sampling_in_float32_is_finite(expression):
    rng = np.random.default_rng(24)
    _, wo = cases.pairs(25, 64)
    for model in cases.models(expression, 26, 1)[:2]:
        model = jax.tree.map(lambda leaf: jnp.asarray(leaf, jnp.float32), model)
        u = rng.random((64, 3), dtype=np.float32)
        wi = jax.jit(jax.vmap(model.sample))(wo.astype(np.float32), u)
        pdf = jax.jit(jax.vmap(model.pdf))(wi, wo.astype(np.float32))
        assert np.isfinite(np.asarray(wi)).all()
        assert np.isfinite(np.asarray(pdf)).all()
        assert (np.asarray(pdf) >= 0).all()
