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
from brdf.registry import combine, split

every_model = pytest.mark.parametrize("expression", cases.EXPRESSIONS)
every_lobe = pytest.mark.parametrize("name", list(MODELS))


@every_model
def test_exchanging_the_directions_changes_nothing(expression):
    wi, wo = cases.pairs(3, 1000)
    for model in cases.models(expression, 4, 2):
        if model.claims().reciprocal:
            forth, back = np.asarray(evaluate(model, wi, wo)), np.asarray(evaluate(model, wo, wi))
            # Rounding alone: a sharp lobe turns one ulp of a direction into alpha^-1 of them.
            np.testing.assert_allclose(forth, back, rtol=1e-9, atol=1e-300)


@every_model
def test_nothing_is_reflected_below_the_horizon(expression):
    wi, wo = cases.pairs(5, 1000)
    below = wo * [1, 1, -1]
    model = cases.models(expression, 6, 2)[0]
    assert (np.asarray(evaluate(model, wi, below)) == 0).all()
    assert (np.asarray(evaluate(model, below, wi)) == 0).all()
    assert (np.asarray(evaluate(model, below, below)) == 0).all()


@every_lobe
def test_no_model_reflects_more_than_it_claims(name):
    white = {p.name: np.full(p.size, p.upper).squeeze() for p in parameters(MODELS[name]) if p.kind == "color"}
    for model in cases.models(name, 7, 2):
        model = cases.broad(dataclasses.replace(model, **white))
        for theta in (0.0, 0.8, 1.5):
            # Quadrature errs by 3e-5 where a model has kinks.
            assert float(np.max(albedo(model, theta))) <= model.claims().albedo_max * (1 + 3e-5)


def test_white_lambert_reflects_everything():
    np.testing.assert_allclose(albedo(MODELS["lambert"](albedo=1.0), 0.7), 1, rtol=1e-10)


@every_model
def test_parameter_gradients_equal_central_differences(expression):
    rng = np.random.default_rng(10)
    # Away from grazing and from exact special directions, inside the bounds: where differences are accurate.
    wi, wo = (cases.directions(rng, 1000) for _ in range(2))
    keep = (wi[:, 2] > 0.15) & (wo[:, 2] > 0.15)
    wi, wo = wi[keep], wo[keep]
    for model in cases.models(expression, 11, 1):
        lobes = {}
        for lobe, part in split(model).items():
            values = {}
            for p in parameters(part):
                margin = 0.1 * (p.upper - p.lower)
                values[p.name] = np.clip(getattr(part, p.name), p.lower + margin, p.upper - margin)
            lobes[lobe] = dataclasses.replace(part, **values)
        model = combine(lobes)
        differences(model, wi, wo)


def differences(model, wi, wo):
    """Holds the derivative along every live parameter to a central difference."""
    leaves, structure = jax.tree.flatten(model)
    live = [p.is_live(part) for part in split(model).values() for p in parameters(type(part))]

    @jax.jit
    def both(leaves, tangents, step):
        def value(*leaves):
            return evaluate(structure.unflatten(leaves), wi, wo)

        ends = [value(*(x + sign * step * t for x, t in zip(leaves, tangents, strict=True))) for sign in (1, -1)]
        return (ends[0] - ends[1]) / (2 * step), jax.jvp(value, leaves, tangents)[1]

    for place in np.flatnonzero(live):
        for element in range(np.size(leaves[place])):
            tangents = [np.zeros(np.shape(x)) for x in leaves]
            tangents[place].reshape(-1)[element] = 1.0
            difference, exact = (np.asarray(x) for x in both(leaves, tangents, 1e-5))
            # Truncation is step^2 times the third derivative, below 1e5 of the value; a kink between the two points, as
            # of max and min, is met by few pairs.
            error = np.abs(difference - exact)
            assert np.mean(error > 1e-4 * np.abs(exact) + 1e-6) < 0.003


def test_half_vector_survives_opposite_directions():
    g = geometry(jnp.array([1.0, 0.0, 1e-8]), jnp.array([-1.0, 0.0, 1e-8]))
    assert float(g.h2) > 0
    assert abs(float(g.cos_d)) < 1e-7
