"""GGX (Trowbridge-Reitz) microfacets: long-tailed highlights, the usual choice for metals, plastics and coatings.

    f = D(theta_h) V(wi, wo) F(theta_d)
    D = 1 / (pi alpha_x alpha_y cos^4(theta_h) (1 + tan^2(theta_h) (cos^2(phi_h)/alpha_x^2 + sin^2(phi_h)/alpha_y^2))^2)

- Trowbridge, Reitz 1975, "Average Irregularity Representation of a Rough Surface for Ray Reflection".
- Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
- Kulla, Conty 2017, "Revisiting Physically Based Shading at Imageworks": `energy = multiple`.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..chebyshev import Chebyshev
from ..distributions import cos_lambda_ggx, d_ggx
from ..frame import Color, Geometry, Scalar
from ..microfacet import AbstractMicrofacet, claims_with_energy, energy_choice, loss_tables
from ..model import Claims
from ..sampling import Proposals


class GGX(AbstractMicrofacet):
    """Microfacet reflection with the GGX distribution of slopes."""

    energy: str = energy_choice()

    def density(self, g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
        return d_ggx(g, alpha_x, alpha_y)

    def cos_lambda(self, cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
        return cos_lambda_ggx(cos_theta, alpha_sin2)

    def reflect(self, g: Geometry) -> Color:
        single = self.single_scattering(g)
        return single if self.energy == "single" else single + self.multiple_scattering(g, "ggx")

    def proposals(self, cos_o: Scalar) -> Proposals:
        return self.mixture(cos_o, 0.0 * cos_o if self.energy == "single" else self.cosine_share(cos_o, "ggx"))

    def claims(self) -> Claims:
        return claims_with_energy(self, self.energy)

    def tables(self) -> Mapping[str, Chebyshev | None]:
        return loss_tables("ggx", self.energy)
