"""What the microfacet models share: their parameters and choices, and the product of density, visibility and Fresnel.

    f = D(h) V(wi, wo) F(theta_d)  [+ multiple scattering]

A model of this kind adds its distribution. The twin of this file is `shaders/glsl/microfacet.glsl`.
"""

from __future__ import annotations

import abc
import math
from collections.abc import Mapping
from typing import Any

import jax.numpy as jnp

from .chebyshev import Chebyshev
from .distributions import alpha_sin2
from .energy import directional_loss, loss_table, mean_loss_table, multiple_scattering
from .frame import Color, Geometry, Scalar, turned
from .fresnel import (
    f_conductor,
    f_dielectric,
    f_schlick,
    f_schlick_f82,
    f_schlick_f90,
    f_spherical_gaussian,
)
from .masking import (
    k_direct,
    k_image_based,
    v_cavity,
    v_kelemen,
    v_neumann,
    v_schlick,
    v_smith,
    v_smith_separable,
)
from .model import AbstractBRDF, Claims
from .parameter import choice, color, rotation, scalar, slope
from .sampling import Proposals, SpecularLobe

# Option of `masking` -> visibility of (g, cos_lambda_i, cos_lambda_o, alpha).
VISIBILITY = {
    "smith": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_smith(g, cos_lambda_i, cos_lambda_o),
    "smith_separable": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_smith_separable(g, cos_lambda_i, cos_lambda_o),
    "schlick_direct": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_schlick(g, k_direct(alpha)),
    "schlick_image_based": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_schlick(g, k_image_based(alpha)),
    "v_cavity": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_cavity(g),
    "neumann": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_neumann(g),
    "kelemen": lambda g, cos_lambda_i, cos_lambda_o, alpha: v_kelemen(g),
}
# Those with which no more light leaves than arrives, whatever the parameters.
_CONSERVING = ("smith", "smith_separable", "v_cavity")
_ISOTROPIC, _ANISOTROPIC = {"anisotropy": ("isotropic",)}, {"anisotropy": ("anisotropic",)}


