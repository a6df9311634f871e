// glTF 2.0's metallic-roughness material with specular, ior, clearcoat, sheen and anisotropy. The twin of this file is
// brdf/models/gltf.py, which holds the formula.
//
// - Khronos Group 2021, "glTF 2.0 Specification", appendix B, and the extensions KHR_materials_* as ratified.

#include "common.glsl"
#include "distributions.glsl"
#include "fresnel.glsl"
#include "layering.glsl"
#include "masking.glsl"
#include "proposals.glsl"
#include "sheen.glsl"

const float GLTF_ROUGHNESS_MIN = 0.01;
const float GLTF_CLEARCOAT_F0 = 0.04;

// GGX slope of a roughness, at least 1e-4.
float gltf_alpha_of(float roughness) {
    float r = max(roughness, GLTF_ROUGHNESS_MIN);
    return r * r;
}

// GGX slopes along and across the direction of the anisotropy (KHR_materials_anisotropy).
vec2 gltf_slopes(float roughness, float anisotropy_strength) {
    float alpha = gltf_alpha_of(roughness);
    float strength2 = anisotropy_strength * anisotropy_strength;
    return vec2((1.0 - strength2) * alpha + strength2, alpha);
}

float gltf_d_v(Geometry g, vec2 alpha) {
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha.x, alpha.y));
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha.x, alpha.y));
    return d_ggx(g, alpha.x, alpha.y) * v_smith(g, cos_lambda_i, cos_lambda_o);
}

float gltf_max(vec3 color) {
    return max(color.r, max(color.g, color.b));
}

vec3 gltf_dielectric_f0(gltf_params m) {
    return f0_of_ior(m.ior) * m.specular_color;
}

// The share of light that passes the fibres (KHR_materials_sheen, "albedo-scaling technique").
float gltf_sheen_scale(gltf_params m, float cos_i, float cos_o) {
    float hidden_i = charlie_albedo(cos_i, m.sheen_roughness);
    float hidden_o = charlie_albedo(cos_o, m.sheen_roughness);
    return 1.0 - gltf_max(m.sheen_color) * max(hidden_i, hidden_o);
}

float gltf_clearcoat_fresnel(float cos_o) {
    return GLTF_CLEARCOAT_F0 + (1.0 - GLTF_CLEARCOAT_F0) * schlick_weight(1.0 - cos_o);
}

float gltf_clearcoat_passed(gltf_params m, float cos_o) {
    // 1 - clearcoat F with 1 - u^5 = (1 - u) (1 + u + u^2 + u^3 + u^4), which holds its digits at grazing angles.
    float u = 1.0 - cos_o;
    float passed = (1.0 - GLTF_CLEARCOAT_F0) * cos_o * (1.0 + u * (1.0 + u * (1.0 + u * (1.0 + u))));
    return (1.0 - m.clearcoat) + m.clearcoat * passed;
}

vec3 gltf(gltf_params m, Geometry g) {
    Geometry t = g;
    if (m.anisotropy_strength > 0.0) {
        t = turned(g, m.anisotropy_rotation);
    }
    float d_v = gltf_d_v(t, gltf_slopes(m.roughness, m.anisotropy_strength));
    vec3 f = m.specular * f_schlick(gltf_dielectric_f0(m), g.one_minus_cos_d);
    vec3 diffuse = (1.0 - gltf_max(f)) * m.base_color / PI;
    vec3 metal = f_schlick(m.base_color, g.one_minus_cos_d);
    vec3 base = (1.0 - m.metallic) * diffuse + ((1.0 - m.metallic) * f + m.metallic * metal) * d_v;

    vec3 covered = base;
    if (gltf_max(m.sheen_color) > 0.0) {
        vec2 d = d_charlie(g, m.sheen_roughness);
        vec3 fibres = m.sheen_color * (d.x * v_charlie(g, m.sheen_roughness)) * d.y;
        covered = fibres + gltf_sheen_scale(m, g.cos_i, g.cos_o) * base;
    }
    if (m.clearcoat == 0.0) {
        return covered;
    }

    float alpha = gltf_alpha_of(m.clearcoat_roughness);
    float coat = m.clearcoat * gltf_clearcoat_fresnel(g.cos_o) * gltf_d_v(g, vec2(alpha));
    return gltf_clearcoat_passed(m, g.cos_o) * covered + coat;
}

Proposals gltf_proposals(gltf_params m, float cos_o) {
    float coat = m.clearcoat * gltf_clearcoat_fresnel(cos_o);
    float passed = gltf_clearcoat_passed(m, cos_o);
    float below = passed * gltf_sheen_scale(m, cos_o, cos_o);
    vec3 dielectric = f_schlick(gltf_dielectric_f0(m), 1.0 - cos_o);
    vec3 metal = f_schlick(m.base_color, 1.0 - cos_o);
    float specular = (1.0 - m.metallic) * m.specular * channel_mean(dielectric) + m.metallic * channel_mean(metal);
    // The cosine stands for the diffuse base and for the sheen, both broad.
    float sheen = channel_mean(m.sheen_color) * charlie_albedo(cos_o, m.sheen_roughness);
    vec2 alpha = gltf_slopes(m.roughness, m.anisotropy_strength);
    float alpha_coat = gltf_alpha_of(m.clearcoat_roughness);
    Proposals p = no_proposals();
    p.diffuse = passed * sheen + below * (1.0 - m.metallic) * channel_mean(m.base_color);
    p.specular[0] = SpecularLobe(below * specular, alpha.x, alpha.y, m.anisotropy_rotation);
    p.specular[1] = SpecularLobe(coat, alpha_coat, alpha_coat, 0.0);
    return p;
}
