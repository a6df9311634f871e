"""Oren and Nayar's rough diffuse reflector: Lambertian V-cavities whose slopes are Gaussian.

    f = (rho / pi) (C1 + cos(dphi) C2 tan(beta) + (1 - |cos(dphi)|) C3 tan((alpha + beta) / 2))
        + 0.17 (rho^2 / pi) sigma^2 / (sigma^2 + 0.13) (1 - cos(dphi) (2 beta / pi)^2)

with alpha = max(theta_i, theta_o), beta = min(theta_i, theta_o), dphi = phi_o - phi_i: the full form with
interreflection. The azimuth is undefined at normal incidence; there every term that holds it vanishes, so it never
appears here without the sine that cancels it, or is guarded. The published form turns negative for forward scattering
at grazing angles, where a reflectance cannot be: there it is cut at zero. Where both directions graze the surface,
tan(beta) and tan((alpha + beta) / 2) are huge and their factors vanish: those are computed as differences that float32
holds.

The qualitative form, which most renderers call Oren-Nayar, drops C3 and the interreflection (and with it light: up to
44 % at sigma = pi/2):

    f = (rho / pi) (A + B max(0, cos(dphi)) sin(alpha) tan(beta)),  A = C1,  B = 0.45 sigma^2 / (sigma^2 + 0.09)

Its sines are those of both directions, so that the azimuth and they together are a dot product in the tangent plane.

- Oren, Nayar 1994, "Generalization of Lambert's Reflectance Model", section 4.4 and its qualitative model.
"""

from __future__ import annotations

import jax.numpy as jnp

from ..frame import Color, Geometry, Scalar
from ..model import AbstractBRDF, Claims
from ..parameter import choice, color, scalar
from ..sampling import Proposals

# Smallest product of squared sines at which an azimuth is computed: below it both of its terms round to zero.
_SIN2_MIN = 1e-20


class OrenNayar(AbstractBRDF):
    """Rough diffuse reflection of 1994: the full form with interreflection, or the qualitative one."""

    albedo: Color = color(0.0, 1.0, 0.5, "albedo of the facets")
    sigma: Scalar = scalar(
        0.0,
        1.5707963,
        0.35,
        "standard deviation of the facets' slope angle",
        unit="rad",
        starts=(0.1, 0.4, 0.8),
        fit_square=True,
    )
    form: str = choice("full", "qualitative", doc="the full model with interreflection, or its short form without")

    def reflect(self, g: Geometry) -> Color:
        return self._full(g) if self.form == "full" else self._qualitative(g)

    def proposals(self, cos_o: Scalar) -> Proposals:
        return Proposals(jnp.mean(self.albedo), ())

    def claims(self) -> Claims:
        # With albedo 1, near grazing: the full form reflects up to 5.1 % too much at sigma = 0.31, the qualitative one
        # up to 1.52 % at sigma = 0.2.
        return Claims(albedo_max=1.052 if self.form == "full" else 1.0152)

    def _qualitative(self, g: Geometry) -> Color:
        sigma2 = self.sigma * self.sigma
        a = 1 - 0.5 * sigma2 / (sigma2 + 0.33)
        b = 0.45 * sigma2 / (sigma2 + 0.09)
        # cos(dphi) sin(alpha) tan(beta)
        rough = g.dot_xy / jnp.maximum(g.cos_i, g.cos_o)
        return self.albedo / jnp.pi * (a + b * jnp.maximum(rough, 0))

    def _full(self, g: Geometry) -> Color:
        rho, sigma2 = self.albedo, self.sigma * self.sigma
        sin2_product = g.sin2_i * g.sin2_o
        has_azimuth = sin2_product > _SIN2_MIN
        sin2_i = jnp.where(has_azimuth, g.sin2_i, 0.5 * jnp.ones_like(g.sin2_i))
        sin2_o = jnp.where(has_azimuth, g.sin2_o, 0.5 * jnp.ones_like(g.sin2_o))
        sin_i, sin_o = jnp.sqrt(sin2_i), jnp.sqrt(sin2_o)
        cos_i = jnp.where(has_azimuth, g.cos_i, jnp.sqrt(0.5) * jnp.ones_like(g.cos_i))
        cos_o = jnp.where(has_azimuth, g.cos_o, jnp.sqrt(0.5) * jnp.ones_like(g.cos_o))
        cos_dphi = jnp.clip(g.dot_xy / (sin_i * sin_o), -1, 1)

        # 1 - |cos| = sin^2 / (1 + |cos|), with the sine from the cross product.
        sin_dphi = (g.wi[0] * g.wo[1] - g.wi[1] * g.wo[0]) / (sin_i * sin_o)
        one_minus_cos_dphi = sin_dphi * sin_dphi / (1 + jnp.abs(cos_dphi))

        theta_i, theta_o = jnp.arctan2(sin_i, cos_i), jnp.arctan2(sin_o, cos_o)
        alpha, beta = jnp.maximum(theta_i, theta_o), jnp.minimum(theta_i, theta_o)
        sin_alpha, sin_beta = jnp.maximum(sin_i, sin_o), jnp.minimum(sin_i, sin_o)
        cos_alpha, cos_beta = jnp.minimum(cos_i, cos_o), jnp.maximum(cos_i, cos_o)
        tan_beta = sin_beta / cos_beta
        tan_mean = (sin_i + sin_o) / (cos_i + cos_o)
        ratio_beta = 2 * beta / jnp.pi
        # sin(alpha) - ratio^3 = (1 - ratio^3) - (1 - sin(alpha)), each of which vanishes at grazing angles.
        one_minus_ratio = 2 * jnp.arctan2(cos_beta, sin_beta) / jnp.pi
        one_minus_cube = one_minus_ratio * (1 + ratio_beta + ratio_beta * ratio_beta)
        one_minus_sin_alpha = cos_alpha * cos_alpha / (1 + sin_alpha)

        c1 = 1 - 0.5 * sigma2 / (sigma2 + 0.33)
        c2 = 0.45 * sigma2 / (sigma2 + 0.09)
        c2 = c2 * jnp.where(cos_dphi < 0, one_minus_cube - one_minus_sin_alpha, sin_alpha)
        ratio_product = 4 * alpha * beta / (jnp.pi * jnp.pi)
        c3 = 0.125 * sigma2 / (sigma2 + 0.09) * ratio_product * ratio_product
        rough = cos_dphi * c2 * tan_beta + one_minus_cos_dphi * c3 * tan_mean
        bounce = 0.17 * sigma2 / (sigma2 + 0.13) * (1 - jnp.where(has_azimuth, cos_dphi * ratio_beta * ratio_beta, 0.0))
        direct = c1 + jnp.where(has_azimuth, rough, jnp.zeros_like(rough))
        return rho / jnp.pi * jnp.maximum(direct + rho * bounce, 0)
