// Beckmann microfacets: f = D(theta_h) V(wi, wo) F(theta_d). The twin of this file is brdf/models/beckmann.py, which
// holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "fresnel.glsl"
#include "masking.glsl"

vec3 beckmann(beckmann_params m, Geometry g) {
    vec2 d = d_beckmann(g, m.alpha);
    float cos_lambda_i = cos_lambda_beckmann(g.cos_i, g.sin2_i, m.alpha);
    float cos_lambda_o = cos_lambda_beckmann(g.cos_o, g.sin2_o, m.alpha);
    float v = m.masking == BECKMANN_MASKING_SMITH ? v_smith(g, cos_lambda_i, cos_lambda_o)
                                                  : v_smith_separable(g, cos_lambda_i, cos_lambda_o);
    vec3 f = f_schlick(m.f0, g.one_minus_cos_d);
    return (d.x * v * f) * d.y;
}
