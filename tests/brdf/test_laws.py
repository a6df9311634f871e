"""Laws that every registered model keeps; the oracle is the law itself."""

import dataclasses

import cases
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from brdf import MODELS, evaluate, parameters
from brdf.frame import geometry
from brdf.integrate import albedo
from brdf.registry import split

every_model = pytest.mark.parametrize("expression", cases.EXPRESSIONS)
every_lobe = pytest.mark.parametrize("name", list(MODELS))


def as_float32(model):
    return jax.tree.map(lambda leaf: np.asarray(leaf, np.float32), model)


@every_model
def test_values_are_finite_and_never_negative(expression):
    wi, wo = cases.pairs(1, 4000)
    for model in cases.models(expression, 2, 8):
        for cast in (np.float64, np.float32):
            part = model if cast is np.float64 else as_float32(model)
            value = np.asarray(evaluate(part, wi.astype(cast), wo.astype(cast)))
            assert value.dtype == cast
            assert np.isfinite(value).all()
            assert (value >= 0).all()


@every_model
def test_float32_agrees_with_float64(expression):
    # Oracle: the same model in float64 on the same rounded numbers.
    wi, wo = (w.astype(np.float32) for w in cases.pairs(13, 4000))
    for model in cases.models(expression, 14, 8):
        model = as_float32(model)
        value = np.asarray(evaluate(model, wi, wo))
        exact = jax.tree.map(lambda leaf: leaf.astype(np.float64), model)
        truth = np.asarray(evaluate(exact, wi.astype(np.float64), wo.astype(np.float64)))
        # Beckmann's exponent, up to 100, carries a few roundings of 6e-8 each; Oren-Nayar is cut at 0.
        np.testing.assert_allclose(value, truth, rtol=1e-4, atol=2e-6)


@every_model
def test_exchanging_the_directions_changes_nothing(expression):
    wi, wo = cases.pairs(3, 2000)
    for model in cases.models(expression, 4, 4):
        if all(lobe.is_reciprocal for lobe in split(model).values()):
            forth, back = np.asarray(evaluate(model, wi, wo)), np.asarray(evaluate(model, wo, wi))
            # Rounding alone: a sharp lobe turns one ulp of a direction into alpha^-1 of them.
            np.testing.assert_allclose(forth, back, rtol=1e-9, atol=1e-300)


@every_model
def test_nothing_is_reflected_below_the_horizon(expression):
    wi, wo = cases.pairs(5, 64)
    below = wo * [1, 1, -1]
    model = cases.models(expression, 6, 2)[1]
    assert (np.asarray(evaluate(model, wi, below)) == 0).all()
    assert (np.asarray(evaluate(model, below, wi)) == 0).all()
    assert (np.asarray(evaluate(model, below, below)) == 0).all()


@every_lobe
def test_no_model_reflects_more_than_it_claims(name):
    white = {p.name: np.full(p.size, p.upper).squeeze() for p in parameters(MODELS[name]) if p.kind == "color"}
    for model in cases.models(name, 7, 4):
        model = dataclasses.replace(model, **white)
        # Quadrature resolves lobes down to this slope.
        sharp = [p.name for p in parameters(model) if p.slope]
        model = dataclasses.replace(model, **{p: np.maximum(getattr(model, p), 0.1) for p in sharp})
        for theta in (0.0, 0.5, 1.0, 1.4):
            assert float(np.max(albedo(model, theta))) <= model.albedo_max * (1 + 1e-6)


def test_white_lambert_reflects_everything():
    np.testing.assert_allclose(albedo(MODELS["lambert"](albedo=1.0), 0.7), 1, rtol=1e-10)


@every_model
def test_gradients_are_finite_everywhere(expression):
    wi, wo = cases.pairs(8, 1000)

    @jax.jit
    def gradients(model, wi, wo):
        by = jax.vmap(jax.grad(lambda model, wi, wo: model(wi, wo).sum(), argnums=(0, 1, 2)), (None, 0, 0))
        return by(model, wi, wo)

    for model in cases.models(expression, 9, 5):
        for cast in (np.float64, np.float32):
            part = jax.tree.map(lambda leaf, cast=cast: jnp.asarray(leaf, cast), model)
            for leaf in jax.tree.leaves(gradients(part, wi.astype(cast), wo.astype(cast))):
                assert np.isfinite(np.asarray(leaf)).all()


@every_model
def test_parameter_gradients_equal_central_differences(expression):
    rng = np.random.default_rng(10)
    model = cases.models(expression, 11, 3)[2]
    # Away from grazing and from exact special directions, inside the bounds: where differences are accurate.
    wi, wo = (cases.directions(rng, 400) for _ in range(2))
    keep = (wi[:, 2] > 0.15) & (wo[:, 2] > 0.15)
    wi, wo = wi[keep], wo[keep]
    lobes = {}
    for lobe, part in split(model).items():
        inside = {}
        for p in parameters(part):
            inside[p.name] = np.clip(getattr(part, p.name), p.lower + 0.1 * p.upper, 0.9 * p.upper)
        lobes[lobe] = dataclasses.replace(part, **inside)
    from brdf.registry import combine

    model = combine(lobes)
    leaves, structure = jax.tree.flatten(model)
    _, push = jax.linearize(lambda *leaves: evaluate(structure.unflatten(leaves), wi, wo), *map(jnp.asarray, leaves))
    step = 1e-5
    for place, leaf in enumerate(leaves):
        for element in range(np.size(leaf)):
            tangent = [np.zeros(np.shape(x)) for x in leaves]
            tangent[place].reshape(-1)[element] = 1.0
            up = [x + step * t for x, t in zip(leaves, tangent, strict=True)]
            down = [x - step * t for x, t in zip(leaves, tangent, strict=True)]
            difference = evaluate(structure.unflatten(up), wi, wo) - evaluate(structure.unflatten(down), wi, wo)
            exact = np.asarray(push(*map(jnp.asarray, tangent)))
            # Truncation is step^2 times the third derivative, which for slopes >= 0.1 is below 1e5 of the value.
            np.testing.assert_allclose(np.asarray(difference) / (2 * step), exact, rtol=1e-4, atol=1e-6)


def test_half_vector_survives_opposite_directions():
    g = geometry(jnp.array([1.0, 0.0, 1e-8]), jnp.array([-1.0, 0.0, 1e-8]))
    assert float(g.h2) > 0
    assert abs(float(g.cos_d)) < 1e-7
