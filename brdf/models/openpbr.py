"""OpenPBR Surface 1.1, the opaque part: a metallic or glossy-diffuse base under a coat under fuzz.

    f = fuzz_weight f_fuzz + (1 - fuzz_weight E_fuzz(cos_o)) f_coated
    f_coated = C f_coat + lerp(1, T (1 - E_coat(cos_o)), C) lerp(1, Delta, C coat_darkening) f_base,    C = coat_weight
    f_base = lerp(specular_color F D V + (1 - E(cos_o)) f_EON, F_82 D V, base_metalness)

with GGX and Smith's height-correlated masking, exact dielectric Fresnel terms F, the F82-tint metal, EON of
`base_weight base_color`, and the fuzz of Zeltner et al. (`brdf/sheen.py`). The specification leaves open how layers
interact; taken here are its recommendations: albedo scaling towards the viewer, modulation of the index by
`specular_weight`, the coat's effect on the base's index (with the ratio inverted where the coat is the denser one) and
roughness, darkening Delta = (1 - K) / (1 - E_b K) with K between the smooth and the rough base's, and absorption
T = coat_color^((1 / mu_i + 1 / mu_o) / 2) along the refracted paths mu. The albedos E come from fits made for this
project (`brdf/layering.py`) and, for the fuzz, from MaterialX's.

Left out: subsurface, transmission, thin film, thin walls, opacity and emission; the coat's own anisotropy and normal;
multiple scattering between facets, which the specification allows to lose. `specular_weight` ends at 1, indices at 3.
Roughnesses below 0.01 act as 0.01. The fuzz, and every layer by what it leaves to those below, takes the viewer's angle
alone: the model is not reciprocal. From light all around it never sends the viewer more than that light, but for 1 or
2 % by the errors of the fits; of light from one grazing direction the fuzz sends out up to 2.7 times what came in.

- Academy Software Foundation, "OpenPBR Surface" 1.1, specification and MaterialX reference implementation.
- Kutz, Hasan, Edmondson 2021, "Novel Aspects of the Adobe Standard Material": the F82 tint and the inverted ratio.
- Portsmouth, Kutz, Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF".
- Zeltner, Burley, Chiang 2022, "Practical Multiple-Scattering Sheen Using Linearly Transformed Cosines".
"""

from __future__ import annotations

import math
from typing import ClassVar

import jax.numpy as jnp

from ..diffuse import energy_preserving, single_scattering_loss
from ..distributions import alpha_sin2, cos_lambda_ggx, d_ggx
from ..frame import Color, Geometry, Scalar, turned
from ..fresnel import f_schlick_f82
from ..layering import (
    dielectric_albedo,
    dielectric_transmission,
    f0_of_ior,
    f_dielectric_f0,
    mean_dielectric,
    t_dielectric_f0,
)
from ..masking import v_smith
from ..model import AbstractBRDF, Claims
from ..parameter import color, is_absent, rotation, scalar
from ..sampling import Proposals, SpecularLobe
from ..sheen import fuzz, fuzz_albedo

_ROUGHNESS_MIN, _ALPHA_MIN = 0.01, 1e-4
# Below it a coat is black: its logarithm is finite and every power of it is nothing.
_TRANSMITTANCE_MIN = 1e-30
_ROUGHNESS_STARTS = (0.1, 0.3, 0.6)


def coated_roughness(roughness: Scalar, coat_roughness: Scalar, coat_weight: Scalar | float) -> Scalar:
    """Roughness of the base as seen through a rough coat (OpenPBR 1.1, "Roughening")."""
    r, r_coat = jnp.maximum(roughness, _ROUGHNESS_MIN), jnp.maximum(coat_roughness, _ROUGHNESS_MIN)
    r2, r2_coat = r * r, r_coat * r_coat
    roughened = jnp.sqrt(jnp.sqrt(jnp.minimum(r2 * r2 + 2 * r2_coat * r2_coat, 1)))
    return (1 - coat_weight) * r + coat_weight * roughened


