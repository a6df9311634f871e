"""Gaussian microfacets: facet angles, not slopes, are normally distributed.

    f = D(theta_h) V(wi, wo) F(theta_d)
    D = exp(-theta_h^2 (cos^2(phi_h)/alpha_x^2 + sin^2(phi_h)/alpha_y^2)) / (pi alpha_x alpha_y norm)

The norm and Smith's masking of this distribution are tables of their quadratures, see `brdf.gaussian`.

- Blinn 1977, "Models of Light Reflection for Computer Synthesized Pictures": the distribution, without its norm.
- Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
- Kulla, Conty 2017, "Revisiting Physically Based Shading at Imageworks": `energy = multiple`.
"""

from __future__ import annotations

from collections.abc import Mapping

from ..chebyshev import Chebyshev
from ..distributions import elliptic_mean
from ..frame import Color, Geometry, Scalar
from ..gaussian import cos_lambda_gaussian, d_gaussian, masking_table, norm_table, seen_slope
from ..microfacet import AbstractMicrofacet, claims_with_energy, energy_choice, loss_tables
from ..model import Claims
from ..sampling import Proposals


class Gaussian(AbstractMicrofacet):
    """Microfacet reflection with a Gaussian distribution of facet angles."""

    energy: str = energy_choice()

    def density(self, g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
        table = norm_table()
        is_round = self.anisotropy == "isotropic"
        norm = table(alpha_x * alpha_y) if is_round else elliptic_mean(table, alpha_x, alpha_y)
        return d_gaussian(g, alpha_x, alpha_y, norm)

    def cos_lambda(self, cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
        is_round = self.anisotropy == "isotropic"
        return cos_lambda_gaussian(cos_theta, self.alpha if is_round else seen_slope(cos_theta, alpha_sin2))

    def reflect(self, g: Geometry) -> Color:
        single = self.single_scattering(g)
        return single if self.energy == "single" else single + self.multiple_scattering(g, "gaussian")

    def proposals(self, cos_o: Scalar) -> Proposals:
        return self.mixture(cos_o, 0.0 * cos_o if self.energy == "single" else self.cosine_share(cos_o, "gaussian"))

    def claims(self) -> Claims:
        return claims_with_energy(self, self.energy)

    def tables(self) -> Mapping[str, Chebyshev | None]:
        own = {"gaussian_norm": norm_table(), "gaussian_masking": masking_table()}
        return {**own, **loss_tables("gaussian", self.energy)}
