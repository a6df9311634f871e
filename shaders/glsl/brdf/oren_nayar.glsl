// Oren and Nayar's rough diffuse reflector, the full 1994 form with interreflection or the qualitative one without. The
// twin of this file is brdf/models/oren_nayar.py, which holds the formulas.
//
// - Oren, Nayar 1994, "Generalization of Lambert's Reflectance Model", section 4.4 and its qualitative model.
//
// Where both directions graze the surface, tan_beta and tan_mean are huge and their factors vanish: those are computed
// here as differences that float32 holds.

#include "common.glsl"
#include "compensated.glsl"
#include "elementary.glsl"
#include "proposals.glsl"

// Smallest product of squared sines at which an azimuth is computed: below it both of its terms round to zero.
const float OREN_NAYAR_SIN2_MIN = 1e-20;

// wi . wo in the tangent plane: where both directions graze the surface, a tangent multiplies the rounding of a plain
// dot product.
float oren_nayar_dot_xy(Geometry g) {
    return difference_of_products(g.wi.x, g.wo.x, -g.wi.y, g.wo.y);
}

vec3 oren_nayar_qualitative(oren_nayar_params m, Geometry g) {
    float sigma2 = m.sigma * m.sigma;
    float a = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    float b = 0.45 * sigma2 / (sigma2 + 0.09);
    // cos(dphi) sin(alpha) tan(beta)
    float rough = oren_nayar_dot_xy(g) / max(g.cos_i, g.cos_o);
    return m.albedo / PI * (a + b * max(rough, 0.0));
}

vec3 oren_nayar_full(oren_nayar_params m, Geometry g) {
    vec3 rho = m.albedo;
    float sigma2 = m.sigma * m.sigma;
    float c1 = 1.0 - 0.5 * sigma2 / (sigma2 + 0.33);
    float rough = 0.0;
    float azimuth = 0.0;
    if (g.sin2_i * g.sin2_o > OREN_NAYAR_SIN2_MIN) {
        float sin_i = sqrt(g.sin2_i);
        float sin_o = sqrt(g.sin2_o);
        float cos_dphi = clamp(oren_nayar_dot_xy(g) / (sin_i * sin_o), -1.0, 1.0);
        // 1 - |cos| = sin^2 / (1 + |cos|), with the sine from the cross product.
        float sin_dphi = difference_of_products(g.wi.x, g.wo.y, g.wi.y, g.wo.x) / (sin_i * sin_o);
        float one_minus_cos_dphi = sin_dphi * sin_dphi / (1.0 + abs(cos_dphi));

        float theta_i = atan_quadrant(sin_i, g.cos_i);
        float theta_o = atan_quadrant(sin_o, g.cos_o);
        float alpha = max(theta_i, theta_o);
        float beta = min(theta_i, theta_o);
        float sin_alpha = max(sin_i, sin_o);
        float sin_beta = min(sin_i, sin_o);
        float cos_alpha = min(g.cos_i, g.cos_o);
        float cos_beta = max(g.cos_i, g.cos_o);
        float tan_beta = sin_beta / cos_beta;
        float tan_mean = (sin_i + sin_o) / (g.cos_i + g.cos_o);
        float ratio_beta = 2.0 * beta / PI;
        // sin(alpha) - ratio^3 = (1 - ratio^3) - (1 - sin(alpha)), each of which vanishes at grazing angles.
        float one_minus_ratio = 2.0 * atan_quadrant(cos_beta, sin_beta) / PI;
        float one_minus_cube = one_minus_ratio * (1.0 + ratio_beta + ratio_beta * ratio_beta);
        float one_minus_sin_alpha = cos_alpha * cos_alpha / (1.0 + sin_alpha);

        float c2 = 0.45 * sigma2 / (sigma2 + 0.09);
        c2 = c2 * (cos_dphi < 0.0 ? one_minus_cube - one_minus_sin_alpha : sin_alpha);
        float ratio_product = 4.0 * alpha * beta / (PI * PI);
        float c3 = 0.125 * sigma2 / (sigma2 + 0.09) * ratio_product * ratio_product;
        rough = cos_dphi * c2 * tan_beta + one_minus_cos_dphi * c3 * tan_mean;
        azimuth = cos_dphi * ratio_beta * ratio_beta;
    }
    float bounce = 0.17 * sigma2 / (sigma2 + 0.13) * (1.0 - azimuth);
    float direct = c1 + rough;
    return rho / PI * max(direct + rho * bounce, 0.0);
}

vec3 oren_nayar(oren_nayar_params m, Geometry g) {
    return m.form == FORM_FULL ? oren_nayar_full(m, g) : oren_nayar_qualitative(m, g);
}

Proposals oren_nayar_proposals(oren_nayar_params m, float cos_o) {
    Proposals p = no_proposals();
    p.diffuse = channel_mean(m.albedo);
    return p;
}