def slopes(roughness: Scalar, anisotropy: Scalar | float) -> tuple[Scalar, Scalar]:
    """GGX slopes along and across the tangent, with the mean square of the isotropic one (OpenPBR 1.1, "Microfacet
    model")."""
    across = 1 - anisotropy
    alpha_x = roughness * roughness * jnp.sqrt(2 / (1 + across * across))
    return alpha_x, jnp.maximum(across * alpha_x, _ALPHA_MIN)


def viewed_slope(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    """The slope in the plane of the viewer where it grazes, the mean over both axes where it is above."""
    mean_square = 0.5 * (alpha_x * alpha_x + alpha_y * alpha_y)
    return jnp.sqrt(jnp.minimum(alpha_sin2(g.wo, alpha_x, alpha_y) + mean_square * (g.cos_o * g.cos_o), 1))


def specular_f0(specular_ior: Scalar, coat_ior: Scalar, coat_weight: Scalar | float) -> Scalar:
    """Reflectance of the base dielectric at normal incidence below air and coat (OpenPBR 1.1, "Coat")."""
    below_coat = jnp.abs(specular_ior - coat_ior) / jnp.minimum(specular_ior, coat_ior)
    # The index less 1, which a coat of nearly the same index makes small.
    excess = (1 - coat_weight) * (specular_ior - 1) + coat_weight * below_coat
    return jnp.square(excess / (2 + excess))


def coat_absorption(coat_color: Color, coat_ior: Scalar, g: Geometry) -> Color:
    """What the coat lets through along the refracted paths in and out (OpenPBR 1.1, "View-dependent absorption")."""
    excess = (coat_ior - 1) * (coat_ior + 1)
    length_i = coat_ior / jnp.sqrt(g.cos_i * g.cos_i + excess)
    length_o = coat_ior / jnp.sqrt(g.cos_o * g.cos_o + excess)
    return jnp.exp(0.5 * (length_i + length_o) * jnp.log(jnp.maximum(coat_color, _TRANSMITTANCE_MIN)))


def _d_v(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha_x, alpha_y))
    cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha_x, alpha_y))
    return d_ggx(g, alpha_x, alpha_y) * v_smith(g, cos_lambda_i, cos_lambda_o)


