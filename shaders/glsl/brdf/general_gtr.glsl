// GTR facets whose highlight widens with the angle of incidence and whose reflectance rises as a free power. The twin of
// this file is brdf/models/general_gtr.py, which holds the formulas and the references.

#include "common.glsl"
#include "distributions.glsl"
#include "elementary.glsl"
#include "half_vector.glsl"
#include "masking.glsl"
#include "proposals.glsl"

// What widens or narrows the highlight stops at 89.4 degrees: its height, times the visibility, would leave float32.
const float GENERAL_GTR_COS_D_MIN = 1e-2;
// No highlight gets narrower than that of the smallest slope, at any angle: its derivatives would leave float32 too.
const float GENERAL_GTR_INVERSE_MAX = 1e8;
// 1 - cos(theta_d) below which the rise of the reflectance is zero, to the precision of its smallest power.
const float GENERAL_GTR_VERSINE_MIN = 1e-18;

// 1 / alpha_d^2 - 1, the inverse square of the width at this angle.
float general_gtr_inverse(general_gtr_params m, float cos_d) {
    float at_normal = (1.0 - m.alpha) * (1.0 + m.alpha) / m.alpha / m.alpha;
    float widening = exp_accurate(2.0 * m.spread * log_accurate(max(cos_d, GENERAL_GTR_COS_D_MIN)), 0.0);
    return min(at_normal * widening, GENERAL_GTR_INVERSE_MAX);
}

vec3 general_gtr_fresnel(general_gtr_params m, float cos_d, float one_minus_cos_d) {
    // -log of the rise: from the cosine where the rise is near 1, so that 1 - rise keeps its digits.
    float versine = max(one_minus_cos_d, GENERAL_GTR_VERSINE_MIN);
    float exponent = m.falloff * log1p_accurate(cos_d / versine);
    float rise = exp_accurate(-min(exponent, 87.0), 0.0);
    return m.f0 * (exponent * mean_decay(exponent)) + m.f90 * rise;
}

vec3 general_gtr(general_gtr_params m, Geometry g) {
    float b = general_gtr_inverse(m, g.cos_d);
    float sin2_h = (g.h_x * g.h_x + g.h_y * g.h_y) / g.h2;
    // As two factors: their product may lie below float32's range where the lobe does not.
    vec2 decay = exp_halves(vec2(m.gamma * log1p_accurate(b * sin2_h), 0.0));
    float d = decay.x * (1.0 + b) / (PI * gtr_norm(1.0 / (1.0 + b), m.gamma));
    return (d * v_cavity(g) * general_gtr_fresnel(m, g.cos_d, g.one_minus_cos_d)) * decay.y;
}

Proposals general_gtr_proposals(general_gtr_params m, float cos_o) {
    float weight = channel_mean(general_gtr_fresnel(m, cos_o, 1.0 - cos_o));
    float alpha = 1.0 / sqrt(1.0 + general_gtr_inverse(m, cos_o));
    Proposals p = no_proposals();
    p.diffuse = (0.1 + max(2.0 - m.gamma, 0.0)) * weight;
    p.specular[0] = SpecularLobe(weight, alpha, alpha, 0.0);
    return p;
}
