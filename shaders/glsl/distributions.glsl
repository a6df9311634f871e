// Microfacet slope distributions: the density D of normals, and Lambda of Smith's masking times the cosine.
//
// - Burley 2012, "Physically-Based Shading at Disney", appendix B.
//
// - Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
// - Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
//
// The twin of this file is brdf/distributions.py.

#include "common.glsl"
#include "elementary.glsl"
#include "half_vector.glsl"

// erfc(9) = 4e-37: beyond it Lambda of Beckmann is zero in float32, and exp(-9^2) is still in its range.
const float BECKMANN_A_MAX = 9.0;
// The midpoint rule converges geometrically for a smooth function over an ellipse.
const int ELLIPSE_NODES = 16;

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

// The i-th node of the midpoint rule over a quarter of the unit circle.
vec2 ellipse_point(int i) {
    float angle = (float(i) + 0.5) * (0.5 * PI / float(ELLIPSE_NODES));
    return vec2(sin_compensated(0.5 * PI - angle).x, sin_compensated(angle).x);
}

// The mean of gtr_norm over the ellipse of slopes, by the midpoint rule in its eccentric anomaly.
float gtr_norm_elliptic(float alpha_x, float alpha_y, float gamma) {
    float total = 0.0;
    for (int i = 0; i < ELLIPSE_NODES; i++) {
        vec2 axis = ellipse_point(i);
        float x = axis.x * alpha_x;
        float y = axis.y * alpha_y;
        total += gtr_norm(x * x + y * y, gamma);
    }
    return total / float(ELLIPSE_NODES);
}
