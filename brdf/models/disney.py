"""Disney's "principled" model of 2012, with all eleven parameters: few, intuitive, right for most measured materials.

    f = (1 - metallic) ((base_color / pi) lerp(F_d, ss, subsurface) + F_H sheen C_sheen)
        + D_2 V (C_spec + (1 - C_spec) F_H) + clearcoat / 4 D_1 V_1/4 (0.04 + 0.96 F_H)
    F_H = (1 - cos_d)^5;  C_tint = base_color / (0.3 R + 0.6 G + 0.1 B), white for a black base
    C_spec = lerp(0.08 specular lerp(1, C_tint, specular_tint), base_color, metallic)
    C_sheen = lerp(1, C_tint, sheen_tint)
    aspect = sqrt(1 - 0.9 anisotropic);  alpha_x, alpha_y = max(0.001, roughness^2 / aspect), max(0.001, ... * aspect)

D_2 is GGX and D_1 Berry's distribution, with slopes from 0.1 (clearcoat_gloss = 0) to 0.001; V is Smith's separable
masking of GGX, for the clearcoat with a slope of 0.25. F_d and ss are in `brdf/diffuse.py`. It is reciprocal. It does
not keep the energy: with a white base, sheen or a rough diffuse term reflects more than it gets. The shader's base
colour is gamma encoded; here it is linear. The quotient C_tint is not bounded: 0.3 R + 0.6 G + 0.1 B may be a tenth of
the blue channel, so a tinted lobe may pass 1; and it jumps to white at black.

- Burley 2012, "Physically Based Shading at Disney", SIGGRAPH course notes, section 5, with the code of the BRDF
  Explorer (disney.brdf), whose masking is `masking_remap = shader`.
"""

from __future__ import annotations

import math
from typing import ClassVar

import jax.numpy as jnp

from ..diffuse import retro_reflective, subsurface
from ..distributions import alpha_sin2, cos_lambda_ggx, d_ggx
from ..frame import Color, Geometry, Scalar, turned
from ..fresnel import f_schlick, schlick_weight
from ..masking import v_smith_separable
from ..model import AbstractBRDF, Claims
from ..parameter import choice, color, is_absent, rotation, scalar
from ..sampling import Proposals, SpecularLobe

_ALPHA_MIN = 1e-3
_CLEARCOAT_F0, _CLEARCOAT_ALPHA_MASKING = 0.04, 0.25
# A base darker than this has no hue that float32 can divide out.
_LUMINANCE_MIN = 1e-15


def slopes(roughness: Scalar, anisotropic: Scalar | float) -> tuple[Scalar, Scalar]:
    """GGX slopes along and across the tangent."""
    aspect = jnp.sqrt(1 - 0.9 * anisotropic)
    alpha = roughness * roughness
    return jnp.maximum(alpha / aspect, _ALPHA_MIN), jnp.maximum(alpha * aspect, _ALPHA_MIN)


def clearcoat_alpha(clearcoat_gloss: Scalar) -> Scalar:
    """Slope of the clearcoat."""
    return jnp.add(0.1 * (1 - clearcoat_gloss), 0.001 * clearcoat_gloss)


def tint(base_color: Color) -> Color:
    """Hue and saturation of the base: its colour at luminance 1."""
    luminance = 0.3 * base_color[0] + 0.6 * base_color[1] + 0.1 * base_color[2]
    is_black = luminance < _LUMINANCE_MIN
    return jnp.where(is_black, jnp.ones_like(base_color), base_color / jnp.where(is_black, 1.0, luminance))


def d_berry(g: Geometry, alpha: Scalar) -> Scalar:
    """Berry's density of normals in 1/sr, "GTR1", for alpha below 1 (Burley 2012, appendix B)."""
    a2 = alpha * alpha
    q = (g.m_x * g.m_x + g.m_y * g.m_y + a2 * g.m_z2) / g.m2
    return (1 - a2) / (-math.pi * jnp.log(a2) * q)


def _v_ggx(g: Geometry, alpha_x: Scalar, alpha_y: Scalar) -> Scalar:
    cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha_x, alpha_y))
    cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha_x, alpha_y))
    return v_smith_separable(g, cos_lambda_i, cos_lambda_o)


