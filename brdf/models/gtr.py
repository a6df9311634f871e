"""Generalised Trowbridge-Reitz microfacets: the length of the highlight's tail is free.

    f = D(theta_h) V(wi, wo) F(theta_d)
    D ~ 1 / (cos^2(theta_h) + sin^2(theta_h) (cos^2(phi_h)/alpha_x^2 + sin^2(phi_h)/alpha_y^2))^gamma

`gamma = 1` is Berry's distribution, `gamma = 2` is GGX; larger ones approach a Gaussian of slope alpha / sqrt(gamma).
Smith's masking of this family has no closed form: as in the source, that of GGX with the same slope stands for it,
which for gamma below 2 hides too little at grazing angles.

- Burley 2012, "Physically-Based Shading at Disney", SIGGRAPH course notes, appendix B.
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from ..distributions import cos_lambda_ggx, d_gtr, elliptic_mean, gtr_norm
from ..frame import Color, Geometry, Scalar
from ..microfacet import AbstractMicrofacet
from ..model import Claims
from ..parameter import scalar
from ..sampling import Proposals


class GTR(AbstractMicrofacet):
    """Microfacet reflection with the generalised Trowbridge-Reitz distribution of slopes."""

    gamma: Scalar = scalar(0.5, 10.0, 2.0, "exponent of the tail: 1 Berry, 2 GGX", starts=(1.0, 2.0, 4.0))

    def density(self, g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
        if self.anisotropy == "isotropic":
            norm = gtr_norm(alpha_x * alpha_y, self.gamma)
        else:
            norm = elliptic_mean(lambda alpha2: gtr_norm(alpha2, self.gamma), alpha_x, alpha_y)
        return d_gtr(g, alpha_x, alpha_y, self.gamma, norm)

    def cos_lambda(self, cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
        return cos_lambda_ggx(cos_theta, alpha_sin2)

    def reflect(self, g: Geometry) -> Color:
        return self.single_scattering(g)

    def proposals(self, cos_o: Scalar) -> Proposals:
        # Tails longer than GGX's need the cosine beside it.
        return self.mixture(cos_o, jnp.maximum(2 - self.gamma, 0.0))

    def claims(self) -> Claims:
        """GGX's masking does not suit the longer tails of a small gamma: they reflect more than they receive."""
        return Claims(albedo_max=1.0 if self.masking == "v_cavity" else math.inf)
