"""Sheen of cloth and dust: a lobe of fibres around the normal, seen at grazing angles.

- Conty, Kulla 2017, "Production Friendly Microfacet Sheen BRDF", SIGGRAPH course notes: `charlie`, with the mapping
  alpha = roughness^2 of Khronos' KHR_materials_sheen.
- Zeltner, Burley, Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines": `fuzz`, with
  the rational and Gaussian fits to its tables that MaterialX 1.39 publishes (mx_microfacet_sheen.glsl).

The twin of this file is `shaders/glsl/sheen.glsl`.
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from .frame import Geometry, Scalar

# Below it the exponent 1 / alpha leaves the range where the published masking was fitted and albedo makes sense.
_CHARLIE_ROUGHNESS_MIN = 0.07
# Zeltner's tables start there.
_FUZZ_ROUGHNESS_MIN = 0.01
# Smallest squared sine and distance from normal incidence of which a logarithm is taken.
_SIN2_MIN, _LOG_MIN = 1e-30, 1e-30


def _charlie_alpha(roughness: Scalar) -> Scalar:
    r = jnp.maximum(roughness, _CHARLIE_ROUGHNESS_MIN)
    return r * r


def d_charlie(g: Geometry, roughness: Scalar) -> Scalar:
    """Density of normals in 1/sr that rises towards the horizon as sin^(1/alpha) (Conty and Kulla 2017, eq. 2)."""
    alpha = _charlie_alpha(roughness)
    sin2, cos2 = (g.m_x * g.m_x + g.m_y * g.m_y) / g.m2, g.m_z2 / g.m2
    # The logarithm of whichever of 1 - cos^2 and sin^2 has kept its digits.
    is_grazing = cos2 < 0.5
    near = jnp.log1p(-jnp.where(is_grazing, cos2, jnp.zeros_like(cos2)))
    far = jnp.log(jnp.maximum(jnp.where(is_grazing, jnp.ones_like(sin2), sin2), _SIN2_MIN))
    return (2 + 1 / alpha) / (2 * math.pi) * jnp.exp(0.5 / alpha * (near + far))


def v_charlie(g: Geometry, roughness: Scalar) -> Scalar:
    """Visibility G / (4 cos_i cos_o) of Charlie's fitted Lambda (Conty and Kulla 2017)."""
    alpha = _charlie_alpha(roughness)
    lambdas = _charlie_lambda(g.cos_i, alpha) + _charlie_lambda(g.cos_o, alpha)
    return 0.25 / ((1 + lambdas) * (g.cos_i * g.cos_o))


def _charlie_lambda(cos_theta: Scalar, alpha: Scalar) -> Scalar:
    is_grazing = cos_theta < 0.5
    value = _charlie_curve(jnp.where(is_grazing, cos_theta, 1 - cos_theta), alpha)
    return jnp.exp(jnp.where(is_grazing, value, 2 * _charlie_curve(0.5 * jnp.ones_like(value), alpha) - value))


def _charlie_curve(x: Scalar, alpha: Scalar) -> Scalar:
    """log(Lambda) at the cosine x (Conty and Kulla 2017)."""
    t = (1 - alpha) * (1 - alpha)
    a = 21.5473 + t * (25.3245 - 21.5473)
    b = 3.82987 + t * (3.32435 - 3.82987)
    c = 0.19823 + t * (0.16801 - 0.19823)
    d = -1.97760 + t * (-1.27393 + 1.97760)
    e = -4.32054 + t * (-4.85967 + 4.32054)
    return a / (1 + b * jnp.exp(c * jnp.log(jnp.maximum(x, _LOG_MIN)))) + d * x + e


def charlie_albedo(cos_theta: Scalar, roughness: Scalar) -> Scalar:
    """The fraction of light that `d_charlie v_charlie` reflects, cut at 1.

    A rational least-squares fit to a quadrature in float64 with 300 x 240 nodes, off by 0.021 at most and 0.004 in the
    mean. The lobe itself reflects more than 1 at grazing angles below a roughness of 0.2, up to 2.9 at 0.07.
    """
    r = jnp.maximum(roughness, _CHARLIE_ROUGHNESS_MIN)
    u = jnp.sqrt(cos_theta)
    top = 0.5555556 + r * (2.7528488 + r * (-2.2876804 + r * 3.7988741))
    top = top + u * (
        -2.2696713 + r * (18.0888992 + r * 32.2405614) + u * (-0.5433003 + r * -34.6299911 + u * 3.6170591)
    )
    bottom = 1 + r * (-6.0202966 + r * (44.8655913 + r * (-66.6558121 + r * 33.5152482)))
    bottom_1 = -9.589783 + r * (18.8833431 + r * (17.6356141 + r * -7.8650279))
    bottom_2 = 46.7194539 + r * (28.7687285 + r * 69.1985613)
    bottom_3 = -113.9240706 + r * -69.4224305
    bottom = bottom + u * (bottom_1 + u * (bottom_2 + u * (bottom_3 + u * 132.5082692)))
    return jnp.clip(top / bottom, 0, 1)


def fuzz_albedo(cos_theta: Scalar, roughness: Scalar) -> Scalar:
    """The fraction of light that the fuzz reflects: MaterialX's Gaussian fit, cut at 0 where it falls to -2e-5."""
    x, y = cos_theta, jnp.maximum(roughness, _FUZZ_ROUGHNESS_MIN)
    s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
    offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y))
    t = (x - m) / s
    return jnp.maximum(jnp.exp(-0.5 * t * t) / (s * math.sqrt(2 * math.pi)) + offset, 0)


def fuzz(g: Geometry, roughness: Scalar) -> Scalar:
    """The fuzz in 1/sr: its albedo times a linearly transformed cosine about the viewer's azimuth (Zeltner 2022)."""
    x, y = g.cos_o, jnp.maximum(roughness, _FUZZ_ROUGHNESS_MIN)
    a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y)
    # MaterialX's second coefficient is b = shear sin_o; with the azimuths' dot product no sine needs to be divided by.
    shear = (y - 1) * y * y * y / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)
    shear = shear / jnp.sqrt(1 + x)
    b2 = shear * shear * g.sin2_o
    length2 = a * a * g.sin2_i + 2 * a * shear * g.dot_xy * g.cos_i + (1 + b2) * g.cos_i * g.cos_i
    ratio = a / length2
    return fuzz_albedo(x, roughness) * (ratio * ratio) / math.pi
