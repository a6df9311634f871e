"""What the facets lose, and what multiple scattering gives back."""

import dataclasses

import jax
import numpy as np
import pytest

from brdf import build, evaluate
from brdf.chebyshev import interpolate
from brdf.energy import fresnel_average, loss_table, mean_loss_table
from brdf.fresnel import f_schlick
from brdf.integrate import albedo

DISTRIBUTIONS = ["ggx", "beckmann", "gaussian"]


@pytest.mark.parametrize("name", DISTRIBUTIONS)
@pytest.mark.parametrize("alpha", [0.15, 0.3, 0.6, 1.0])
def test_a_white_furnace_is_invisible_with_multiple_scattering(name, alpha):
    # Oracle: energy conservation of a facet that reflects everything.
    model = dataclasses.replace(build(name), alpha=np.float64(alpha), f0=np.ones(3), energy="multiple")
    for theta in (0.0, 0.6, 1.2):
        np.testing.assert_allclose(albedo(model, theta), 1, atol=6e-3)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
@pytest.mark.parametrize("alpha", [1e-4, 1e-3, 0.01, 0.05])
def test_a_white_furnace_is_invisible_for_narrow_lobes_too(name, alpha):
    # Oracle: energy conservation; the integral is the mean of value over density at seeded draws of the model itself.
    model = dataclasses.replace(build(name), alpha=np.float64(alpha), f0=np.ones(3), energy="multiple")
    u = np.random.default_rng(71).random((40_000, 3))
    for theta in (0.2, 1.3):
        wo = np.array([np.sin(theta), 0.0, np.cos(theta)])
        wi = np.asarray(jax.jit(jax.vmap(model.sample, (None, 0)))(wo, u))
        value = np.asarray(evaluate(model, wi, np.broadcast_to(wo, wi.shape)))[:, 0] * np.maximum(wi[:, 2], 0)
        pdf = np.asarray(jax.jit(jax.vmap(model.pdf, (0, None)))(wi, wo))
        weight = np.where(wi[:, 2] > 0, value / np.where(pdf > 0, pdf, 1), 0)
        assert weight.mean() == pytest.approx(1, abs=1e-2)


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_narrow_lobes_lose_nothing_and_broad_ones_much(name):
    narrow, broad = (float(mean_loss_table(name)(np.asarray(alpha))) for alpha in (1e-3, 1.0))
    assert narrow < 6e-3
    assert 0.1 < broad < 0.7


@pytest.mark.parametrize("name", DISTRIBUTIONS)
def test_the_loss_table_equals_the_albedo_of_the_model(name):
    # Oracle: the tensor-product quadrature of integrate.albedo, another rule over other directions.
    model = dataclasses.replace(build(name), alpha=np.float64(0.4), f0=np.ones(3))
    for cosine in (0.2, 0.6, 1.0):
        reduced = cosine * 1.4 / (cosine + 0.4)
        loss = float(loss_table(name)(np.asarray(reduced), np.asarray(0.4)))
        assert loss == pytest.approx(1 - float(albedo(model, np.arccos(cosine))[0]), abs=2e-3)


def test_the_mean_of_schlick_is_exact():
    # Oracle: 2 int (f0 + (1 - f0) (1 - c)^5) c dc = f0 + (1 - f0) / 21.
    f0 = np.array([0.04, 0.5, 1.0])
    mean = fresnel_average(lambda cos_d, one_minus: f_schlick(f0, one_minus), np.asarray(0.3))
    np.testing.assert_allclose(mean, f0 + (1 - f0) / 21, rtol=1e-14)


def test_chebyshev_tables_converge_geometrically():
    # Oracle: the function itself.
    x, y = 0.3, 0.85
    table = interpolate(lambda x, y: np.exp(x) / (2 + y), 14, 14)
    assert float(table(np.asarray(x), np.asarray(y))) == pytest.approx(np.exp(x) / (2 + y), rel=1e-9)
    line = interpolate(np.cos, 12)
    assert float(line(np.asarray(x))) == pytest.approx(np.cos(x), rel=1e-11)
