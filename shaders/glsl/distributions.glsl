// Microfacet slope distributions: the density D of normals, and Lambda of Smith's masking times the cosine.
//
// - Walter, Marschner, Li, Torrance 2007, "Microfacet Models for Refraction through Rough Surfaces".
// - Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
//
// The twin of this file is brdf/distributions.py.

#include "common.glsl"
#include "compensated.glsl"
#include "elementary.glsl"

// exp(-170) = 1e-74 is zero in float32, times anything that a lobe multiplies it with.
const float EXPONENT_MAX = 170.0;
// erfc(9) = 4e-37: beyond it Lambda of Beckmann is zero in float32, and exp(-9^2) is still in its range.
const float BECKMANN_A_MAX = 9.0;

// GGX (Trowbridge-Reitz) density of normals in 1/sr (Walter 2007, eq. 33).
float d_ggx(Geometry g, float alpha) {
    float t_x = g.h_x / alpha;
    float t_y = g.h_y / alpha;
    float ratio = g.h2 / (t_x * t_x + t_y * t_y + g.h_z * g.h_z) / alpha;
    return ratio * ratio / PI;
}

// cos(theta) Lambda(theta) of GGX (Heitz 2014, eq. 72).
float cos_lambda_ggx(float cos_theta, float sin2_theta, float alpha) {
    return 0.5 * (sqrt(cos_theta * cos_theta + alpha * alpha * sin2_theta) - cos_theta);
}

// Beckmann density of normals in 1/sr (Walter 2007, eq. 25) as two factors: their product may lie below float32's
// range where the lobe, a large visibility times it, does not. The exponent is carried with its rounding error, which
// exp() would multiply by the exponent itself.
vec2 d_beckmann(Geometry g, float alpha) {
    vec2 h_x = two_sum(g.wi.x, g.wo.x);
    vec2 h_y = two_sum(g.wi.y, g.wo.y);
    vec2 h_z = two_sum(g.wi.z, g.wo.z);
    vec2 slope2 = add_compensated(multiply_compensated(h_x, h_x), multiply_compensated(h_y, h_y));
    vec2 root = multiply_compensated(vec2(alpha, 0.0), h_z);
    vec2 scale = multiply_compensated(root, root);
    if (slope2.x >= EXPONENT_MAX * scale.x) {
        return vec2(0.0);
    }
    vec2 exponent = divide_compensated(slope2, scale);
    float secant2 = g.h2 / (g.h_z * g.h_z);
    float exp_half = exp_accurate(-0.5 * exponent.x, -0.5 * exponent.y);
    return vec2(exp_half * secant2 * secant2 / (PI * alpha * alpha), exp_half);
}

// cos(theta) Lambda(theta) of Beckmann, with the exact error function (Heitz 2014, eq. 68).
float cos_lambda_beckmann(float cos_theta, float sin2_theta, float alpha) {
    float limit = alpha * alpha * sin2_theta * (BECKMANN_A_MAX * BECKMANN_A_MAX);
    if (limit <= cos_theta * cos_theta) {
        return 0.0;
    }
    float alpha_sin = alpha * sqrt(sin2_theta);
    // The limit was computed otherwise: rounding may put the quotient just above it.
    float a = min(cos_theta / alpha_sin, BECKMANN_A_MAX);
    // erfc(a) = exp(-a^2) erfcx(a)
    return 0.5 * exp_accurate(-a * a, 0.0) * (alpha_sin / sqrt(PI) - cos_theta * erfcx(a));
}
