"""The microfacet terms against quadrature, against mpmath at 50 digits, and in float32."""

import dataclasses
import functools

import jax
import jax.numpy as jnp
import mpmath
import numpy as np
import pytest

import brdf
from brdf.distributions import cos_lambda_beckmann
from brdf.frame import geometry
from brdf.microfacet import AbstractMicrofacet

DISTRIBUTIONS = {name: brdf.build(name) for name in brdf.MODELS if issubclass(brdf.MODELS[name], AbstractMicrofacet)}


def density(model, wi, wo, alpha):
    model = jax.tree.map(lambda leaf: jnp.asarray(leaf, alpha.dtype), model)
    return model.density(geometry(wi, wo), alpha, alpha)


# (wi, wo, alpha) -> D, for many pairs.
DENSITIES = {
    name: jax.jit(jax.vmap(functools.partial(density, model), (0, 0, None))) for name, model in DISTRIBUTIONS.items()
}
LAMBDAS = {
    name: jax.jit(lambda c, s, alpha, m=m: dataclasses.replace(m, alpha=alpha).cos_lambda(c, s))
    for name, m in DISTRIBUTIONS.items()
}
every_distribution = pytest.mark.parametrize("name", list(DENSITIES))


gauss = functools.cache(np.polynomial.legendre.leggauss)


def density_at(name, theta, alpha):
    """D at polar angles theta of the half vector: wi = wo = h."""
    h = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1)
    return np.asarray(DENSITIES[name](h, h, jnp.asarray(alpha)))


@every_distribution
@pytest.mark.parametrize("alpha", [1e-3, 0.05, 0.4, 1.0])
def test_projected_area_of_the_normals_is_one(name, alpha):
    # Oracle: the integral of D cos over the hemisphere, by Gauss-Legendre in t = atan(tan(theta) / alpha).
    point, weight = gauss(200)
    t, weight = (point + 1) * np.pi / 4, weight * np.pi / 4
    theta = np.arctan(alpha * np.tan(t))
    stretch = alpha / (np.cos(t) ** 2 * (1 + (alpha * np.tan(t)) ** 2))
    total = np.sum(weight * stretch * density_at(name, theta, alpha) * np.cos(theta) * np.sin(theta)) * 2 * np.pi
    assert total == pytest.approx(1, rel=1e-6)


@every_distribution
@pytest.mark.parametrize("slopes", [(0.3, 0.05), (1.0, 0.01), (1e-3, 0.2)])
@pytest.mark.parametrize("gamma", [0.5, 1.0, 5.0])
def test_projected_area_is_one_for_unequal_slopes_too(name, slopes, gamma):
    # Oracle: the same integral over the hemisphere, in the stretched plane where the slopes are equal.
    if gamma != 1.0 and name != "gtr":
        pytest.skip("only gtr has an exponent")
    alpha_x, alpha_y = slopes
    model = dataclasses.replace(DISTRIBUTIONS[name], anisotropy="anisotropic")
    model = dataclasses.replace(model, gamma=np.float64(gamma)) if name == "gtr" else model
    point, weight = gauss(300)
    # Radius r = tan(t) from e^-10 to e^10 times the unit: the tails of a small gamma are long.
    log_r, wr = 16 * point, 16 * weight
    psi, wp = (point + 1) * np.pi / 4, weight * np.pi / 4
    r = np.exp(log_r)[:, None]
    x, y = r * alpha_x * np.cos(psi), r * alpha_y * np.sin(psi)
    secant = np.sqrt(1 + x * x + y * y)
    h = np.stack([x / secant, y / secant, 1 / secant], axis=-1).reshape(-1, 3)
    at = jax.jit(jax.vmap(lambda h: model.density(geometry(h, h), jnp.asarray(alpha_x), jnp.asarray(alpha_y))))
    value = np.asarray(at(h)).reshape(x.shape)
    # dA = alpha_x alpha_y r dr dpsi in the plane of slopes; solid angle dA / secant^3, projected once more.
    total = 4 * np.sum(wr[:, None] * wp * value * alpha_x * alpha_y * r * r / secant**4)
    assert total == pytest.approx(1, rel=2e-5)


