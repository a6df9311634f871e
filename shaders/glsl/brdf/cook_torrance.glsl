// Cook and Torrance's Beckmann microfacets in V-shaped grooves: f = D(theta_h) V(wi, wo) F(theta_d). The twin of this
// file is brdf/models/cook_torrance.py, which holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "fresnel.glsl"
#include "masking.glsl"
#include "proposals.glsl"

vec3 cook_torrance_fresnel(cook_torrance_params m, float cos_d, float one_minus_cos_d) {
    return m.fresnel == FRESNEL_SCHLICK ? f_schlick(m.f0, one_minus_cos_d)
                                                      : vec3(f_dielectric(m.ior, cos_d));
}

vec3 cook_torrance(cook_torrance_params m, Geometry g) {
    vec2 d = d_beckmann(g, m.alpha, m.alpha);
    vec3 f = cook_torrance_fresnel(m, g.cos_d, g.one_minus_cos_d);
    return (d.x * v_cavity(g) * f) * d.y;
}

Proposals cook_torrance_proposals(cook_torrance_params m, float cos_o) {
    float weight = channel_mean(cook_torrance_fresnel(m, cos_o, 1.0 - cos_o));
    Proposals p = no_proposals();
    p.specular[0] = SpecularLobe(weight, m.alpha, m.alpha, 0.0);
    return p;
}
