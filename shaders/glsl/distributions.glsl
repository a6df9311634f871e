// Microfacet slope distributions: the density D of normals, and Lambda of Smith's masking times the cosine.
//
// - Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
// - Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
// - Burley 2012, "Physically-Based Shading at Disney", appendix B.
//
// The twin of this file is brdf/distributions.py.

#include "common.glsl"
#include "elementary.glsl"
#include "half_vector.glsl"

// erfc(9) = 4e-37: beyond it Lambda of Beckmann is zero in float32, and exp(-9^2) is still in its range.
const float BECKMANN_A_MAX = 9.0;
// Gauss-Legendre with 32 nodes in [0, 1]: the lower half of the nodes, and the weights of either half, which sum to 1.
const int ELLIPSE_HALF = 16;
const float ELLIPSE_NODE[ELLIPSE_HALF] = float[](
    0.001368069, 0.007194244, 0.017618872, 0.032546962, 0.051839422, 0.075316193, 0.102758102, 0.133908941,
    0.168477867, 0.206142121, 0.246550046, 0.289324362, 0.334065699, 0.380356319, 0.427764019, 0.475846167);
const float ELLIPSE_WEIGHT[ELLIPSE_HALF] = float[](
    0.007018610, 0.016274395, 0.025392065, 0.034273863, 0.042835898, 0.050998059, 0.058684093, 0.065822223,
    0.072345794, 0.078193896, 0.083311924, 0.087652093, 0.091173879, 0.093844399, 0.095638720, 0.096540089);

// (alpha_x x)^2 + (alpha_y y)^2: alpha^2 sin^2(theta) where the slopes are equal (Heitz 2014, eq. 80).
float alpha_sin2(vec3 w, float alpha_x, float alpha_y) {
    float x = alpha_x * w.x;
    float y = alpha_y * w.y;
    return x * x + y * y;
}

// GGX (Trowbridge-Reitz) density of normals in 1/sr (Walter 2007, eq. 33; anisotropic: Heitz 2014, eq. 85).
float d_ggx(Geometry g, float alpha_x, float alpha_y) {
    float area = alpha_x * alpha_y;
    float ratio = g.h2 / (g.h_x * g.h_x * (alpha_y / alpha_x) + g.h_y * g.h_y * (alpha_x / alpha_y) + area * g.h_z2);
    return (area / PI) * (ratio * ratio);
}

// cos(theta) Lambda(theta) of GGX (Heitz 2014, eq. 72).
float cos_lambda_ggx(float cos_theta, float alpha_sin2) {
    // sqrt(a) - b = (a - b^2) / (sqrt(a) + b), where the difference would cancel.
    return 0.5 * alpha_sin2 / (sqrt(cos_theta * cos_theta + alpha_sin2) + cos_theta);
}

// Beckmann density of normals in 1/sr (Walter 2007, eq. 25; anisotropic: Heitz 2014, eq. 83) as two factors: their
// product may lie below float32's range where the lobe, a large visibility times it, does not. The exponent is carried
// with its rounding error, which exp() would multiply by the exponent itself.
vec2 d_beckmann(Geometry g, float alpha_x, float alpha_y) {
    HalfSlopes t = half_slopes(g);
    vec2 t_x = divide_compensated(t.x, vec2(alpha_x, 0.0));
    vec2 t_y = divide_compensated(t.y, vec2(alpha_y, 0.0));
    vec2 decay = exp_halves(add_compensated(multiply_compensated(t_x, t_x), multiply_compensated(t_y, t_y)));
    float secant2 = g.h2 / (g.h_z * g.h_z);
    return vec2(decay.x * secant2 * secant2 / (PI * alpha_x * alpha_y), decay.y);
}

// cos(theta) Lambda(theta) of Beckmann, with the exact error function (Heitz 2014, eq. 68).
float cos_lambda_beckmann(float cos_theta, float alpha_sin2) {
    if (alpha_sin2 * (BECKMANN_A_MAX * BECKMANN_A_MAX) <= cos_theta * cos_theta) {
        return 0.0;
    }
    float alpha_sin = sqrt(alpha_sin2);
    // The limit was computed otherwise: rounding may put the quotient just above it.
    float a = min(cos_theta / alpha_sin, BECKMANN_A_MAX);
    // erfc(a) = exp(-a^2) erfcx(a)
    return 0.5 * exp_accurate(-a * a, 0.0) * (alpha_sin / sqrt(PI) - cos_theta * erfcx(a));
}

// Generalised Trowbridge-Reitz density of normals in 1/sr (Burley 2012, appendix B) as two factors, as d_beckmann.
vec2 d_gtr(Geometry g, float alpha_x, float alpha_y, float gamma, float norm) {
    float t_x = g.h_x / alpha_x;
    float t_y = g.h_y / alpha_y;
    // q - 1, which is small beside the normal, where the logarithm would lose it.
    float t2 = t_x * (g.h_x * (1.0 - alpha_x)) * (1.0 + alpha_x) / alpha_x
             + t_y * (g.h_y * (1.0 - alpha_y)) * (1.0 + alpha_y) / alpha_y;
    vec2 power = exp_halves(vec2(gamma * log1p_accurate(t2 / g.h2), 0.0));
    return vec2(power.x / (PI * alpha_x * alpha_y * norm), power.y);
}

// What d_gtr is divided by, beside the area of the ellipse of slopes, for equal slopes.
float gtr_norm(float alpha2, float gamma) {
    float spread = -log_accurate(alpha2);
    return mean_decay((gamma - 1.0) * spread) / mean_decay(spread);
}

// alpha^2 and the weight of the i-th node over the ellipse of slopes, see brdf/distributions.py: elliptic_mean.
vec2 ellipse_point(int i, float alpha_x, float alpha_y) {
    float low = min(alpha_x, alpha_y);
    float high = max(alpha_x, alpha_y);
    float ratio = low / high;
    float end = 0.5 * PI / ratio;
    float span = log_accurate(end + sqrt(end * end + 1.0));
    float node = ELLIPSE_NODE[i % ELLIPSE_HALF];
    float w = span * (i < ELLIPSE_HALF ? node : 1.0 - node);
    float growth = exp_accurate(w, 0.0);
    float decay = 1.0 / growth;
    // sinh(w) from its series where the exponentials cancel.
    float w2 = w * w;
    float sinh_w = w < 0.5 ? w * (1.0 + w2 / 6.0 * (1.0 + w2 / 20.0 * (1.0 + w2 / 42.0))) : 0.5 * (growth - decay);
    float anomaly = min(ratio * sinh_w, 0.5 * PI);
    float x = low * sin_compensated(0.5 * PI - anomaly).x;
    float y = high * sin_compensated(anomaly).x;
    return vec2(x * x + y * y, ELLIPSE_WEIGHT[i % ELLIPSE_HALF] * ratio * 0.5 * (growth + decay) * span / PI);
}

// The mean of gtr_norm over the ellipse of slopes.
float gtr_norm_elliptic(float alpha_x, float alpha_y, float gamma) {
    float total = 0.0;
    for (int i = 0; i < 2 * ELLIPSE_HALF; i++) {
        vec2 point = ellipse_point(i, alpha_x, alpha_y);
        total += point.y * gtr_norm(point.x, gamma);
    }
    return total;
}
