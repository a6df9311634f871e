// Generalised Trowbridge-Reitz microfacets: f = D(theta_h) V(wi, wo) F(theta_d).
// The twin of this file is brdf/models/gtr.py, which holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "microfacet.glsl"

vec3 gtr(gtr_params m, Geometry g) {
    Geometry local = g;
    if (IS_ANISOTROPIC(m)) {
        local = turned(g, m.rotation);
    }
    vec2 slopes = SLOPES(m);
    float norm = IS_ANISOTROPIC(m) ? gtr_norm_elliptic(slopes.x, slopes.y, m.gamma)
                                   : gtr_norm(slopes.x * slopes.y, m.gamma);
    vec2 d = d_gtr(local, slopes.x, slopes.y, m.gamma, norm);
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(local.wi, slopes.x, slopes.y));
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(local.wo, slopes.x, slopes.y));
    float v = visibility(m.masking, g, cos_lambda_i, cos_lambda_o, MEAN_SLOPE(m));
    Fresnel fresnel = FRESNEL_OF(m);
    vec3 f = fresnel_reflectance(fresnel, g.cos_d, g.one_minus_cos_d);
    return (d.x * v * f) * d.y;
}

Proposals gtr_proposals(gtr_params m, float cos_o) {
    return mixture(FRESNEL_OF(m), SLOPES(m), ROTATION(m), max(2.0 - m.gamma, 0.0), cos_o);
}
