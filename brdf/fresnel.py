"""Fresnel reflectance, from the cosine of the difference angle or, where digits matter, from one minus it.

- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
- Hoffman 2019, "Fresnel Equations Considered Harmful": the tint at 82 degrees.
- Karis 2013, "Real Shading in Unreal Engine 4": the spherical Gaussian.
- Cook, Torrance 1982, "A Reflectance Model for Computer Graphics": the dielectric.
- Born, Wolf 1999, "Principles of Optics", section 14.2: the conductor.

The twin of this file is `shaders/glsl/fresnel.glsl`.
"""

from __future__ import annotations

import jax.numpy as jnp

from .frame import Color, Scalar

# The cosine at which `f82` is given, about 82 degrees.
_COS_82 = 1 / 7


def schlick_weight(one_minus_cos: Scalar) -> Scalar:
    """The fifth power."""
    x2 = one_minus_cos * one_minus_cos
    return x2 * x2 * one_minus_cos


def f_schlick(f0: Color, one_minus_cos_d: Scalar) -> Color:
    """Schlick's approximation (Schlick 1994, eq. 15), from `1 - cos(theta_d)` so that no digit is lost near 0."""
    return f0 + (1 - f0) * schlick_weight(one_minus_cos_d)


def f_schlick_f90(f0: Color, f90: Color, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
    """Schlick's approximation that ends in `f90` instead of 1 at grazing angles."""
    # 1 - u^5 = (1 - u) (1 + u + ... + u^4), where the difference would cancel.
    u = one_minus_cos_d
    rest = cos_d * (1 + u * (1 + u * (1 + u * (1 + u))))
    return f0 * rest + f90 * schlick_weight(u)


def f_schlick_f82(f0: Color, f82: Color, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
    """Schlick's approximation times a tint `f82` at about 82 degrees (Hoffman 2019); cut at 0, which a dark tint of a
    dark `f0` would pass."""
    x5, x5_82 = schlick_weight(one_minus_cos_d), (1 - _COS_82) ** 5
    at_82 = f0 + (1 - f0) * x5_82
    # The dip, cos (1 - cos)^6 over its value at 82 degrees, where it is largest: near there 1 - dip is written as the
    # double zero that it is, for a bright f0 with a dark tint is nothing but that.
    t = 7 * cos_d - 1
    is_near = jnp.abs(t) < 0.5
    t = jnp.where(is_near, t, jnp.zeros_like(t))
    rest = 35 / 432 - t * (7 / 648 - t * (35 / 46656 - t * (1 / 46656)))
    one_minus_dip = t * t * (7 / 12 - t * (35 / 108 - t * rest))
    near = (1 - f0) * (x5 - x5_82) + at_82 * f82 + at_82 * (1 - f82) * one_minus_dip
    dip = cos_d * one_minus_cos_d * x5 * (1 / (_COS_82 * (1 - _COS_82) ** 6))
    far = f0 + (1 - f0) * x5 - at_82 * (1 - f82) * dip
    return jnp.maximum(jnp.where(is_near, near, far), 0)


def f_spherical_gaussian(f0: Color, cos_d: Scalar) -> Color:
    """Schlick's power as a spherical Gaussian (Karis 2013)."""
    return f0 + (1 - f0) * jnp.exp(0.6931471805599453 * ((-5.55473 * cos_d - 6.98316) * cos_d))


def f_dielectric(ior: Scalar, cos_d: Scalar) -> Scalar:
    """Unpolarised reflectance of a smooth dielectric of index `ior >= 1` (Cook and Torrance 1982)."""
    g = jnp.sqrt((ior - 1) * (ior + 1) + cos_d * cos_d)
    # (g - c) / (g + c) with the difference of squares factored, which holds at ior = 1.
    s = g + cos_d
    perpendicular = ((ior - 1) / s) * ((ior + 1) / s)
    ratio = (cos_d * s - 1) / (cos_d * (g - cos_d) + 1)
    return 0.5 * perpendicular * perpendicular * (1 + ratio * ratio)


def f_conductor(eta: Color, k: Color, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
    """Unpolarised reflectance of a smooth conductor of complex index `eta + i k`, both above 0 (Born and Wolf 1999)."""
    sin2 = one_minus_cos_d * (1 + cos_d)
    # (p + i q)^2 = (eta + i k)^2 - sin^2, the refracted wave's normal component squared.
    real = (eta - k) * (eta + k) - sin2
    product = eta * k
    large = 0.5 * (jnp.sqrt(real * real + 4 * product * product) + jnp.abs(real))
    # p^2 q^2 = product^2: the smaller of the two without cancellation.
    small = product * product / large
    p = jnp.sqrt(jnp.where(real > 0, large, small))
    q2 = jnp.where(real > 0, small, large)
    minus, plus = p - cos_d, p + cos_d
    perpendicular = (minus * minus + q2) / (plus * plus + q2)
    minus, plus = p * cos_d - sin2, p * cos_d + sin2
    q2 = q2 * cos_d * cos_d
    parallel = (minus * minus + q2) / (plus * plus + q2)
    return 0.5 * perpendicular * (1 + parallel)
