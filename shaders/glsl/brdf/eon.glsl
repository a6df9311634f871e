// EON, the energy-preserving Oren-Nayar model. The twin of this file is brdf/models/eon.py, which holds the formula.
//
// - Portsmouth, Kutz, Hill 2025, "EON: A Practical Energy-Preserving Rough Diffuse BRDF", JCGT 14(1), listing 1.
// - Fujii 2013, "A tiny improvement of Oren-Nayar reflectance model".

#include "common.glsl"
#include "diffuse.glsl"
#include "proposals.glsl"

// c1 - G / pi by the published polynomial of G / pi in 1 - cos, which is off by up to 6.1e-4 and exceeds c1 at the
// horizon, where the difference is cut.
float eon_lost_polynomial(float cos_theta) {
    // In powers of the cosine instead, which hold the digits where the difference crosses zero.
    float c = cos_theta;
    float difference = -0.000458539989 + c * (0.330099918 + c * (0.0760044872 + c * (-0.0464094608 + c * -0.0714429953)));
    return max(difference, 0.0);
}

vec3 eon(eon_params m, Geometry g) {
    bool exact = m.albedo_form == ALBEDO_FORM_EXACT;
    float lost_i = exact ? single_scattering_loss(g.cos_i, g.sin2_i) : eon_lost_polynomial(g.cos_i);
    float lost_o = exact ? single_scattering_loss(g.cos_o, g.sin2_o) : eon_lost_polynomial(g.cos_o);
    return energy_preserving(g, m.albedo, m.roughness, lost_i, lost_o);
}

Proposals eon_proposals(eon_params m, float cos_o) {
    Proposals p = no_proposals();
    p.diffuse = channel_mean(m.albedo);
    return p;
}
