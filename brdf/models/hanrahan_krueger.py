"""The subsurface term of Disney 2012: single scattering in a layer, after Hanrahan and Krueger, flatter than Burley's.

    f = (albedo / pi) 1.25 (F_ss (1 / (cos_i + cos_o) - 1/2) + 1/2)
    F_ss = (1 + (F_ss90 - 1) (1 - cos_i)^5) (1 + (F_ss90 - 1) (1 - cos_o)^5)
    F_ss90 = roughness cos_d^2

The factor 1.25 keeps the albedo roughly: with albedo 1 three quarters of the light are reflected at normal incidence,
and half as much again as there was at grazing angles and roughness 1. Where both directions graze the surface,
1 / (cos_i + cos_o) multiplies the error of F_ss, which is therefore computed as a sum of positive terms.

- Hanrahan, Krueger 1993, "Reflection from Layered Surfaces due to Subsurface Scattering".
- Burley 2012, "Physically Based Shading at Disney", section 5.3, with the code of the BRDF Explorer.
"""

from __future__ import annotations

import jax.numpy as jnp

from ..diffuse import subsurface
from ..frame import Color, Geometry, Scalar
from ..model import AbstractBRDF, Claims
from ..parameter import color, scalar
from ..sampling import Proposals


class HanrahanKrueger(AbstractBRDF):
    """Diffuse reflection flattened by subsurface scattering, Disney 2012."""

    albedo: Color = color(0.0, 1.0, 0.5, "colour of the diffuse base: the fraction that is reflected, roughly")
    roughness: Scalar = scalar(
        0.0, 1.0, 0.5, "strength of the retro-reflection; Disney's, alpha = roughness^2", starts=(0.2, 0.8)
    )

    def reflect(self, g: Geometry) -> Color:
        return self.albedo / jnp.pi * subsurface(g, self.roughness)

    def proposals(self, cos_o: Scalar) -> Proposals:
        return Proposals(jnp.mean(self.albedo), ())

    def claims(self) -> Claims:
        # By quadrature, at roughness 1 and a grazing angle.
        return Claims(albedo_max=1.513)
