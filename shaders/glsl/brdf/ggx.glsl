// GGX (Trowbridge-Reitz) microfacets: f = D(theta_h) V(wi, wo) F(theta_d). The twin of this file is
// brdf/models/ggx.py, which holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "fresnel.glsl"
#include "masking.glsl"

vec3 ggx(ggx_params m, Geometry g) {
    float d = d_ggx(g, m.alpha);
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, g.sin2_i, m.alpha);
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, g.sin2_o, m.alpha);
    float v = m.masking == GGX_MASKING_SMITH ? v_smith(g, cos_lambda_i, cos_lambda_o)
                                             : v_smith_separable(g, cos_lambda_i, cos_lambda_o);
    vec3 f = f_schlick(m.f0, g.one_minus_cos_d);
    return d * v * f;
}
