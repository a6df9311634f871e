// Disney's principled model of 2012. The twin of this file is brdf/models/disney.py, which holds the formula.
//
// - Burley 2012, "Physically Based Shading at Disney", SIGGRAPH course notes, section 5, with the code of the BRDF
//   Explorer.

#include "common.glsl"
#include "diffuse.glsl"
#include "distributions.glsl"
#include "fresnel.glsl"
#include "masking.glsl"
#include "proposals.glsl"

const float DISNEY_ALPHA_MIN = 1e-3;
const float DISNEY_CLEARCOAT_F0 = 0.04;
const float DISNEY_CLEARCOAT_ALPHA_MASKING = 0.25;
// A base darker than this has no hue that float32 can divide out.
const float DISNEY_LUMINANCE_MIN = 1e-15;

// GGX slopes along and across the tangent.
vec2 disney_slopes(float roughness, float anisotropic) {
    float aspect = sqrt(1.0 - 0.9 * anisotropic);
    float alpha = roughness * roughness;
    return max(vec2(alpha / aspect, alpha * aspect), DISNEY_ALPHA_MIN);
}

// Slope of the clearcoat.
float disney_clearcoat_alpha(float clearcoat_gloss) {
    return 0.1 * (1.0 - clearcoat_gloss) + 0.001 * clearcoat_gloss;
}

// Hue and saturation of the base: its colour at luminance 1.
vec3 disney_tint(vec3 base_color) {
    float luminance = 0.3 * base_color.r + 0.6 * base_color.g + 0.1 * base_color.b;
    return luminance < DISNEY_LUMINANCE_MIN ? vec3(1.0) : base_color / luminance;
}

// Berry's density of normals in 1/sr, "GTR1", for alpha below 1 (Burley 2012, appendix B).
float disney_d_berry(Geometry g, float alpha) {
    float a2 = alpha * alpha;
    float q = (g.h_x * g.h_x + g.h_y * g.h_y + a2 * g.h_z2) / g.h2;
    return (1.0 - a2) / (-PI * log_accurate(a2) * q);
}

float disney_v_ggx(Geometry g, float alpha_x, float alpha_y) {
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha_x, alpha_y));
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha_x, alpha_y));
    return v_smith_separable(g, cos_lambda_i, cos_lambda_o);
}

vec3 disney_specular_f0(disney_params m, vec3 hue) {
    vec3 dielectric = 0.08 * m.specular * ((1.0 - m.specular_tint) + m.specular_tint * hue);
    return (1.0 - m.metallic) * dielectric + m.metallic * m.base_color;
}

vec3 disney(disney_params m, Geometry g) {
    vec3 hue = disney_tint(m.base_color);
    vec3 c_spec = disney_specular_f0(m, hue);
    float f_h = schlick_weight(g.one_minus_cos_d);

    float retro = retro_reflective(g, m.roughness);
    if (m.subsurface > 0.0) {
        retro = (1.0 - m.subsurface) * retro + m.subsurface * subsurface(g, m.roughness);
    }
    vec3 base = m.base_color / PI * retro;
    if (m.sheen > 0.0) {
        base = base + f_h * m.sheen * ((1.0 - m.sheen_tint) + m.sheen_tint * hue);
    }
    base = (1.0 - m.metallic) * base;

    Geometry t = g;
    if (m.anisotropic > 0.0) {
        t = turned(g, m.rotation);
    }
    vec2 alpha = disney_slopes(m.roughness, m.anisotropic);
    float d = d_ggx(t, alpha.x, alpha.y);
    float v;
    if (m.masking_remap == MASKING_REMAP_COURSE_NOTES) {
        float alpha_g = (0.5 + 0.5 * m.roughness) * (0.5 + 0.5 * m.roughness);
        v = disney_v_ggx(g, alpha_g, alpha_g);
    } else {
        v = disney_v_ggx(t, alpha.x, alpha.y);
    }
    vec3 specular = d * v * (c_spec + (1.0 - c_spec) * f_h);
    if (m.clearcoat == 0.0) {
        return base + specular;
    }

    float alpha_masking = DISNEY_CLEARCOAT_ALPHA_MASKING;
    float coat = disney_d_berry(g, disney_clearcoat_alpha(m.clearcoat_gloss));
    coat = coat * disney_v_ggx(g, alpha_masking, alpha_masking);
    return base + specular + 0.25 * m.clearcoat * coat * (DISNEY_CLEARCOAT_F0 + (1.0 - DISNEY_CLEARCOAT_F0) * f_h);
}

Proposals disney_proposals(disney_params m, float cos_o) {
    float one_minus_cos = 1.0 - cos_o;
    float specular = channel_mean(f_schlick(disney_specular_f0(m, disney_tint(m.base_color)), one_minus_cos));
    float f_coat = DISNEY_CLEARCOAT_F0 + (1.0 - DISNEY_CLEARCOAT_F0) * schlick_weight(one_minus_cos);
    float coat = 0.25 * m.clearcoat * f_coat;
    vec2 alpha = disney_slopes(m.roughness, m.anisotropic);
    float alpha_coat = disney_clearcoat_alpha(m.clearcoat_gloss);
    Proposals p = no_proposals();
    // Sheen reflects about a tenth; Berry's tail, heavier than that of GGX, is left to the cosine.
    p.diffuse = (1.0 - m.metallic) * (channel_mean(m.base_color) + 0.1 * m.sheen) + 0.5 * coat;
    p.specular[0] = SpecularLobe(specular, alpha.x, alpha.y, m.rotation);
    p.specular[1] = SpecularLobe(coat, alpha_coat, alpha_coat, 0.0);
    return p;
}