class OpenPBR(AbstractBRDF):
    """OpenPBR Surface 1.1 without its translucent parts: base, specular, coat and fuzz."""

    mixes_channels: ClassVar[bool] = False

    base_weight: Scalar = scalar(
        0.0, 1.0, 1.0, "multiplier of the base colour", held=(1.0,), because="trades off exactly with base_color"
    )
    base_color: Color = color(0.0, 1.0, 0.8, "diffuse albedo of a dielectric, reflectance of a metal")
    base_diffuse_roughness: Scalar = scalar(
        0.0, 1.0, 0.0, "roughness of the diffuse term: 0 is Lambert's", starts=(0.0, 0.5)
    )
    base_metalness: Scalar = scalar(
        0.0,
        1.0,
        0.0,
        "from a dielectric with a diffuse base to a metal",
        weight=True,
        held=(0.0, 1.0),
        because="trades off with base_color and specular_color",
    )
    specular_weight: Scalar = scalar(
        0.0,
        1.0,
        1.0,
        "multiplier of the base's reflectance at normal incidence",
        held=(1.0,),
        because="trades off with specular_ior and specular_color",
    )
    specular_color: Color = color(0.0, 1.0, 1.0, "tint of a dielectric's highlight, and of a metal's at 82 degrees")
    specular_roughness: Scalar = scalar(
        0.0, 1.0, 0.3, "perceptual roughness of the base: alpha = roughness^2", starts=_ROUGHNESS_STARTS
    )
    specular_ior: Scalar = scalar(
        1.0,
        3.0,
        1.5,
        "index of refraction of the base",
        starts=(1.2, 1.5, 2.0),
        held=(1.5,),
        because="trades off with specular_color but for grazing data",
    )
    specular_roughness_anisotropy: Scalar = scalar(
        0.0,
        1.0,
        0.0,
        "elongation of the base's highlight along the tangent",
        starts=(0.0, 0.5),
        weight=True,
        azimuthal=True,
    )
    rotation: Scalar = rotation()
    coat_weight: Scalar = scalar(0.0, 1.0, 0.0, "share of the surface that the coat covers", weight=True)
    coat_color: Color = color(0.0, 1.0, 1.0, "what the coat lets through in and out, at normal incidence")
    coat_roughness: Scalar = scalar(
        0.0, 1.0, 0.0, "perceptual roughness of the coat: alpha = roughness^2", starts=_ROUGHNESS_STARTS
    )
    coat_ior: Scalar = scalar(
        1.0,
        3.0,
        1.6,
        "index of refraction of the coat",
        starts=(1.2, 1.6, 2.0),
        held=(1.6,),
        because="trades off with coat_weight but for grazing data",
    )
    coat_darkening: Scalar = scalar(
        0.0,
        1.0,
        1.0,
        "how much the coat's inner reflections darken the base",
        held=(1.0,),
        because="trades off with base_color under a coat",
    )
    fuzz_weight: Scalar = scalar(0.0, 1.0, 0.0, "share of the surface that the fuzz covers", weight=True)
    fuzz_color: Color = color(0.0, 1.0, 1.0, "colour of the fuzz")
    fuzz_roughness: Scalar = scalar(0.0, 1.0, 0.5, "from fibres along the normal to dust", starts=_ROUGHNESS_STARTS)

    def reflect(self, g: Geometry) -> Color:
        coated = self._base(g) if is_absent(self.coat_weight) else self._coated(g)
        if is_absent(self.fuzz_weight):
            return coated
        fibres = self.fuzz_weight * self.fuzz_color * fuzz(g, self.fuzz_roughness)
        return fibres + (1 - self.fuzz_weight * fuzz_albedo(g.cos_o, self.fuzz_roughness)) * coated

    def proposals(self, cos_o: Scalar) -> Proposals:
        cos_o = jnp.asarray(cos_o)
        f0_coat, alpha_coat = f0_of_ior(self.coat_ior), self._coat_alpha()
        covered = self.fuzz_weight * fuzz_albedo(cos_o, self.fuzz_roughness)
        coat = self.coat_weight * (1 - covered) * dielectric_albedo(f0_coat, cos_o, alpha_coat)
        passed = dielectric_transmission(f0_coat, cos_o, alpha_coat) * jnp.mean(self.coat_color)
        below = (1 - covered) * ((1 - self.coat_weight) + self.coat_weight * passed)

        base_color = self.base_weight * jnp.mean(self.base_color)
        roughness = self._roughness()
        gloss = jnp.mean(self.specular_color) * dielectric_albedo(self._base_f0(), cos_o, roughness * roughness)
        diffuse = base_color * dielectric_transmission(self._base_f0(), cos_o, roughness * roughness)
        metal = jnp.mean(self._metal(cos_o, 1 - cos_o))
        specular = (1 - self.base_metalness) * gloss + self.base_metalness * metal
        alpha_x, alpha_y = slopes(roughness, self.specular_roughness_anisotropy)
        base_lobe = SpecularLobe(below * specular, alpha_x, alpha_y, self.rotation)
        coat_lobe = SpecularLobe(coat, alpha_coat, alpha_coat, 0 * coat)
        # The cosine stands for the diffuse base and for the fuzz, both broad.
        broad = covered * jnp.mean(self.fuzz_color) + below * (1 - self.base_metalness) * diffuse
        return Proposals(broad, (base_lobe,) if is_absent(self.coat_weight) else (base_lobe, coat_lobe))

    def claims(self) -> Claims:
        return Claims(reciprocal=False, albedo_max=math.inf)

    def _coated(self, g: Geometry) -> Color:
        """The base and the coat on it."""
        weight, f0_coat, alpha_coat = self.coat_weight, f0_of_ior(self.coat_ior), self._coat_alpha()
        coat = _d_v(g, alpha_coat, alpha_coat) * f_dielectric_f0(f0_coat, g.cos_d)
        passed = dielectric_transmission(f0_coat, g.cos_o, alpha_coat)
        passed = passed * coat_absorption(self.coat_color, self.coat_ior, g)
        below = ((1 - weight) + weight * passed) * self._darkening(g.cos_o)
        return weight * coat + below * self._base(g)

    def _base(self, g: Geometry) -> Color:
        """The base without what lies above."""
        roughness, f0 = self._roughness(), self._base_f0()
        t = g if is_absent(self.specular_roughness_anisotropy) else turned(g, self.rotation)
        alpha_x, alpha_y = slopes(roughness, self.specular_roughness_anisotropy)
        d_v = _d_v(t, alpha_x, alpha_y)
        gloss = self.specular_color * f_dielectric_f0(f0, g.cos_d)
        rho = self.base_weight * self.base_color
        lost_i, lost_o = (single_scattering_loss(*w) for w in ((g.cos_i, g.sin2_i), (g.cos_o, g.sin2_o)))
        diffuse = energy_preserving(g, rho, self.base_diffuse_roughness, lost_i, lost_o)
        diffuse = dielectric_transmission(f0, g.cos_o, viewed_slope(t, alpha_x, alpha_y)) * diffuse
        metalness = self.base_metalness
        if is_absent(metalness):
            return diffuse + gloss * d_v
        metal = self._metal(g.cos_d, g.one_minus_cos_d)
        return (1 - metalness) * diffuse + ((1 - metalness) * gloss + metalness * metal) * d_v

    def _metal(self, cos_d: Scalar, one_minus_cos_d: Scalar) -> Color:
        f = f_schlick_f82(self.base_weight * self.base_color, self.specular_color, cos_d, one_minus_cos_d)
        return self.specular_weight * f

    def _roughness(self) -> Scalar:
        return coated_roughness(self.specular_roughness, self.coat_roughness, self.coat_weight)

    def _coat_alpha(self) -> Scalar:
        r = jnp.maximum(self.coat_roughness, _ROUGHNESS_MIN)
        return r * r

    def _base_f0(self) -> Scalar:
        return self.specular_weight * specular_f0(self.specular_ior, self.coat_ior, self.coat_weight)

    def _darkening(self, cos_o: Scalar) -> Color:
        """The factor on the base for the light that the coat throws back to it (OpenPBR 1.1, "Darkening")."""
        f0, metalness = self._base_f0(), self.base_metalness
        # What the base absorbs at normal incidence, 1 - E_b, as a sum of what cannot be negative.
        absorbed = 1 - self.base_weight * self.base_color
        absorbed_dielectric = f0 * (1 - self.specular_color) + (1 - f0) * absorbed
        absorbed_metal = (1 - self.specular_weight) + self.specular_weight * absorbed
        absorbed = (1 - metalness) * absorbed_dielectric + metalness * absorbed_metal
        # How rough the base is in all: its diffuse part fully, its highlights as far as they are.
        r = self.specular_roughness
        rough = (1 - metalness) * ((1 - f0) + f0 * r) + metalness * r
        # 1 - K of a smooth and of a rough base.
        leaves_smooth = t_dielectric_f0(f0_of_ior(self.coat_ior), cos_o)
        leaves_rough = (1 - mean_dielectric(self.coat_ior)) / (self.coat_ior * self.coat_ior)
        leaves = (1 - rough) * leaves_smooth + rough * leaves_rough
        # (1 - K) / (1 - E_b K) = (1 - K) / ((1 - E_b) K + (1 - K))
        delta = leaves / (absorbed * (1 - leaves) + leaves)
        strength = self.coat_weight * self.coat_darkening
        return (1 - strength) + strength * delta