class AbstractMicrofacet(AbstractBRDF):
    """A model of mirror facets: everything but the distribution of their normals."""

    f0: Color = color(
        0.0,
        1.0,
        0.04,
        "Fresnel reflectance at normal incidence",
        when={"fresnel": ("schlick", "schlick_f90", "schlick_f82", "spherical_gaussian")},
    )
    f90: Color = color(0.0, 1.0, 1.0, "Fresnel reflectance at grazing incidence", when={"fresnel": ("schlick_f90",)})
    f82: Color = color(0.0, 1.0, 1.0, "tint of the reflectance at 82 degrees", when={"fresnel": ("schlick_f82",)})
    ior: Scalar = scalar(
        1.0, 4.0, 1.5, "index of refraction", starts=(1.2, 1.5, 2.0), when={"fresnel": ("dielectric",)}
    )
    eta: Color = color(1e-3, 10.0, 1.0, "real part of the index of refraction", when={"fresnel": ("conductor",)})
    k: Color = color(1e-3, 20.0, 4.0, "imaginary part of the index of refraction", when={"fresnel": ("conductor",)})
    alpha: Scalar = slope(1e-4, 1.0, 0.3, "slope of the facets; the square of perceptual roughness", when=_ISOTROPIC)
    alpha_x: Scalar = slope(1e-4, 1.0, 0.3, "slope along the tangent frame's x axis", when=_ANISOTROPIC)
    alpha_y: Scalar = slope(1e-4, 1.0, 0.3, "slope along the tangent frame's y axis", when=_ANISOTROPIC)
    rotation: Scalar = rotation(when=_ANISOTROPIC)
    masking: str = choice(*VISIBILITY, doc="which facets see light and viewer")
    fresnel: str = choice(
        "schlick",
        "schlick_f90",
        "schlick_f82",
        "spherical_gaussian",
        "dielectric",
        "conductor",
        doc="how the reflectance of a facet rises towards grazing angles",
    )
    anisotropy: str = choice("isotropic", "anisotropic", doc="one slope, or two along a tangent frame")

    @abc.abstractmethod
    def density(self, g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
        """The density of normals in 1/sr."""

    @abc.abstractmethod
    def cos_lambda(self, cos_theta: Scalar, alpha_sin2: Scalar) -> Scalar:
        """`cos(theta) Lambda(theta)` of Smith's masking, see `brdf.distributions`."""

    def slopes(self) -> tuple[Scalar, Scalar]:
        """The slopes along the axes."""
        return (self.alpha_x, self.alpha_y) if self.anisotropy == "anisotropic" else (self.alpha, self.alpha)

    def mean_slope(self) -> Scalar:
        """The geometric mean of the slopes."""
        return jnp.sqrt(self.alpha_x * self.alpha_y) if self.anisotropy == "anisotropic" else jnp.asarray(self.alpha)

    def fresnel_reflectance(self, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
        """The reflectance of a facet."""
        if self.fresnel == "schlick":
            return f_schlick(self.f0, one_minus_cos_d)
        if self.fresnel == "schlick_f90":
            return f_schlick_f90(self.f0, self.f90, cos_d, one_minus_cos_d)
        if self.fresnel == "schlick_f82":
            return f_schlick_f82(self.f0, self.f82, cos_d, one_minus_cos_d)
        if self.fresnel == "spherical_gaussian":
            return f_spherical_gaussian(self.f0, cos_d)
        if self.fresnel == "dielectric":
            return f_dielectric(self.ior, cos_d) * jnp.ones(3, cos_d.dtype)
        return f_conductor(self.eta, self.k, cos_d, one_minus_cos_d)

    def single_scattering(self, g: Geometry) -> Color:
        """D V F."""
        if self.anisotropy == "anisotropic":
            g = turned(g, self.rotation)
        alpha_x, alpha_y = self.slopes()
        cos_lambda_i = self.cos_lambda(g.cos_i, alpha_sin2(g.wi, alpha_x, alpha_y))
        cos_lambda_o = self.cos_lambda(g.cos_o, alpha_sin2(g.wo, alpha_x, alpha_y))
        v = VISIBILITY[self.masking](g, cos_lambda_i, cos_lambda_o, self.mean_slope())
        return self.density(g, alpha_x, alpha_y) * v * self.fresnel_reflectance(g.cos_d, g.one_minus_cos_d)

    def multiple_scattering(self, g: Geometry, distribution: str) -> Color:
        """What a model that drops light after one facet has lost, see `brdf.energy`."""
        return multiple_scattering(distribution, g, self.mean_slope(), self.fresnel_reflectance)

    def cosine_share(self, cos_o: Scalar, distribution: str) -> Scalar:
        """What of the cosine is proposed beside facets of weight 1: as much light as several facets reflect, and more
        at wide slopes, where the facets' own proposals are GGX's whatever they are."""
        alpha = self.mean_slope()
        return directional_loss(distribution, cos_o, alpha) + alpha * alpha

    def mixture(self, cos_o: Scalar, diffuse: Scalar) -> Proposals:
        """GGX normals of these slopes, and a share `diffuse` of the cosine beside them."""
        alpha_x, alpha_y = self.slopes()
        weight = jnp.mean(self.fresnel_reflectance(cos_o, 1 - cos_o))
        rotation = self.rotation if self.anisotropy == "anisotropic" else jnp.zeros_like(weight)
        return Proposals(diffuse * weight, (SpecularLobe(weight, alpha_x, alpha_y, rotation),))

    def claims(self) -> Claims:
        return Claims(albedo_max=1.0 if self.masking in _CONSERVING else math.inf)


def claims_with_energy(model: AbstractMicrofacet, energy: str) -> Claims:
    """What a model with the choice `energy` claims: a furnace to 6e-3 where the tables are its own, those of equal
    slopes and Smith's masking."""
    if energy == "single":
        return AbstractMicrofacet.claims(model)
    is_own = model.masking in ("smith", "smith_separable") and model.anisotropy == "isotropic"
    return Claims(albedo_max=1.006 if is_own else math.inf)


def energy_choice() -> Any:
    """Declares the choice `energy` of a model whose distribution has loss tables."""
    return choice("single", "multiple", doc="one reflection alone, or with what further facets reflect (Smith masking)")


def loss_tables(distribution: str, energy: str) -> Mapping[str, Chebyshev | None]:
    """The tables that `multiple_scattering` of a model's GLSL twin calls; see `AbstractBRDF.tables`."""
    used = energy == "multiple"
    return {
        f"{distribution}_loss": loss_table(distribution) if used else None,
        f"{distribution}_mean_loss": mean_loss_table(distribution) if used else None,
    }
