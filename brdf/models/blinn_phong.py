"""Blinn's variant of Phong: a power of the cosine between the normal and the half vector.

    normalized: f = specular D(theta_h) / |wi + wo|^2, with D = (n + 2) / (2 pi) cos^n(theta_h)
    classic:    f = specular cos^n(theta_h)

`normalized` takes the power as a density of microfacets, `D cos` integrating to 1 (Walter 2007), under the visibility
of Kelemen and Szirmay-Kalos, `1 / |wi + wo|^2`; there is no Fresnel term. A perfectly sharp highlight reflects
`specular` at every angle, a wide one less, none more. At the normal the peak is the familiar (n + 2) / (8 pi). The
popular (n + 8) / (8 pi) without a visibility reflects up to 8 % too much and is not offered.

`classic` is the formula of real-time shading, with `specular` the radiance of the peak per unit of irradiance: as a
value in 1/sr it is the BRDF, which the cosine still multiplies. Shaders that leave out that cosine mean f / cos_i,
which is neither reciprocal nor bounded. Nothing is normalised: a wide lobe reflects more light than it receives.

- Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures".
- Kelemen, Szirmay-Kalos 2001, "A Microfacet Based Coupled Specular-Matte BRDF Model with Importance Sampling".
- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from ..cosine_power import EXPONENT_STARTS, cos_h_power, slope_of_exponent
from ..frame import Geometry, Scalar
from ..masking import v_kelemen
from ..model import AbstractBRDF, Claims, Color
from ..parameter import choice, color, scalar
from ..sampling import Proposals, SpecularLobe


class BlinnPhong(AbstractBRDF):
    """Specular reflection as a power of the cosine of the half vector."""

    specular: Color = color(0.0, 1.0, 0.04, "reflectance of the highlight; in the classic form its peak in 1/sr")
    exponent: Scalar = scalar(
        1.0, 1e5, 50.0, "sharpness of the highlight; the power of the cosine", starts=EXPONENT_STARTS
    )
    form: str = choice("normalized", "classic", doc="microfacet density with Kelemen's visibility, or the power alone")

    def reflect(self, g: Geometry) -> Color:
        power = cos_h_power(g, self.exponent)
        if self.form == "classic":
            return self.specular * power
        d = (self.exponent + 2) / (2 * jnp.pi) * power
        return self.specular * (d * v_kelemen(g))

    def proposals(self, cos_o: Scalar) -> Proposals:
        alpha = slope_of_exponent(self.exponent)
        weight = jnp.mean(self.specular) + 0 * cos_o
        if self.form == "classic":
            weight = weight * 8 * jnp.pi / (self.exponent + 8) * cos_o
        return Proposals(jnp.zeros_like(weight), (SpecularLobe(weight, alpha, alpha, jnp.zeros_like(weight)),))

    def claims(self) -> Claims:
        return Claims(albedo_max=math.inf if self.form == "classic" else 1.0)
