// Ashikhmin and Shirley's anisotropic Phong model. The twin of this file is brdf/models/ashikhmin_shirley.py, which
// holds the formulas and the references.

#include "common.glsl"
#include "cosine_power.glsl"
#include "fresnel.glsl"
#include "proposals.glsl"

// 1 - (1 - cos / 2)^5, multiplied out: at grazing angles the difference would cancel.
float ashikhmin_shirley_passage(float cos_theta) {
    float x = 0.5 * cos_theta;
    return x * (5.0 + x * (-10.0 + x * (10.0 + x * (-5.0 + x))));
}

vec3 ashikhmin_shirley(ashikhmin_shirley_params m, Geometry g) {
    vec2 power;
    float peak;
    if (m.anisotropy == ANISOTROPY_ISOTROPIC) {
        power = cos_h_power(g, m.exponent);
        peak = (m.exponent + 1.0) / (8.0 * PI);
    } else {
        power = cos_h_power_anisotropic(g, m.exponent_x, m.exponent_y, m.rotation);
        peak = sqrt(m.exponent_x + 1.0) * sqrt(m.exponent_y + 1.0) / (8.0 * PI);
    }
    float d = peak * power.x / g.cos_d / max(g.cos_i, g.cos_o) * power.y;
    vec3 value = f_schlick(m.f0, g.one_minus_cos_d) * d;
    if (m.diffuse == DIFFUSE_NONE) {
        return value;
    }
    float body = 28.0 / (23.0 * PI) * ashikhmin_shirley_passage(g.cos_i) * ashikhmin_shirley_passage(g.cos_o);
    return value + m.albedo * (1.0 - m.f0) * body;
}

Proposals ashikhmin_shirley_proposals(ashikhmin_shirley_params m, float cos_o) {
    bool isotropic = m.anisotropy == ANISOTROPY_ISOTROPIC;
    float alpha_x = slope_of_exponent(isotropic ? m.exponent : m.exponent_x);
    float alpha_y = slope_of_exponent(isotropic ? m.exponent : m.exponent_y);
    float weight = channel_mean(f_schlick(m.f0, 1.0 - cos_o));
    Proposals p = no_proposals();
    p.specular[0] = SpecularLobe(weight, alpha_x, alpha_y, isotropic ? 0.0 : m.rotation);
    if (m.diffuse == DIFFUSE_COUPLED) {
        p.diffuse = channel_mean(m.albedo * (1.0 - m.f0)) * ashikhmin_shirley_passage(cos_o);
    }
    return p;
}
