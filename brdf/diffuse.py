"""Diffuse terms that layered models share, without their models' parameters.

- Burley 2012, "Physically Based Shading at Disney", section 5.3, with the code of the BRDF Explorer.
- Hanrahan, Krueger 1993, "Reflection from Layered Surfaces due to Subsurface Scattering".
- Portsmouth, Kutz, Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), listing 1.

The twin of this file is `shaders/glsl/diffuse.glsl`.
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from .frame import Color, Geometry, Scalar
from .fresnel import schlick_weight

# EON's constants: the directional and the average albedo of Fujii's term are A (1 + r G / pi) and A (1 + c2 r).
C1 = 0.5 - 2 / (3 * math.pi)
C2 = 2 / 3 - 28 / (15 * math.pi)
# Smallest squared sine of which a root is taken: below it G, the cube of the sine, is zero.
_SIN2_MIN = 1e-20


def retro_reflective(g: Geometry, roughness: Scalar) -> Scalar:
    """Burley's factor on Lambert's term: darker at grazing angles where smooth, brighter towards the light where
    rough."""
    # |wi + wo| = 2 cos_d
    excess = 0.5 * roughness * g.h2 - 0.5
    return (1 + excess * schlick_weight(1 - g.cos_i)) * (1 + excess * schlick_weight(1 - g.cos_o))


def subsurface(g: Geometry, roughness: Scalar) -> Scalar:
    """Disney 2012's factor on Lambert's term after Hanrahan and Krueger: flattened by scattering inside."""
    f_ss90 = 0.25 * roughness * g.h2
    f_ss = _fresnel_subsurface(f_ss90, g.cos_i) * _fresnel_subsurface(f_ss90, g.cos_o)
    # 1 / (cos_i + cos_o) - 1/2
    spread = 0.5 * ((1 - g.cos_i) + (1 - g.cos_o)) / (g.cos_i + g.cos_o)
    return 1.25 * (f_ss * spread + 0.5)


def _fresnel_subsurface(f_ss90: Scalar, cos_theta: Scalar) -> Scalar:
    # 1 + (f_ss90 - 1) (1 - cos)^5, which would cancel at grazing angles, from 1 - u^5 = (1 - u) (1 + u + ... + u^4).
    u = 1 - cos_theta
    return cos_theta * (1 + u * (1 + u * (1 + u * (1 + u)))) + f_ss90 * schlick_weight(u)


def single_scattering_loss(cos_theta: Scalar, sin2_theta: Scalar) -> Scalar:
    """`c1 - G / pi` in closed form: proportional to the light that Fujii's single scattering loses."""
    sine = jnp.sqrt(jnp.maximum(sin2_theta, _SIN2_MIN))
    # Expanded about the horizon, where the published terms cancel: pi/2 - theta = atan(cos / sin), and 1 - sin and
    # 1 - sin^3 are multiples of cos^2.
    square = (0.5 * math.pi - 2 / 3) * cos_theta * cos_theta / (1 + sine)
    angle = sine * jnp.arctan2(cos_theta, sine)
    cube = cos_theta * cos_theta * cos_theta * sine * (2 + sine) / (3 * (1 + sine) * (1 + sine))
    return (square + (angle - cube)) / jnp.pi


def energy_preserving(g: Geometry, rho: Color, roughness: Scalar, lost_i: Scalar, lost_o: Scalar) -> Color:
    """EON, the energy-preserving Oren-Nayar term, in 1/sr (Portsmouth 2025, listing 1).

    `lost_i` and `lost_o` are `single_scattering_loss` of both directions, or its published polynomial; see
    `brdf/models/eon.py`.
    """
    a = 1 / (1 + C1 * roughness)
    # 1 + s from |wi + wo|^2 in the tangent plane and the cosines: no difference that opposite directions cancel.
    one_plus_s = 0.5 * (g.h_x * g.h_x + g.h_y * g.h_y + g.cos_i * g.cos_i + g.cos_o * g.cos_o)
    forward = (1 - roughness) + roughness * one_plus_s
    backward = 1 + roughness * (g.dot_xy / jnp.maximum(g.cos_i, g.cos_o))
    single = a * jnp.where(g.dot_xy > 0, backward, forward)

    lost_mean = a * roughness * (C1 - C2)
    rho_ms = rho * rho * (1 - lost_mean) / (1 - rho * lost_mean)
    multiple = a * roughness * (lost_i * lost_o) / (C1 - C2)
    return (rho * single + rho_ms * multiple) / jnp.pi
