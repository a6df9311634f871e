"""What models become at the ends of their parameters: one another, a mirror, the sum of their parts."""

import dataclasses

import cases
import jax
import jax.numpy as jnp
import numpy as np
import pytest

from brdf import MODELS, build, evaluate
from brdf.frame import geometry
from brdf.microfacet import AbstractMicrofacet
from brdf.registry import combine, split

MICROFACETS = [name for name in MODELS if issubclass(MODELS[name], AbstractMicrofacet)]
every_microfacet = pytest.mark.parametrize("name", MICROFACETS)


@every_microfacet
def test_equal_slopes_are_the_isotropic_model_however_turned(name):
    wi, wo = cases.pairs(51, 1000)
    one = dataclasses.replace(build(name), alpha=np.float64(0.3))
    two = MODELS[name](alpha_x=0.3, alpha_y=0.3, rotation=0.7, anisotropy="anisotropic")
    np.testing.assert_allclose(evaluate(two, wi, wo), evaluate(one, wi, wo), rtol=1e-9, atol=1e-290)


@every_microfacet
def test_exchanging_the_slopes_turns_the_lobe_by_a_right_angle(name):
    wi, wo = cases.pairs(52, 1000)
    turned = MODELS[name](alpha_x=0.1, alpha_y=0.5, rotation=0.5 * np.pi - 1e-12, anisotropy="anisotropic")
    swapped = MODELS[name](alpha_x=0.5, alpha_y=0.1, anisotropy="anisotropic")
    np.testing.assert_allclose(evaluate(turned, wi, wo), evaluate(swapped, wi, wo), rtol=1e-7, atol=1e-100)


@every_microfacet
@pytest.mark.parametrize("alpha", [1e-4, 1e-2])
def test_a_narrow_lobe_is_a_mirror_of_reflectance_f(name, alpha):
    # Oracle: as alpha goes to 0 the lobe holds F(cos_o), here the mean of value / density over its own samples.
    model = dataclasses.replace(build(name), alpha=np.float64(alpha), f0=np.full(3, 0.3))
    wo = np.array([0.6, 0.0, 0.8])
    u = np.random.default_rng(53).random((20_000, 3))
    wi = jax.jit(jax.vmap(model.sample, (None, 0)))(wo, u)
    value = np.asarray(evaluate(model, np.asarray(wi), np.broadcast_to(wo, u.shape)))[:, 0]
    pdf = np.asarray(jax.jit(jax.vmap(model.pdf, (0, None)))(wi, wo))
    expected = 0.3 + 0.7 * 0.2**5
    assert np.mean(value * np.asarray(wi)[:, 2] / pdf) == pytest.approx(expected, rel=0.02)
    np.testing.assert_allclose(np.mean(np.asarray(wi), axis=0), [-0.6, 0, 0.8], atol=20 * alpha)


def test_gtr_of_two_is_ggx_and_of_one_is_berry():
    wi, wo = cases.pairs(54, 1000)
    two = MODELS["gtr"](alpha=0.2, gamma=2.0)
    np.testing.assert_allclose(evaluate(two, wi, wo), evaluate(MODELS["ggx"](alpha=0.2), wi, wo), rtol=1e-9)
    # Burley 2012, appendix B: D = (alpha^2 - 1) / (pi log(alpha^2) (1 + (alpha^2 - 1) cos^2)).
    one = MODELS["gtr"](gamma=1.0)
    h = jnp.array([0.3, 0.1, np.sqrt(1 - 0.1)])
    density = one.density(geometry(h, h), jnp.asarray(0.2), jnp.asarray(0.2))
    a2 = 0.04
    assert float(density) == pytest.approx((a2 - 1) / (np.pi * np.log(a2) * (1 + (a2 - 1) * 0.9)), rel=1e-12)


def test_gtr_is_continuous_where_its_closed_forms_divide_by_zero():
    wi, wo = cases.pairs(55, 400)
    for name, value in (("gamma", 1.0), ("alpha", 1.0)):
        at = dataclasses.replace(MODELS["gtr"](alpha=0.4, gamma=1.5), **{name: np.float64(value)})
        near = dataclasses.replace(at, **{name: np.float64(value - 1e-9)})
        np.testing.assert_allclose(evaluate(at, wi, wo), evaluate(near, wi, wo), rtol=1e-6)


def test_the_gaussian_approaches_beckmann_at_small_slopes():
    # tan(theta) and theta agree to alpha^2 inside the lobe.
    rng = np.random.default_rng(56)
    wo = cases.directions(rng, 1000)
    wo = wo[wo[:, 2] > 0.3]
    tilt = 1e-3 * rng.normal(size=(len(wo), 2))
    h = np.concatenate([tilt, np.ones((len(wo), 1))], axis=1)
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    wi = 2 * np.sum(wo * h, axis=1, keepdims=True) * h - wo
    gaussian, beckmann = MODELS["gaussian"](alpha=1e-3), MODELS["beckmann"](alpha=1e-3)
    np.testing.assert_allclose(evaluate(gaussian, wi, wo), evaluate(beckmann, wi, wo), rtol=2e-4)


def test_a_sum_is_the_sum_of_its_parts():
    wi, wo = cases.pairs(57, 500)
    model = build("oren_nayar+beckmann+ggx+ggx")
    lobes = split(model)
    lobes["ggx_2"] = dataclasses.replace(lobes["ggx_2"], alpha=np.float64(0.05))
    parts = sum(np.asarray(evaluate(lobe, wi, wo)) for lobe in lobes.values())
    np.testing.assert_allclose(evaluate(combine(lobes), wi, wo), parts, rtol=1e-13)


@pytest.mark.parametrize("name", list(MODELS))
def test_an_absent_weight_changes_nothing_but_what_is_computed(name):
    # Oracle: the same model with its weights traced as numbers that happen to be 0.
    wi, wo = cases.pairs(58, 200)
    model = MODELS[name]()
    general = jax.jit(lambda model, wi, wo: jax.vmap(model)(wi, wo))(model, wi, wo)
    np.testing.assert_allclose(evaluate(model, wi, wo), general, rtol=1e-12)
