"""Fresnel reflectance.

- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".

The twin of this file is `shaders/glsl/fresnel.glsl`.
"""

from __future__ import annotations

from .frame import Scalar
from .model import Color


def f_schlick(f0: Color, one_minus_cos_d: Scalar) -> Color:
    """Schlick's approximation (Schlick 1994, eq. 15), from `1 - cos(theta_d)` so that no digit is lost near 0."""
    x2 = one_minus_cos_d * one_minus_cos_d
    return f0 + (1 - f0) * (x2 * x2 * one_minus_cos_d)
