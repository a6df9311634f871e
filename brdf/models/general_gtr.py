"""GTR facets whose highlight widens with the angle of incidence and whose reflectance rises as a free power.

    f = D(theta_h, theta_d) V(wi, wo) F(theta_d)
    D = 1 / (pi alpha_d^2 norm) 1 / (1 + b sin^2(theta_h))^gamma,  1 / alpha_d^2 = 1 + b
    b = (1 / alpha^2 - 1) cos(theta_d)^(2 spread)
    F = f0 + (f90 - f0) (1 - cos(theta_d))^falloff

With `spread = 0` and `falloff = 5` this is `gtr` with V-cavities. Facets alone give a highlight that depends on the
tilt of the half vector, whatever the angle between the directions. Where a surface is so smooth that it diffracts, or
an instrument blurs a sharp reflection, the width stays the same in wi + wo instead, whose tangential part is
2 cos(theta_d) sin(theta_h): that is `spread = 1` (the two models of Low 2012). Measured highlights lie between, and
some beyond. The width enters the norm of D, so that a wider highlight is as much lower.

It was made to follow measurements. Over the 70 materials of MERL at phi_d = 90 degrees and theta below 75 degrees the
mean of |log(1 + f cos_i) - log(1 + y cos_i)| is 0.055 for `lambert+ggx`, 0.022 for `lambert+general_gtr` and 0.014 for
two of its lobes. Nothing keeps it from reflecting more light than it gets.

- Burley 2012, "Physically-Based Shading at Disney", SIGGRAPH course notes, appendix B: the tail.
- Low, Kronander, Ynnerman, Unger 2012, "BRDF Models for Accurate and Efficient Rendering of Glossy Surfaces".
- Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering"; MaterialX frees its exponent.
- Torrance, Sparrow 1967, "Theory for Off-Specular Reflection from Roughened Surfaces": V-cavities.
"""

from __future__ import annotations

import math

import jax.numpy as jnp

from ..distributions import gtr_norm
from ..frame import Color, Geometry, Scalar
from ..masking import v_cavity
from ..model import AbstractBRDF, Claims
from ..parameter import color, scalar, slope
from ..sampling import Proposals, SpecularLobe

# What widens or narrows the highlight stops at 89.4 degrees: its height, times the visibility, would leave float32.
_COS_D_MIN = 1e-2
# No highlight gets narrower than that of the smallest slope, at any angle: its derivatives would leave float32 too.
_INVERSE_MAX = 1e8
# 1 - cos(theta_d) below which the rise of the reflectance is zero, to the precision of its smallest power.
_VERSINE_MIN = 1e-18


class GeneralGTR(AbstractBRDF):
    """Specular reflection of free tail, free rise towards grazing angles and a width that changes with the angle."""

    f0: Color = color(0.0, 1.0, 0.04, "reflectance at normal incidence")
    f90: Color = color(0.0, 1.0, 1.0, "reflectance at grazing incidence")
    alpha: Scalar = slope(1e-4, 1.0, 0.3, "slope of the facets at normal incidence; perceptual roughness squared")
    gamma: Scalar = scalar(0.5, 10.0, 2.0, "exponent of the tail: 1 Berry, 2 GGX", starts=(1.0, 2.0, 4.0))
    spread: Scalar = scalar(
        -1.0, 1.0, 0.0, "how the highlight widens with the angle: 0 facets, 1 diffraction or blur", starts=(0.0,)
    )
    falloff: Scalar = scalar(0.5, 10.0, 5.0, "power of 1 - cos(theta_d) in the reflectance; Schlick's is 5")

    def reflect(self, g: Geometry) -> Color:
        b = self._inverse(g.cos_d)
        sin2_h = (g.m_x * g.m_x + g.m_y * g.m_y) / g.m2
        # In two halves: a power may lie below the range of float32 where the density does not.
        decay = jnp.exp(-0.5 * self.gamma * jnp.log1p(b * sin2_h))
        d = decay * ((1 + b) / (jnp.pi * gtr_norm(1 / (1 + b), self.gamma))) * decay
        return d * v_cavity(g) * self._fresnel(g.cos_d, g.one_minus_cos_d)

    def proposals(self, cos_o: Scalar) -> Proposals:
        weight = jnp.mean(self._fresnel(cos_o, jnp.subtract(1, cos_o)))
        alpha = 1 / jnp.sqrt(1 + self._inverse(cos_o))
        # The tail is longer than GGX's below gamma = 2, and the width at cos_o is not that at every cos_d.
        share = 0.1 + jnp.maximum(2 - self.gamma, 0.0)
        return Proposals(share * weight, (SpecularLobe(weight, alpha, alpha, 0 * weight),))

    def claims(self) -> Claims:
        return Claims(albedo_max=math.inf)

    def _inverse(self, cos_d: Scalar) -> Scalar:
        """`1 / alpha_d^2 - 1`, the inverse square of the width at this angle."""
        at_normal = (1 - self.alpha) * (1 + self.alpha) / self.alpha / self.alpha
        return jnp.minimum(at_normal * jnp.exp(2 * self.spread * jnp.log(jnp.maximum(cos_d, _COS_D_MIN))), _INVERSE_MAX)

    def _fresnel(self, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
        # -log of the rise: from the cosine where the rise is near 1, so that 1 - rise keeps its digits.
        versine = jnp.maximum(one_minus_cos_d, _VERSINE_MIN)
        exponent = self.falloff * jnp.log1p(cos_d / versine)
        return self.f0 * -jnp.expm1(-exponent) + self.f90 * jnp.exp(-exponent)
