"""EON, the energy-preserving Oren-Nayar model: rough diffuse reflection that loses no light between the facets.

    f = (rho / pi) A (1 + r s / t) + (rho_ms / pi) (1 - E(cos_i)) (1 - E(cos_o)) / (1 - <E>)
    s = wi . wo - cos_i cos_o;  t = max(cos_i, cos_o) where s > 0, else 1;  A = 1 / (1 + c1 r)
    rho_ms = rho^2 <E> / (1 - rho (1 - <E>))

The first term is Fujii's form of Oren and Nayar's single scattering, whose directional albedo E = A (1 + r G / pi) has
a closed form and the average <E> = A (1 + c2 r); the second returns what the first loses. With rho = 1 all light is
reflected, whatever the roughness r; at r = 0 the model is Lambert's. The average cancels from the quotient:
1 - E = A r (c1 - G / pi), which goes to zero at grazing angles and is computed there as a sum that float32 holds, as is
1 + s between opposite directions. Where both directions graze the surface on the same side, the value grows like 1 / t.

- Portsmouth, Kutz, Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), listing 1.
- Fujii 2013, "A tiny improvement of Oren-Nayar reflectance model".
"""

from __future__ import annotations

import jax.numpy as jnp

from ..diffuse import C1, energy_preserving, single_scattering_loss
from ..frame import Color, Geometry, Scalar
from ..model import AbstractBRDF, Claims
from ..parameter import choice, color, scalar
from ..sampling import Proposals

_P1, _P2, _P3, _P4 = 0.0571085289, 0.491881867, -0.332181442, 0.0714429953
# c1 - (P1 x + P2 x^2 + P3 x^3 + P4 x^4), x = 1 - cos, in powers of cos: they hold the digits where it crosses zero.
_LOST_POLYNOMIAL = (
    C1 - (_P1 + _P2 + _P3 + _P4),
    _P1 + 2 * _P2 + 3 * _P3 + 4 * _P4,
    -(_P2 + 3 * _P3 + 6 * _P4),
    _P3 + 4 * _P4,
    -_P4,
)


def _lost_polynomial(cos_theta: Scalar, sin2_theta: Scalar) -> Scalar:
    """`c1 - G / pi` by the published polynomial of G / pi in 1 - cos, which is off by up to 6.1e-4.

    It exceeds c1 at the horizon, where the difference is cut.
    """
    lost = jnp.zeros_like(cos_theta)
    for coefficient in reversed(_LOST_POLYNOMIAL):
        lost = lost * cos_theta + coefficient
    return jnp.maximum(lost, 0)


_LOST = {"exact": single_scattering_loss, "polynomial": _lost_polynomial}


class EON(AbstractBRDF):
    """Rough diffuse reflection that preserves energy, Fujii's Oren-Nayar with multiple scattering."""

    albedo: Color = color(0.0, 1.0, 0.5, "single-scattering albedo of the facets")
    roughness: Scalar = scalar(0.0, 1.0, 0.5, "weight of the rough part; 0 is Lambert's model", starts=(0.1, 0.4, 0.8))
    albedo_form: str = choice(
        *_LOST, doc="directional albedo of the single scattering: closed form, or the published polynomial"
    )

    def reflect(self, g: Geometry) -> Color:
        lost = _LOST[self.albedo_form]
        lost_i, lost_o = lost(g.cos_i, g.sin2_i), lost(g.cos_o, g.sin2_o)
        return energy_preserving(g, self.albedo, self.roughness, lost_i, lost_o)

    def proposals(self, cos_o: Scalar) -> Proposals:
        return Proposals(jnp.mean(self.albedo), ())

    def claims(self) -> Claims:
        # The polynomial errs, by quadrature at roughness 1, from -5.5e-4 to 1.5e-4 of the light.
        return Claims(albedo_max=1.0 if self.albedo_form == "exact" else 1.0002)
