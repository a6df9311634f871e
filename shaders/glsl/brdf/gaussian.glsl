// Gaussian microfacets: f = D(theta_h) V(wi, wo) F(theta_d).
// The twin of this file is brdf/models/gaussian.py, which holds the references.

#include "common.glsl"
#include "distributions.glsl"
#include "gaussian.glsl"
#include "microfacet.glsl"

vec3 gaussian(gaussian_params m, Geometry g) {
    Geometry local = g;
    if (IS_ANISOTROPIC(m)) {
        local = turned(g, m.rotation);
    }
    vec2 slopes = SLOPES(m);
    float norm = IS_ANISOTROPIC(m) ? gaussian_norm_elliptic(slopes.x, slopes.y) : gaussian_norm(slopes.x * slopes.y);
    vec2 d = d_gaussian(local, slopes.x, slopes.y, norm);
    float alpha_i = m.alpha;
    float alpha_o = m.alpha;
    if (IS_ANISOTROPIC(m)) {
        alpha_i = seen_slope(g.cos_i, alpha_sin2(local.wi, slopes.x, slopes.y));
        alpha_o = seen_slope(g.cos_o, alpha_sin2(local.wo, slopes.x, slopes.y));
    }
    float cos_lambda_i = cos_lambda_gaussian(g.cos_i, alpha_i);
    float cos_lambda_o = cos_lambda_gaussian(g.cos_o, alpha_o);
    float v = visibility(m.masking, g, cos_lambda_i, cos_lambda_o, MEAN_SLOPE(m));
    Fresnel fresnel = FRESNEL_OF(m);
    vec3 f = fresnel_reflectance(fresnel, g.cos_d, g.one_minus_cos_d);
    vec3 value = (d.x * v * f) * d.y;
    if (m.energy == ENERGY_MULTIPLE) {
        float alpha = MEAN_SLOPE(m);
        float loss_i = gaussian_loss(reduced_cos(g.cos_i, alpha), alpha);
        float loss_o = gaussian_loss(reduced_cos(g.cos_o, alpha), alpha);
        value += multiple_scattering(fresnel, loss_i, loss_o, gaussian_mean_loss(alpha));
    }
    return value;
}

Proposals gaussian_proposals(gaussian_params m, float cos_o) {
    float alpha = MEAN_SLOPE(m);
    float loss_o = gaussian_loss(reduced_cos(cos_o, alpha), alpha);
    float diffuse = m.energy == ENERGY_MULTIPLE ? cosine_share(loss_o, alpha) : 0.0;
    return mixture(FRESNEL_OF(m), SLOPES(m), ROTATION(m), diffuse, cos_o);
}
