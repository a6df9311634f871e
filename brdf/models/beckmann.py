"""Beckmann microfacets: Gaussian slopes, highlights without a tail.

    f = D(theta_h) V(wi, wo) F(theta_d)

- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
"""

from __future__ import annotations

from ..distributions import cos_lambda_beckmann, d_beckmann
from ..frame import Geometry, Scalar
from ..fresnel import f_schlick
from ..masking import VISIBILITY
from ..model import AbstractBRDF, Color
from ..parameter import choice, color, slope


class Beckmann(AbstractBRDF):
    """Microfacet reflection with the Beckmann (Gaussian) distribution of slopes."""

    f0: Color = color(0.0, 1.0, 0.04, "Fresnel reflectance at normal incidence")
    alpha: Scalar = slope(1e-4, 1.0, 0.3, "RMS slope of the surface")
    masking: str = choice(*VISIBILITY, doc="Smith masking, height-correlated or separable")

    def reflect(self, g: Geometry) -> Color:
        d = d_beckmann(g, self.alpha)
        cos_lambda_i = cos_lambda_beckmann(g.cos_i, g.sin2_i, self.alpha)
        cos_lambda_o = cos_lambda_beckmann(g.cos_o, g.sin2_o, self.alpha)
        v = VISIBILITY[self.masking](g, cos_lambda_i, cos_lambda_o)
        f = f_schlick(self.f0, g.one_minus_cos_d)
        return d * v * f
