"""Burley's diffuse term of Disney 2012: at grazing angles darker than Lambert's where smooth, brighter where rough.

    f = (albedo / pi) (1 + (F_D90 - 1) (1 - cos_i)^5) (1 + (F_D90 - 1) (1 - cos_o)^5)
    F_D90 = 0.5 + 2 roughness cos_d^2

It was fitted to measurements, not derived: with albedo 1 and roughness above 0.4 it reflects more light than it gets,
at grazing angles and roughness 1 half as much again.

- Burley 2012, "Physically Based Shading at Disney", section 5.3, with the code of the BRDF Explorer.
"""

from __future__ import annotations

import jax.numpy as jnp

from ..diffuse import retro_reflective
from ..frame import Color, Geometry, Scalar
from ..model import AbstractBRDF, Claims
from ..parameter import color, scalar
from ..sampling import Proposals


class Burley(AbstractBRDF):
    """Diffuse reflection with retro-reflection, Disney 2012."""

    albedo: Color = color(0.0, 1.0, 0.5, "colour of the diffuse base: the fraction that is reflected, roughly")
    roughness: Scalar = scalar(
        0.0, 1.0, 0.5, "from darkened to brightened at grazing angles; Disney's, alpha = roughness^2", starts=(0.2, 0.8)
    )

    def reflect(self, g: Geometry) -> Color:
        return self.albedo / jnp.pi * retro_reflective(g, self.roughness)

    def proposals(self, cos_o: Scalar) -> Proposals:
        return Proposals(jnp.mean(self.albedo), ())

    def claims(self) -> Claims:
        # At roughness 1 and a grazing angle: 3/2 + 29/504, the integral in closed form.
        return Claims(albedo_max=1.5576)
