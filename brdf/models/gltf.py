"""glTF 2.0's metallic-roughness material with the extensions that opaque surfaces use: what most programs export.

    f = lerp(s f_base + f_sheen, f_coat, clearcoat (0.04 + 0.96 (1 - cos_o)^5))
    f_base = lerp((1 - specular max F) base_color / pi + specular F D V, F_metal D V, metallic)
    F = f0 + (1 - f0) (1 - cos_d)^5,  f0 = ((ior - 1) / (ior + 1))^2 specular_color,  F_metal likewise of base_color
    f_sheen = sheen_color D_c V_c,  s = 1 - max(sheen_color) max(E_c(cos_i), E_c(cos_o)),  f_coat = D V of the clearcoat
    alpha = roughness^2;  alpha_x = lerp(alpha, 1, anisotropy_strength^2) along the tangent, alpha_y = alpha across

D is GGX and V Smith's height-correlated masking; D_c, V_c and the fit E_c of the sheen are in `brdf/sheen.py`.
Textures, normal maps, transmission, volume, iridescence, dispersion and emission are not part of it; factors that the
extensions leave unbounded end at 1, the index of refraction at 3. A roughness below 0.01 acts as 0.01, that of the
sheen below 0.07 as 0.07.

The clearcoat's Fresnel term takes the viewer alone: with a clearcoat the model is not reciprocal. Nor does it keep the
energy: the diffuse base loses the Fresnel term at the half vector, not what the highlight reflects, which for white at
grazing angles is a tenth too little; and the sheen of a small roughness reflects there up to 2.9 times what it gets.

- Khronos Group 2021, "glTF 2.0 Specification", appendix B.
- Khronos Group, KHR_materials_specular, KHR_materials_ior, KHR_materials_clearcoat, KHR_materials_sheen,
  KHR_materials_anisotropy, as ratified.
"""

from __future__ import annotations

import math
from typing import ClassVar

import jax.numpy as jnp

from ..distributions import alpha_sin2, cos_lambda_ggx, d_ggx
from ..frame import Color, Geometry, Scalar, turned
from ..fresnel import f_schlick, schlick_weight
from ..layering import f0_of_ior
from ..masking import v_smith
from ..model import AbstractBRDF, Claims
from ..parameter import color, is_absent, rotation, scalar
from ..sampling import Proposals, SpecularLobe
from ..sheen import charlie_albedo, d_charlie, v_charlie

_ROUGHNESS_MIN = 0.01
_CLEARCOAT_F0 = 0.04
_ROUGHNESS_STARTS = (0.1, 0.3, 0.6, 1.0)


def alpha_of(roughness: Scalar) -> Scalar:
    """GGX slope of a roughness, at least 1e-4."""
    r = jnp.maximum(roughness, _ROUGHNESS_MIN)
    return r * r


def slopes(roughness: Scalar, anisotropy_strength: Scalar | float) -> tuple[Scalar, Scalar]:
    """GGX slopes along and across the direction of the anisotropy (KHR_materials_anisotropy)."""
    alpha, strength2 = alpha_of(roughness), anisotropy_strength * anisotropy_strength
    return (1 - strength2) * alpha + strength2, alpha


def _d_v(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha_x, alpha_y))
    cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha_x, alpha_y))
    return d_ggx(g, alpha_x, alpha_y) * v_smith(g, cos_lambda_i, cos_lambda_o)


def _clearcoat_fresnel(cos_o: Scalar) -> Scalar:
    return _CLEARCOAT_F0 + (1 - _CLEARCOAT_F0) * schlick_weight(1 - cos_o)


