"""Ashikhmin and Shirley's anisotropic Phong model: microfacets whose density is a power of the cosine.

    f = sqrt((n_x + 1)(n_y + 1)) / (8 pi) cos^n(theta_h) F(theta_d) / (cos_d max(cos_i, cos_o)),
    n = n_x cos^2(phi_h) + n_y sin^2(phi_h)

and, with `diffuse = coupled`, the light that the surface lets into the body and out again:

    28 / (23 pi) albedo (1 - f0) (1 - (1 - cos_i / 2)^5) (1 - (1 - cos_o / 2)^5)

- Ashikhmin, Shirley 2000, "An Anisotropic Phong BRDF Model", Journal of Graphics Tools 5(2).
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
"""

from __future__ import annotations

import jax.numpy as jnp

from ..cosine_power import EXPONENT_STARTS, cos_h_power, cos_h_power_anisotropic, slope_of_exponent
from ..frame import Geometry, Scalar
from ..fresnel import f_schlick
from ..model import AbstractBRDF, Color
from ..parameter import choice, color, rotation, scalar
from ..sampling import Proposals, SpecularLobe

_ISOTROPIC, _ANISOTROPIC = {"anisotropy": ("isotropic",)}, {"anisotropy": ("anisotropic",)}


def _passage(cos_theta: Scalar) -> Scalar:
    """`1 - (1 - cos / 2)^5`, multiplied out: at grazing angles the difference would cancel."""
    x = jnp.multiply(0.5, cos_theta)
    return x * (5 + x * (-10 + x * (10 + x * (-5 + x))))


class AshikhminShirley(AbstractBRDF):
    """Anisotropic Phong reflection with Schlick's Fresnel term, alone or coupled to a diffuse base."""

    f0: Color = color(0.0, 1.0, 0.04, "Fresnel reflectance at normal incidence")
    exponent: Scalar = scalar(
        1.0, 1e5, 50.0, "sharpness; the power of the cosine", starts=EXPONENT_STARTS, when=_ISOTROPIC
    )
    exponent_x: Scalar = scalar(
        1.0, 1e5, 50.0, "sharpness along the tangent frame's x axis", starts=EXPONENT_STARTS, when=_ANISOTROPIC
    )
    exponent_y: Scalar = scalar(
        1.0, 1e5, 50.0, "sharpness along the tangent frame's y axis", starts=EXPONENT_STARTS, when=_ANISOTROPIC
    )
    rotation: Scalar = rotation(when=_ANISOTROPIC)
    albedo: Color = color(0.0, 1.0, 0.0, "reflectance of the diffuse base", when={"diffuse": ("coupled",)})
    anisotropy: str = choice("isotropic", "anisotropic", doc="one exponent, or two along a tangent frame")
    diffuse: str = choice(
        "none", "coupled", doc="the highlight alone, or with the diffuse base that it leaves light to"
    )

    def reflect(self, g: Geometry) -> Color:
        n_x, n_y, rotation = self._axes()
        if self.anisotropy == "isotropic":
            power = cos_h_power(g, n_x)
        else:
            power = cos_h_power_anisotropic(g, n_x, n_y, rotation)
        d = jnp.sqrt(n_x + 1) * jnp.sqrt(n_y + 1) / (8 * jnp.pi) * power
        value = f_schlick(self.f0, g.one_minus_cos_d) * (d / g.cos_d / jnp.maximum(g.cos_i, g.cos_o))
        if self.diffuse == "none":
            return value
        body = 28 / (23 * jnp.pi) * _passage(g.cos_i) * _passage(g.cos_o)
        return value + self.albedo * (1 - self.f0) * body

    def proposals(self, cos_o: Scalar) -> Proposals:
        n_x, n_y, rotation = self._axes()
        weight = jnp.mean(f_schlick(self.f0, jnp.subtract(1, cos_o)))
        lobe = SpecularLobe(weight, slope_of_exponent(n_x), slope_of_exponent(n_y), rotation)
        diffuse = jnp.zeros_like(weight)
        if self.diffuse == "coupled":
            diffuse = jnp.mean(self.albedo * (1 - self.f0)) * _passage(cos_o)
        return Proposals(diffuse, (lobe,))

    def _axes(self) -> tuple[Scalar, Scalar, Scalar]:
        if self.anisotropy == "isotropic":
            return self.exponent, self.exponent, jnp.zeros_like(self.exponent)
        return self.exponent_x, self.exponent_y, self.rotation
