"""Powers of a cosine: the lobes of Phong, of Blinn, and of Ashikhmin and Shirley, exact up to an exponent of 1e5.

A power n multiplies the rounding of the logarithm by n. So no cosine is rounded first: its logarithm comes from
`1 - cos`, the square of a difference of directions, or from `tan^2`, the square of a slope.

- Phong 1975, "Illumination for Computer Generated Pictures".
- Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures".
- Ashikhmin, Shirley 2000, "An Anisotropic Phong BRDF Model".

The twin of this file is `shaders/glsl/cosine_power.glsl`.
"""

from __future__ import annotations

import jax.numpy as jnp

from .frame import Geometry, Scalar

# 32 exponents from 1 to 1e5: neighbours differ by a factor 1.45, as widths by 1.2, inside the basin of a log-loss fit.
EXPONENT_STARTS = tuple(1e5 ** (i / 31) for i in range(32))
# log(1 + t) / t is its series below: 1 - t / 2 is then exact to rounding in float64, and t^2 above does not underflow.
_TAN2_SERIES = 1e-8


def cos_mirror_power(g: Geometry, exponent: Scalar) -> Scalar:
    """`cos^n` of the angle between `wi` and the direction that mirrors `wo`; zero from a right angle on."""
    # wi - mirror(wo) = (h_x, h_y, cos_i - cos_o), and 1 - cos is half the square of its length.
    d_z = g.cos_i - g.cos_o
    one_minus_cos = 0.5 * (g.h_x * g.h_x + g.h_y * g.h_y + d_z * d_z)
    facing = one_minus_cos < 1
    one_minus_cos = jnp.where(facing, one_minus_cos, jnp.zeros_like(one_minus_cos))
    # Not log1p(-x), which XLA computes in float64 to 14 digits only about x = 0.4.
    power = jnp.exp(-exponent * jnp.log1p(one_minus_cos / (1 - one_minus_cos)))
    return jnp.where(facing, power, jnp.zeros_like(power))


def cos_h_power(g: Geometry, exponent: Scalar) -> Scalar:
    """`cos(theta_h)^n`."""
    # log(cos) = -log(1 + tan^2) / 2
    t_x, t_y = g.h_x / g.h_z, g.h_y / g.h_z
    return jnp.exp(-0.5 * exponent * jnp.log1p(t_x * t_x + t_y * t_y))


def cos_h_power_anisotropic(g: Geometry, exponent_x: Scalar, exponent_y: Scalar, rotation: Scalar) -> Scalar:
    """`cos(theta_h)^n` with `n = n_x cos^2(phi) + n_y sin^2(phi)`, where `phi` is the azimuth of the half vector from
    an axis at `rotation` (Ashikhmin and Shirley 2000)."""
    c, s = jnp.cos(rotation), jnp.sin(rotation)
    t_x, t_y = (c * g.h_x + s * g.h_y) / g.h_z, (c * g.h_y - s * g.h_x) / g.h_z
    tan2 = t_x * t_x + t_y * t_y
    # n log(1 + tan^2) = (n tan^2) (log(1 + tan^2) / tan^2), where the azimuth is defined at the normal too.
    small = tan2 < _TAN2_SERIES
    tan2_safe = jnp.where(small, jnp.ones_like(tan2), tan2)
    log_ratio = jnp.where(small, 1 - 0.5 * tan2, jnp.log1p(tan2_safe) / tan2_safe)
    return jnp.exp(-0.5 * (exponent_x * t_x * t_x + exponent_y * t_y * t_y) * log_ratio)


def slope_of_exponent(exponent: Scalar) -> Scalar:
    """The slope alpha of the microfacets whose highlight is as wide as that of `cos(theta_h)^n` (Walter 2007)."""
    return jnp.sqrt(2 / (exponent + 2))