class GLTF(AbstractBRDF):
    """The material of glTF 2.0: metallic-roughness with specular, ior, clearcoat, sheen and anisotropy."""

    mixes_channels: ClassVar[bool] = True

    base_color: Color = color(0.0, 1.0, 1.0, "diffuse albedo of a dielectric, reflectance of a metal")
    metallic: Scalar = scalar(
        0.0,
        1.0,
        1.0,
        "from a dielectric with a diffuse base to a metal",
        held=(0.0, 1.0),
        because="trades off with base_color and specular_color",
    )
    roughness: Scalar = scalar(
        0.0, 1.0, 1.0, "perceptual roughness of the highlight: alpha = roughness^2", starts=_ROUGHNESS_STARTS
    )
    specular: Scalar = scalar(
        0.0,
        1.0,
        1.0,
        "strength of a dielectric's reflection",
        held=(1.0,),
        because="trades off exactly with specular_color",
    )
    specular_color: Color = color(0.0, 1.0, 1.0, "tint of a dielectric's reflectance at normal incidence")
    ior: Scalar = scalar(
        1.0,
        3.0,
        1.5,
        "index of refraction of a dielectric",
        starts=(1.2, 1.5, 2.0),
        held=(1.5,),
        because="trades off with specular_color but for grazing data",
    )
    clearcoat: Scalar = scalar(0.0, 1.0, 0.0, "strength of a clear layer of index 1.5 above all else", weight=True)
    clearcoat_roughness: Scalar = scalar(
        0.0, 1.0, 0.0, "perceptual roughness of the clear layer: alpha = roughness^2", starts=_ROUGHNESS_STARTS[:3]
    )
    sheen_color: Color = color(0.0, 1.0, 0.0, "colour of a lobe of cloth fibres above the base", weight=True)
    sheen_roughness: Scalar = scalar(
        0.0, 1.0, 0.0, "how far the fibres diverge from the normal", starts=_ROUGHNESS_STARTS[1:]
    )
    anisotropy_strength: Scalar = scalar(
        0.0,
        1.0,
        0.0,
        "how far the roughness along the tangent is raised towards 1",
        starts=(0.0, 0.5),
        weight=True,
        azimuthal=True,
    )
    anisotropy_rotation: Scalar = rotation("angle of the raised roughness from the tangent")

    def reflect(self, g: Geometry) -> Color:
        t = g if is_absent(self.anisotropy_strength) else turned(g, self.anisotropy_rotation)
        d_v = _d_v(t, *slopes(self.roughness, self.anisotropy_strength))
        f = self.specular * f_schlick(self._dielectric_f0(), g.one_minus_cos_d)
        diffuse = (1 - jnp.max(f)) * self.base_color / math.pi
        metal = f_schlick(self.base_color, g.one_minus_cos_d)
        base = (1 - self.metallic) * diffuse + ((1 - self.metallic) * f + self.metallic * metal) * d_v

        covered = base
        if not is_absent(self.sheen_color):
            fibres = self.sheen_color * (d_charlie(g, self.sheen_roughness) * v_charlie(g, self.sheen_roughness))
            covered = fibres + self._sheen_scale(g.cos_i, g.cos_o) * base
        if is_absent(self.clearcoat):
            return covered

        alpha = alpha_of(self.clearcoat_roughness)
        coat = self.clearcoat * _clearcoat_fresnel(g.cos_o) * _d_v(g, alpha, alpha)
        return self._clearcoat_passed(g.cos_o) * covered + coat

    def proposals(self, cos_o: Scalar) -> Proposals:
        cos_o = jnp.asarray(cos_o)
        coat, passed = self.clearcoat * _clearcoat_fresnel(cos_o), self._clearcoat_passed(cos_o)
        below = passed * self._sheen_scale(cos_o, cos_o)
        dielectric, metal = f_schlick(self._dielectric_f0(), 1 - cos_o), f_schlick(self.base_color, 1 - cos_o)
        specular = (1 - self.metallic) * self.specular * jnp.mean(dielectric) + self.metallic * jnp.mean(metal)
        # The cosine stands for the diffuse base and for the sheen, both broad.
        sheen = jnp.mean(self.sheen_color) * charlie_albedo(cos_o, self.sheen_roughness)
        diffuse = passed * sheen + below * (1 - self.metallic) * jnp.mean(self.base_color)
        alpha_x, alpha_y = slopes(self.roughness, self.anisotropy_strength)
        alpha = alpha_of(self.clearcoat_roughness)
        base_lobe = SpecularLobe(below * specular, alpha_x, alpha_y, self.anisotropy_rotation)
        if is_absent(self.clearcoat):
            return Proposals(diffuse, (base_lobe,))
        return Proposals(diffuse, (base_lobe, SpecularLobe(coat, alpha, alpha, 0 * coat)))

    def claims(self) -> Claims:
        return Claims(reciprocal=False, albedo_max=math.inf)

    def _dielectric_f0(self) -> Color:
        return f0_of_ior(self.ior) * self.specular_color

    def _sheen_scale(self, cos_i: Scalar, cos_o: Scalar) -> Scalar:
        """The share of light that passes the fibres (KHR_materials_sheen, "albedo-scaling technique")."""
        hidden_i, hidden_o = charlie_albedo(cos_i, self.sheen_roughness), charlie_albedo(cos_o, self.sheen_roughness)
        return 1 - jnp.max(self.sheen_color) * jnp.maximum(hidden_i, hidden_o)

    def _clearcoat_passed(self, cos_o: Scalar) -> Scalar:
        # 1 - clearcoat F with 1 - u^5 = (1 - u) (1 + u + u^2 + u^3 + u^4), which holds its digits at grazing angles.
        u = 1 - cos_o
        passed = (1 - _CLEARCOAT_F0) * cos_o * (1 + u * (1 + u * (1 + u * (1 + u))))
        return (1 - self.clearcoat) + self.clearcoat * passed
