"""Microfacet slope distributions: the density D of normals, and Lambda of Smith's masking.

`alpha_x` and `alpha_y` are the slopes along the axes of the tangent frame. Lambda depends on a direction through its
cosine and `alpha_sin2`, the square of its tangential part stretched by the slopes; it is handed on multiplied by the
cosine, `cos_lambda`, because that product stays finite at grazing angles.

- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Burley 2012, "Physically-Based Shading at Disney", appendix B.

The twin of this file is `shaders/glsl/distributions.glsl`.
"""

from __future__ import annotations

from collections.abc import Callable

import jax
import jax.numpy as jnp
import numpy as np
from jax.scipy.special import erfc

from .frame import Direction, Geometry, Scalar

# exp(-700) is the last decade that float64 holds; in float32 the tail is zero long before.
_EXPONENT_MAX = 700.0
# erfc(10) = 2e-45: beyond it Lambda of Beckmann is zero in any precision that is used here.
_BECKMANN_A_MAX = 10.0
# Below it the series to the fifth power is good to 1e-15.
_SERIES_MAX = 1e-2
_ELLIPSE_NODES = 32


def alpha_sin2(w: Direction, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """`(alpha_x x)^2 + (alpha_y y)^2`: alpha^2 sin^2(theta) where the slopes are equal (Heitz 2014, eq. 80)."""
    x, y = alpha_x * w[0], alpha_y * w[1]
    return x * x + y * y


def d_ggx(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """GGX (Trowbridge-Reitz) density of normals in 1/sr (Walter 2007, eq. 33; anisotropic: Heitz 2014, eq. 85)."""
    # 1 / D is quadratic in a form whose terms are m's alone where the slopes are equal: no digit is lost, and no
    # product or derivative leaves the range of float32 down to the horizon.
    area = alpha_x * alpha_y
    ratio = g.m2 / (g.m_x * g.m_x * (alpha_y / alpha_x) + g.m_y * g.m_y * (alpha_x / alpha_y) + area * g.m_z2)
    return (area / jnp.pi) * (ratio * ratio)


def cos_lambda_ggx(cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
    """`cos(theta) Lambda(theta)` of GGX (Heitz 2014, eq. 72)."""
    # sqrt(a) - b = (a - b^2) / (sqrt(a) + b), where the difference would cancel.
    return 0.5 * alpha_sin2 / (jnp.sqrt(cos_theta * cos_theta + alpha_sin2) + cos_theta)


def d_beckmann(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """Beckmann density of normals in 1/sr (Walter 2007, eq. 25; anisotropic: Heitz 2014, eq. 83); alpha is the RMS
    slope."""
    t_x, t_y = g.m_x / (alpha_x * g.m_z), g.m_y / (alpha_y * g.m_z)
    exponent = t_x * t_x + t_y * t_y
    inside = exponent < _EXPONENT_MAX
    exponent = jnp.where(inside, exponent, jnp.zeros_like(exponent))
    secant2 = g.m2 / (g.m_z * g.m_z)
    secant2 = jnp.where(inside, secant2, jnp.ones_like(secant2))
    # The exponential in two halves: it may lie below the range of float32 where the density does not.
    decay = jnp.exp(-0.5 * exponent)
    density = decay * (secant2 * secant2 / (jnp.pi * alpha_x * alpha_y)) * decay
    return jnp.where(inside, density, jnp.zeros_like(density))


def cos_lambda_beckmann(cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
    """`cos(theta) Lambda(theta)` of Beckmann, with the exact error function (Heitz 2014, eq. 68)."""
    # a = cos / (alpha sin) is infinite at normal incidence, where Lambda is zero: guard the input of sqrt and division.
    inside = alpha_sin2 * _BECKMANN_A_MAX**2 > cos_theta * cos_theta
    alpha_sin = jnp.sqrt(jnp.where(inside, alpha_sin2, jnp.ones_like(alpha_sin2)))
    a = jnp.where(inside, cos_theta / alpha_sin, jnp.ones_like(alpha_sin))
    value = 0.5 * (alpha_sin * jnp.exp(-a * a) / jnp.sqrt(jnp.pi) - cos_theta * erfc(a))
    return jnp.where(inside, value, jnp.zeros_like(value))


def d_gtr(g: Geometry, alpha_x: Scalar, alpha_y: Scalar, gamma: Scalar, norm: Scalar) -> Scalar:
    """Generalised Trowbridge-Reitz density of normals in 1/sr (Burley 2012, appendix B), `norm` from `gtr_norm`.

    `gamma = 1` is Berry's distribution, `gamma = 2` is GGX.
    """
    t_x, t_y = g.m_x / alpha_x, g.m_y / alpha_y
    # The base minus 1, which is small beside the normal, where the logarithm would lose it.
    t2 = (
        t_x * (g.m_x * (1 - alpha_x)) * (1 + alpha_x) / alpha_x
        + t_y * (g.m_y * (1 - alpha_y)) * (1 + alpha_y) / alpha_y
    )
    # In two halves: a power may lie below the range of float32 where the density does not.
    decay = jnp.exp(-0.5 * gamma * jnp.log1p(t2 / g.m2))
    return decay * (1 / (jnp.pi * alpha_x * alpha_y * norm)) * decay


def gtr_norm(alpha2: Scalar, gamma: Scalar) -> Scalar:
    """What `d_gtr` is divided by, beside the area of the ellipse of slopes, so that its normals cover the surface.

    Written so that neither `gamma = 1` nor `alpha = 1` divides by zero; for unequal slopes it is the `elliptic_mean`.
    """
    spread = -jnp.log(alpha2)
    return _mean_decay((gamma - 1) * spread) / _mean_decay(spread)


def _mean_decay(x: Scalar) -> Scalar:
    """The mean of exp(-s) over s from 0 to x, `(1 - exp(-x)) / x`."""
    is_small = jnp.abs(x) < _SERIES_MAX
    series = 1 - x / 2 * (1 - x / 3 * (1 - x / 4 * (1 - x / 5 * (1 - x / 6))))
    safe = jnp.where(is_small, jnp.ones_like(x), x)
    return jnp.where(is_small, series, -jnp.expm1(-safe) / safe)


def elliptic_mean(function: Callable[[Scalar], Scalar], alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """The mean of a function of alpha^2 over the ellipse of slopes, in its eccentric anomaly.

    Gauss-Legendre in w with anomaly = r sinh(w), r the ratio of the slopes: as many nodes near the thin end, where the
    function may be all but singular, as elsewhere. Exact to 1e-8 for slopes from 1e-4 to 1.
    """
    low, high = jnp.minimum(alpha_x, alpha_y), jnp.maximum(alpha_x, alpha_y)
    ratio = low / high
    abscissas, weights = np.polynomial.legendre.leggauss(_ELLIPSE_NODES)
    span = jnp.arcsinh(0.5 * jnp.pi / ratio)
    w = span * jnp.asarray(0.5 * (1 + abscissas), ratio.dtype)
    anomaly = ratio * jnp.sinh(w)
    x, y = low * jnp.cos(anomaly), high * jnp.sin(anomaly)
    stretch = ratio * jnp.cosh(w) * span / jnp.pi
    return jnp.sum(jnp.asarray(weights, ratio.dtype) * stretch * jax.vmap(function)(x * x + y * y))