class Disney(AbstractBRDF):
    """The principled model of Disney 2012: diffuse and metallic base, sheen, clearcoat."""

    mixes_channels: ClassVar[bool] = True

    base_color: Color = color(0.0, 1.0, 0.5, "colour of the surface, linear: diffuse albedo, or reflectance of a metal")
    subsurface: Scalar = scalar(
        0.0, 1.0, 0.0, "how far the diffuse term is flattened as by scattering inside", weight=True
    )
    metallic: Scalar = scalar(
        0.0,
        1.0,
        0.0,
        "from a dielectric with a diffuse base to a metal without",
        held=(0.0, 1.0),
        because="trades off exactly with base_color, specular and specular_tint on isotropic data",
    )
    specular: Scalar = scalar(0.0, 1.0, 0.5, "reflectance of the dielectric at normal incidence, in units of 0.08")
    specular_tint: Scalar = scalar(0.0, 1.0, 0.0, "how far that reflectance takes the hue of the base")
    roughness: Scalar = scalar(
        0.0, 1.0, 0.5, "perceptual roughness of diffuse and specular terms: alpha = roughness^2", starts=(0.1, 0.3, 0.6)
    )
    anisotropic: Scalar = scalar(
        0.0,
        1.0,
        0.0,
        "elongation of the highlight along the tangent; its aspect at 1 is 10",
        weight=True,
        azimuthal=True,
    )
    rotation: Scalar = rotation()
    sheen: Scalar = scalar(0.0, 1.0, 0.0, "strength of an additional lobe at grazing angles, for cloth", weight=True)
    sheen_tint: Scalar = scalar(0.0, 1.0, 0.5, "how far the sheen takes the hue of the base")
    clearcoat: Scalar = scalar(0.0, 1.0, 0.0, "strength of a second specular lobe, of index 1.5", weight=True)
    clearcoat_gloss: Scalar = scalar(0.0, 1.0, 1.0, "sharpness of the clearcoat: slope 0.1 at 0, 0.001 at 1")
    masking_remap: str = choice(
        "shader", "course_notes", doc="slope of the masking: alpha as it is, or (0.5 + roughness / 2)^2 of 2012"
    )

    def reflect(self, g: Geometry) -> Color:
        hue = tint(self.base_color)
        c_spec = self._specular_f0(hue)
        f_h = schlick_weight(g.one_minus_cos_d)

        retro = retro_reflective(g, self.roughness)
        if not is_absent(self.subsurface):
            retro = (1 - self.subsurface) * retro + self.subsurface * subsurface(g, self.roughness)
        base = self.base_color / math.pi * retro
        if not is_absent(self.sheen):
            base = base + f_h * self.sheen * ((1 - self.sheen_tint) + self.sheen_tint * hue)
        base = (1 - self.metallic) * base

        t = g if is_absent(self.anisotropic) else turned(g, self.rotation)
        alpha_x, alpha_y = slopes(self.roughness, self.anisotropic)
        d = d_ggx(t, alpha_x, alpha_y)
        if self.masking_remap == "course_notes":
            alpha_g = (0.5 + 0.5 * self.roughness) ** 2
            v = _v_ggx(g, alpha_g, alpha_g)
        else:
            v = _v_ggx(t, alpha_x, alpha_y)
        specular = d * v * (c_spec + (1 - c_spec) * f_h)
        if is_absent(self.clearcoat):
            return base + specular

        alpha_masking = _CLEARCOAT_ALPHA_MASKING * jnp.ones_like(v)
        coat = d_berry(g, clearcoat_alpha(self.clearcoat_gloss)) * _v_ggx(g, alpha_masking, alpha_masking)
        return base + specular + 0.25 * self.clearcoat * coat * (_CLEARCOAT_F0 + (1 - _CLEARCOAT_F0) * f_h)

    def proposals(self, cos_o: Scalar) -> Proposals:
        one_minus_cos = 1 - jnp.asarray(cos_o)
        specular = jnp.mean(f_schlick(self._specular_f0(tint(self.base_color)), one_minus_cos))
        f_coat = _CLEARCOAT_F0 + (1 - _CLEARCOAT_F0) * schlick_weight(one_minus_cos)
        coat = 0.25 * self.clearcoat * f_coat
        # Sheen reflects about a tenth; Berry's tail, heavier than that of GGX, is left to the cosine.
        diffuse = (1 - self.metallic) * (jnp.mean(self.base_color) + 0.1 * self.sheen) + 0.5 * coat
        alpha_x, alpha_y = slopes(self.roughness, self.anisotropic)
        alpha = clearcoat_alpha(self.clearcoat_gloss)
        base_lobe = SpecularLobe(specular, alpha_x, alpha_y, self.rotation)
        if is_absent(self.clearcoat):
            return Proposals(diffuse, (base_lobe,))
        return Proposals(diffuse, (base_lobe, SpecularLobe(coat, alpha, alpha, 0 * coat)))

    def claims(self) -> Claims:
        return Claims(reciprocal=True, albedo_max=math.inf)

    def _specular_f0(self, hue: Color) -> Color:
        dielectric = 0.08 * self.specular * ((1 - self.specular_tint) + self.specular_tint * hue)
        return (1 - self.metallic) * dielectric + self.metallic * self.base_color
