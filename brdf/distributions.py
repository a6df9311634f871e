"""Microfacet slope distributions: the density D of normals, and Lambda of Smith's masking.

Lambda is handed on multiplied by the cosine, `cos_lambda`, because that product stays finite at grazing angles.

- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".

The twin of this file is `shaders/glsl/distributions.glsl`.
"""

from __future__ import annotations

import jax.numpy as jnp
from jax.scipy.special import erfc

from .frame import Geometry, Scalar

# exp(-700) is the last decade that float64 holds; in float32 the tail is zero long before.
_EXPONENT_MAX = 700.0
# erfc(10) = 2e-45: beyond it Lambda of Beckmann is zero in any precision that is used here.
_BECKMANN_A_MAX = 10.0


def d_ggx(g: Geometry, alpha: Scalar) -> Scalar:
    """GGX (Trowbridge-Reitz) density of normals in 1/sr (Walter 2007, eq. 33)."""
    # No product here leaves the range of float32, nor does one of its derivatives, down to the horizon.
    t_x, t_y = g.h_x / alpha, g.h_y / alpha
    ratio = g.h2 / (t_x * t_x + t_y * t_y + g.h_z * g.h_z) / alpha
    return ratio * ratio / jnp.pi


def cos_lambda_ggx(cos_theta: Scalar, sin2_theta: Scalar, alpha: Scalar) -> Scalar:
    """`cos(theta) Lambda(theta)` of GGX (Heitz 2014, eq. 72)."""
    return 0.5 * (jnp.sqrt(cos_theta * cos_theta + alpha * alpha * sin2_theta) - cos_theta)


def d_beckmann(g: Geometry, alpha: Scalar) -> Scalar:
    """Beckmann density of normals in 1/sr (Walter 2007, eq. 25); alpha is the RMS slope."""
    t_x, t_y = g.h_x / (alpha * g.h_z), g.h_y / (alpha * g.h_z)
    exponent = t_x * t_x + t_y * t_y
    inside = exponent < _EXPONENT_MAX
    exponent = jnp.where(inside, exponent, jnp.zeros_like(exponent))
    secant2 = g.h2 / (g.h_z * g.h_z)
    secant2 = jnp.where(inside, secant2, jnp.ones_like(secant2))
    density = jnp.exp(-exponent) * secant2 * secant2 / (jnp.pi * alpha * alpha)
    return jnp.where(inside, density, jnp.zeros_like(density))


def cos_lambda_beckmann(cos_theta: Scalar, sin2_theta: Scalar, alpha: Scalar) -> Scalar:
    """`cos(theta) Lambda(theta)` of Beckmann, with the exact error function (Heitz 2014, eq. 68)."""
    # a = cos / (alpha sin) is infinite at normal incidence, where Lambda is zero: guard the input of sqrt and division.
    limit = alpha * alpha * sin2_theta * _BECKMANN_A_MAX**2
    inside = limit > cos_theta * cos_theta
    sin2_safe = jnp.where(inside, sin2_theta, jnp.ones_like(sin2_theta))
    alpha_sin = alpha * jnp.sqrt(sin2_safe)
    a = jnp.where(inside, cos_theta / alpha_sin, jnp.ones_like(alpha_sin))
    value = 0.5 * (alpha_sin * jnp.exp(-a * a) / jnp.sqrt(jnp.pi) - cos_theta * erfc(a))
    return jnp.where(inside, value, jnp.zeros_like(value))
