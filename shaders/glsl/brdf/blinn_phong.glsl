// Blinn's variant of Phong: f = specular D(theta_h) / |wi + wo|^2, or in its classic form f = specular cos^n(theta_h).
// The twin of this file is brdf/models/blinn_phong.py, which holds the references.

#include "common.glsl"
#include "cosine_power.glsl"
#include "masking.glsl"
#include "proposals.glsl"

vec3 blinn_phong(blinn_phong_params m, Geometry g) {
    vec2 power = cos_h_power(g, m.exponent);
    if (m.form == FORM_CLASSIC) {
        return m.specular * (power.x * power.y);
    }
    float d = (m.exponent + 2.0) / (2.0 * PI) * power.x;
    return m.specular * (d * v_kelemen(g) * power.y);
}

Proposals blinn_phong_proposals(blinn_phong_params m, float cos_o) {
    float alpha = slope_of_exponent(m.exponent);
    float weight = channel_mean(m.specular);
    if (m.form == FORM_CLASSIC) {
        weight = weight * 8.0 * PI / (m.exponent + 8.0) * cos_o;
    }
    Proposals p = no_proposals();
    p.specular[0] = SpecularLobe(weight, alpha, alpha, 0.0);
    return p;
}