@every_distribution
@pytest.mark.parametrize("alpha", [0.1, 0.5, 1.0])
@pytest.mark.parametrize("theta", [0.3, 1.0, 1.4])
def test_visible_normals_cover_the_projected_surface(name, alpha, theta):
    # Oracle: Smith's identity, integral of max(0, w.m) D(m) = cos(theta) (1 + Lambda) (Heitz 2014, eq. 14 and 41).
    point, weight = gauss(200)
    t, wt = (point + 1) * np.pi / 4, weight * np.pi / 4
    phi, wp = (point + 1) * np.pi / 2, weight * np.pi
    theta_m = np.arctan(alpha * np.tan(t))
    stretch = alpha / (np.cos(t) ** 2 * (1 + (alpha * np.tan(t)) ** 2))
    radial = wt * stretch * density_at(name, theta_m, alpha) * np.sin(theta_m)
    facing = np.sin(theta) * np.outer(np.sin(theta_m), np.cos(phi)) + np.cos(theta) * np.cos(theta_m)[:, None]
    total = np.sum(radial[:, None] * wp * np.maximum(facing, 0))
    expected = np.cos(theta) + LAMBDAS[name](
        *(jnp.asarray(x) for x in (np.cos(theta), (alpha * np.sin(theta)) ** 2, alpha))
    )
    assert total == pytest.approx(float(expected), rel=1e-4)


def exact_density(name, wi, wo, alpha):
    wi, wo, alpha = [mpmath.mpf(float(x)) for x in wi], [mpmath.mpf(float(x)) for x in wo], mpmath.mpf(float(alpha))
    h = [a + b for a, b in zip(wi, wo, strict=True)]
    tan2 = (h[0] ** 2 + h[1] ** 2) / h[2] ** 2
    cos2 = 1 / (1 + tan2)
    if name == "ggx":
        return alpha**2 / (mpmath.pi * cos2**2 * (alpha**2 + tan2) ** 2)
    if name == "beckmann":
        return mpmath.exp(-tan2 / alpha**2) / (mpmath.pi * alpha**2 * cos2**2)
    if name == "gtr":
        return exact_density("ggx", wi, wo, alpha)
    norm = mpmath.quad(
        lambda t: mpmath.exp(-((t / alpha) ** 2)) * mpmath.sin(2 * t), [0, min(mpmath.pi / 2, 8 * alpha)]
    )
    return mpmath.exp(-((mpmath.atan(mpmath.sqrt(tan2)) / alpha) ** 2)) / (mpmath.pi * norm)


@every_distribution
@pytest.mark.parametrize(("alpha", "bound"), [(1e-3, 6e-7), (1e-2, 6e-7), (0.3, 6e-7)])
def test_density_in_float32_loses_no_digit(name, alpha, bound):
    # Oracle: 50 digits. Half vectors up to 4 alpha from the normal; beyond, Beckmann's exponent multiplies rounding.
    rng = np.random.default_rng(12)
    theta_i, tilt = rng.uniform(0, 1.4, 60), np.arctan(4 * alpha * rng.random(60))
    phi = rng.uniform(0, 2 * np.pi, 60)
    h = np.stack([np.sin(tilt) * np.cos(phi), np.sin(tilt) * np.sin(phi), np.cos(tilt)], axis=-1)
    wi = np.stack([np.sin(theta_i), 0 * theta_i, np.cos(theta_i)], axis=-1)
    wo = 2 * np.sum(wi * h, axis=-1, keepdims=True) * h - wi
    keep = wo[:, 2] > 1e-3
    wi, wo, alpha = wi[keep].astype(np.float32), wo[keep].astype(np.float32), np.float32(alpha)
    density = DENSITIES[name](wi, wo, jnp.asarray(alpha))
    assert density.dtype == jnp.float32
    with mpmath.workdps(50):
        exact = np.array([float(exact_density(name, a, b, alpha)) for a, b in zip(wi, wo, strict=True)])
    error = np.abs(np.asarray(density, np.float64) / exact - 1)
    if name != "ggx":
        # An exponent x carries one rounding of its own size into the value.
        bound = bound + 16 * 2.4e-7
    assert error.max() <= bound


@pytest.mark.parametrize("alpha", [1e-4, 0.01, 0.3, 1.0])
def test_beckmann_lambda_equals_50_digits(alpha):
    cosines = np.concatenate([10.0 ** np.arange(-7, 0), [0.3, 0.7, 0.99, 1.0]])
    sin2 = (1 - cosines) * (1 + cosines)
    value = np.asarray(jax.jit(jax.vmap(cos_lambda_beckmann))(cosines, alpha * alpha * sin2))
    with mpmath.workdps(50):
        for c, s2, v in zip(cosines, sin2, value, strict=True):
            if s2 == 0:
                exact = mpmath.mpf(0)
            else:
                a = mpmath.mpf(c) / (mpmath.mpf(alpha) * mpmath.sqrt(mpmath.mpf(s2)))
                exact = c * (mpmath.exp(-(a**2)) / (a * mpmath.sqrt(mpmath.pi)) - mpmath.erfc(a)) / 2
            # Masking divides by cos (1 + Lambda): an error counts against the cosine.
            assert abs(v - float(exact)) <= 1e-13 * (c + float(exact))
