"""`general_gtr`: what its free width and free rise mean, against closed forms and the models that it generalises."""

import cases
import jax
import numpy as np
import pytest

from brdf import MODELS, evaluate

GeneralGTR = MODELS["general_gtr"]
F0, F90 = np.array([0.02, 0.5, 0.97]), np.array([0.9, 0.3, 0.0])


def tilted(tilt, theta_d):
    """`wi` and `wo`, (n, 3), at `theta_d` on either side of half vectors tilted by `tilt` across their plane."""
    sine, cosine = np.sin(theta_d), np.cos(theta_d)
    side = np.stack([sine + 0 * tilt, cosine * np.sin(tilt), cosine * np.cos(tilt)], axis=-1)
    return side, side * [-1, 1, 1]


@pytest.mark.parametrize("gamma", [0.5, 1.0, 3.0])
def test_without_spread_and_with_schlicks_power_it_is_gtr(gamma):
    wi, wo = cases.pairs(71, 1000)
    gtr = MODELS["gtr"](f0=F0, f90=F90, alpha=0.2, gamma=gamma, masking="v_cavity", fresnel="schlick_f90")
    value = evaluate(GeneralGTR(f0=F0, f90=F90, alpha=0.2, gamma=gamma), wi, wo)
    np.testing.assert_allclose(value, evaluate(gtr, wi, wo), rtol=1e-12, atol=1e-300)


@pytest.mark.parametrize("spread", [-1.0, -0.3, 0.5, 1.0])
def test_the_highlight_widens_as_that_power_of_the_cosine(spread):
    # Oracle: at 60 degrees, a tilt that is 2^spread times as large lowers the value by the same share.
    alpha, gamma = 1e-3, 1.5
    model = GeneralGTR(f0=1.0, alpha=alpha, gamma=gamma, spread=spread)
    shares = []
    for theta_d, scale in ((0.0, 1.0), (np.pi / 3, 2**spread)):
        value = np.asarray(evaluate(model, *tilted(scale * np.array([0.0, 0.5 * alpha, 2 * alpha]), theta_d)))[:, 0]
        shares.append(value / value[0])
    # The cosines of the tilt, of a few alpha, enter the visibility.
    np.testing.assert_allclose(shares[0], shares[1], rtol=20 * alpha**2)
    expected = (1 + np.array([0.0, 0.25, 4.0])) ** -gamma
    np.testing.assert_allclose(shares[0], expected, rtol=20 * alpha**2)


@pytest.mark.parametrize("spread", [-1.0, 0.0, 1.0])
def test_a_narrow_highlight_holds_its_reflectance_however_it_widens(spread):
    # Oracle: a mirror of that reflectance; the mean of value / density over the model's own samples.
    model = GeneralGTR(f0=0.3, f90=0.8, alpha=1e-4, gamma=3.0, spread=spread, falloff=2.0)
    wo = np.array([0.6, 0.0, 0.8])
    wi = np.asarray(jax.jit(jax.vmap(model.sample, (None, 0)))(wo, np.random.default_rng(72).random((20_000, 3))))
    value = np.asarray(evaluate(model, wi, np.broadcast_to(wo, wi.shape)))[:, 0] * wi[:, 2]
    pdf = np.asarray(jax.jit(jax.vmap(model.pdf, (0, None)))(wi, wo))
    # Twenty thousand draws tell it to a percent.
    assert np.mean(value / pdf) == pytest.approx(0.3 + 0.5 * 0.2**2, rel=0.02)


@pytest.mark.parametrize("falloff", [0.5, 3.3, 10.0])
def test_the_reflectance_rises_as_that_power(falloff):
    theta_d = np.array([0.0, 1e-3, 0.5, 1.2, 1.57])
    model = GeneralGTR(f0=F0, f90=F90, alpha=1.0, falloff=falloff)
    value = np.asarray(evaluate(model, *tilted(np.zeros(5), theta_d)))
    # alpha = 1: D is 1 / pi, and V-cavities hide nothing at theta_h = 0.
    versine = 2 * np.sin(0.5 * theta_d[:, None]) ** 2
    expected = (F0 + (F90 - F0) * versine**falloff) / (4 * np.pi * np.cos(theta_d[:, None]) ** 2)
    # The rise is cut at 1e-18^falloff.
    np.testing.assert_allclose(value, expected, rtol=1e-7)


@pytest.mark.parametrize("spread", [-1.0, 0.5, 1.0])
def test_a_wide_highlight_keeps_the_norm_of_its_width(spread):
    # Oracle: Berry's norm in closed form, D(0) = b / (pi log(1 + b)), at the width of that angle.
    model = GeneralGTR(f0=1.0, f90=1.0, alpha=0.3, gamma=1.0, spread=spread)
    value = np.asarray(evaluate(model, *tilted(np.zeros(1), np.pi / 3)))[0, 0]
    b = (1 / 0.09 - 1) * 0.5 ** (2 * spread)
    assert value == pytest.approx(b / (np.pi * np.log1p(b)) / (4 * 0.25), rel=1e-10)
