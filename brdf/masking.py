"""Masking and shadowing, as visibility `V = G / (4 cos_i cos_o)`, which stays finite where G and a cosine vanish.

- Smith 1967, "Geometrical shadowing of a random rough surface".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
- Karis 2013, "Real Shading in Unreal Engine 4": Schlick's constant k.
- Torrance, Sparrow 1967, "Theory for Off-Specular Reflection from Roughened Surfaces": V-cavities.
- Neumann, Neumann, Szirmay-Kalos 1999, "Compact Metallic Reflectance Models".
- Kelemen, Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling".

The twin of this file is `shaders/glsl/masking.glsl`.
"""

from __future__ import annotations

import jax.numpy as jnp

from .frame import Geometry, Scalar


def v_smith(g: Geometry, cos_lambda_i: Scalar, cos_lambda_o: Scalar) -> Scalar:
    """Smith visibility with height correlation (Heitz 2014, eq. 99); `cos_lambda` from `brdf.distributions`."""
    return 0.25 / (g.cos_i * g.cos_o + g.cos_o * cos_lambda_i + g.cos_i * cos_lambda_o)


def v_smith_separable(g: Geometry, cos_lambda_i: Scalar, cos_lambda_o: Scalar) -> Scalar:
    """Smith visibility of independent masking and shadowing (Heitz 2014, eq. 98)."""
    return 0.25 / ((g.cos_i + cos_lambda_i) * (g.cos_o + cos_lambda_o))


def v_schlick(g: Geometry, k: Scalar) -> Scalar:
    """Schlick's rational masking (Schlick 1994), with `k` from `k_direct` or `k_image_based`."""
    return 0.25 / ((g.cos_i * (1 - k) + k) * (g.cos_o * (1 - k) + k))


def k_direct(alpha: Scalar) -> Scalar:
    """Schlick's k for direct light: (r + 1)^2 / 8 of the perceptual roughness r = sqrt(alpha) (Karis 2013)."""
    r = jnp.sqrt(alpha) + 1
    return r * r / 8


def k_image_based(alpha: Scalar) -> Scalar:
    """Schlick's k for image-based light: r^2 / 2 of the perceptual roughness r = sqrt(alpha) (Karis 2013)."""
    return alpha / 2


def v_cavity(g: Geometry) -> Scalar:
    """V-cavities: G = min(1, 2 cos_h cos_i / cos_d, 2 cos_h cos_o / cos_d) (Torrance and Sparrow 1967)."""
    cos_min, cos_max = jnp.minimum(g.cos_i, g.cos_o), jnp.maximum(g.cos_i, g.cos_o)
    cos_h = g.m_z / jnp.sqrt(g.m2)
    return jnp.minimum(1, 2 * cos_h * (cos_min / g.cos_d)) * (0.25 / cos_max) / cos_min


def v_neumann(g: Geometry) -> Scalar:
    """G = min(cos_i, cos_o), that is cos_i cos_o / max(cos_i, cos_o) (Neumann 1999)."""
    return 0.25 / jnp.maximum(g.cos_i, g.cos_o)


def v_kelemen(g: Geometry) -> Scalar:
    """G = cos_i cos_o / cos^2(theta_d) (Kelemen and Szirmay-Kalos 2001)."""
    return 0.25 / (g.cos_d * g.cos_d)
