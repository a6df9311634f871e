// Phong's lobe about the mirror direction, normalised: f = specular (n + 2) / (2 pi) cos^n. The twin of this file is
// brdf/models/phong.py, which holds the references.

#include "common.glsl"
#include "cosine_power.glsl"
#include "proposals.glsl"

vec3 phong(phong_params m, Geometry g) {
    vec2 power = cos_mirror_power(g, m.exponent);
    return m.specular * ((m.exponent + 2.0) / (2.0 * PI) * power.x * power.y);
}

Proposals phong_proposals(phong_params m, float cos_o) {
    // In the plane of incidence cos^n is the half vector's cos^(4 n); across it, it is wider by 1 / cos_o.
    float alpha = sqrt(1.0 / (2.0 * m.exponent + 1.0)) / (sqrt(cos_o) * sqrt(sqrt(cos_o)));
    float weight = channel_mean(m.specular) * cos_o;
    Proposals p = no_proposals();
    p.specular[0] = SpecularLobe(weight, alpha, alpha, 0.0);
    return p;
}
