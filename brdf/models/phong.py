"""Phong's lobe about the mirror direction, normalised: the form that is reciprocal and conserves energy.

    f = specular (n + 2) / (2 pi) cos^n(angle between wi and the mirror image of wo)

Phong's own formula gives the reflected radiance, without a cosine. As a BRDF that would be divided by cos_i: neither
reciprocal nor bounded. Lafortune and Willems leave the division out. With `specular = 1` all light is reflected at
normal incidence, and less towards grazing, where a sharp lobe reflects cos_o.

- Phong 1975, "Illumination for Computer Generated Pictures".
- Lafortune, Willems 1994, "Using the Modified Phong Reflectance Model for Physically Based Rendering".
"""

from __future__ import annotations

import jax.numpy as jnp

from ..cosine_power import EXPONENT_STARTS, cos_mirror_power
from ..frame import Geometry, Scalar
from ..model import AbstractBRDF, Color
from ..parameter import color, scalar
from ..sampling import Proposals, SpecularLobe


class Phong(AbstractBRDF):
    """Specular reflection as a power of the cosine to the mirror direction."""

    specular: Color = color(0.0, 1.0, 0.04, "fraction of the light that is reflected at normal incidence")
    exponent: Scalar = scalar(
        1.0, 1e5, 50.0, "sharpness of the highlight; the power of the cosine", starts=EXPONENT_STARTS
    )

    def reflect(self, g: Geometry) -> Color:
        return self.specular * ((self.exponent + 2) / (2 * jnp.pi) * cos_mirror_power(g, self.exponent))

    def proposals(self, cos_o: Scalar) -> Proposals:
        # In the plane of incidence cos^n is the half vector's cos^(4 n); across it, it is wider by 1 / cos_o. Of the
        # widths between, this power of cos_o is the least noisy where the lobe is sharp and grazes the surface.
        alpha = jnp.sqrt(1 / (2 * self.exponent + 1)) / (jnp.sqrt(cos_o) * jnp.sqrt(jnp.sqrt(cos_o)))
        weight = jnp.mean(self.specular) * cos_o
        return Proposals(jnp.zeros_like(weight), (SpecularLobe(weight, alpha, alpha, jnp.zeros_like(weight)),))
