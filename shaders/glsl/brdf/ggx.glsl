// GGX (Trowbridge-Reitz) microfacets: f = D(theta_h) V(wi, wo) F(theta_d).
// The twin of this file is brdf/models/ggx.py, which holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "microfacet.glsl"

vec3 ggx(ggx_params m, Geometry g) {
    Geometry local = g;
    if (IS_ANISOTROPIC(m)) {
        local = turned(g, m.rotation);
    }
    vec2 slopes = SLOPES(m);
    float d = d_ggx(local, slopes.x, slopes.y);
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(local.wi, slopes.x, slopes.y));
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(local.wo, slopes.x, slopes.y));
    float v = visibility(m.masking, g, cos_lambda_i, cos_lambda_o, MEAN_SLOPE(m));
    Fresnel fresnel = FRESNEL_OF(m);
    vec3 f = fresnel_reflectance(fresnel, g.cos_d, g.one_minus_cos_d);
    vec3 value = d * v * f;
    if (m.energy == ENERGY_MULTIPLE) {
        float alpha = MEAN_SLOPE(m);
        float loss_i = ggx_loss(reduced_cos(g.cos_i, alpha), alpha);
        float loss_o = ggx_loss(reduced_cos(g.cos_o, alpha), alpha);
        value += multiple_scattering(fresnel, loss_i, loss_o, ggx_mean_loss(alpha));
    }
    return value;
}

Proposals ggx_proposals(ggx_params m, float cos_o) {
    float alpha = MEAN_SLOPE(m);
    float loss_o = ggx_loss(reduced_cos(cos_o, alpha), alpha);
    float diffuse = m.energy == ENERGY_MULTIPLE ? cosine_share(loss_o, alpha) : 0.0;
    return mixture(FRESNEL_OF(m), SLOPES(m), ROTATION(m), diffuse, cos_o);
}
