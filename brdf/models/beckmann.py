"""Beckmann microfacets: Gaussian slopes, highlights without a tail.

    f = D(theta_h) V(wi, wo) F(theta_d)
    D = exp(-tan^2(theta_h) (cos^2(phi_h)/alpha_x^2 + sin^2(phi_h)/alpha_y^2)) / (pi alpha_x alpha_y cos^4(theta_h))

alpha is the RMS slope, sqrt(2) times the standard deviation of the slope along one axis.

- Beckmann, Spizzichino 1963, "The Scattering of Electromagnetic Waves from Rough Surfaces".
- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
- Kulla, Conty 2017, "Revisiting Physically Based Shading at Imageworks": `energy = multiple`.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..chebyshev import Chebyshev
from ..distributions import cos_lambda_beckmann, d_beckmann
from ..frame import Color, Geometry, Scalar
from ..microfacet import AbstractMicrofacet, claims_with_energy, energy_choice, loss_tables
from ..model import Claims
from ..sampling import Proposals


class Beckmann(AbstractMicrofacet):
    """Microfacet reflection with the Beckmann (Gaussian) distribution of slopes."""

    energy: str = energy_choice()

    def density(self, g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
        return d_beckmann(g, alpha_x, alpha_y)

    def cos_lambda(self, cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
        return cos_lambda_beckmann(cos_theta, alpha_sin2)

    def reflect(self, g: Geometry) -> Color:
        single = self.single_scattering(g)
        return single if self.energy == "single" else single + self.multiple_scattering(g, "beckmann")

    def proposals(self, cos_o: Scalar) -> Proposals:
        return self.mixture(cos_o, 0.0 * cos_o if self.energy == "single" else self.cosine_share(cos_o, "beckmann"))

    def claims(self) -> Claims:
        return claims_with_energy(self, self.energy)

    def tables(self) -> Mapping[str, Chebyshev | None]:
        return loss_tables("beckmann", self.energy)
