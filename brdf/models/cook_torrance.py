"""Cook and Torrance's model: Beckmann microfacets in V-shaped grooves.

    f = D(theta_h) V(wi, wo) F(theta_d),    V = G / (4 cos_i cos_o),
    G = min(1, 2 cos_h cos_o / cos_d, 2 cos_h cos_i / cos_d)

The paper of 1982 prints `D G F / (pi cos_i cos_o)` with `D = exp(-tan^2(theta_h) / m^2) / (m^2 cos^4(theta_h))`. That
1 / pi is part of today's D, and mirror facets lead to a further 1 / 4: what is implemented reflects no more light than
it receives, and is a quarter of the printed formula. `alpha` is the paper's RMS slope `m`.

- Cook, Torrance 1982, "A Reflectance Model for Computer Graphics", ACM TOG 1(1).
- Torrance, Sparrow 1967, "Theory for Off-Specular Reflection from Roughened Surfaces".
- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
"""

from __future__ import annotations

import jax.numpy as jnp

from ..distributions import d_beckmann
from ..frame import Geometry, Scalar
from ..fresnel import f_dielectric, f_schlick
from ..masking import v_cavity
from ..model import AbstractBRDF, Color
from ..parameter import choice, color, scalar, slope
from ..sampling import Proposals, SpecularLobe


class CookTorrance(AbstractBRDF):
    """Microfacet reflection of 1982: Beckmann slopes, V-cavities, Schlick's or the exact dielectric Fresnel term."""

    f0: Color = color(0.0, 1.0, 0.04, "Fresnel reflectance at normal incidence", when={"fresnel": ("schlick",)})
    ior: Scalar = scalar(
        1.0, 4.0, 1.5, "index of refraction", starts=(1.2, 1.5, 2.0), when={"fresnel": ("dielectric",)}
    )
    alpha: Scalar = slope(1e-4, 1.0, 0.3, "RMS slope of the surface")
    fresnel: str = choice("schlick", "dielectric", doc="Schlick's Fresnel term, or the exact one of a dielectric")

    def reflect(self, g: Geometry) -> Color:
        d = d_beckmann(g, self.alpha, self.alpha)
        return d * v_cavity(g) * self._fresnel(g.cos_d, g.one_minus_cos_d)

    def proposals(self, cos_o: Scalar) -> Proposals:
        weight = jnp.mean(self._fresnel(cos_o, jnp.subtract(1, cos_o)))
        return Proposals(jnp.zeros_like(weight), (SpecularLobe(weight, self.alpha, self.alpha, 0 * weight),))

    def _fresnel(self, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
        if self.fresnel == "schlick":
            return f_schlick(self.f0, one_minus_cos_d)
        return f_dielectric(self.ior, cos_d) * jnp.ones(3, cos_d.dtype)
