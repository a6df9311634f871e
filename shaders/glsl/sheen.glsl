// Sheen of cloth and dust: a lobe of fibres around the normal, seen at grazing angles. The twin of this file is
// brdf/sheen.py, which holds the references and says what the fits are worth.

#include "common.glsl"
#include "compensated.glsl"
#include "cosine_power.glsl"
#include "elementary.glsl"

const float CHARLIE_ROUGHNESS_MIN = 0.07;
const float FUZZ_ROUGHNESS_MIN = 0.01;
// Smallest squared sine and distance from normal incidence of which a logarithm is taken.
const float SHEEN_SIN2_MIN = 1e-30;
const float SHEEN_LOG_MIN = 1e-30;

float charlie_alpha(float roughness) {
    float r = max(roughness, CHARLIE_ROUGHNESS_MIN);
    return r * r;
}

// Density of normals in 1/sr that rises towards the horizon as sin^(1/alpha) (Conty and Kulla 2017, eq. 2), as two
// factors: their product may lie below float32's range where the lobe does not. What is multiplied by the exponent is
// carried with its rounding error.
vec2 d_charlie(Geometry g, float roughness) {
    float r = max(roughness, CHARLIE_ROUGHNESS_MIN);
    vec2 alpha = two_product(r, r);
    vec2 h_x = two_sum(g.wi.x, g.wo.x);
    vec2 h_y = two_sum(g.wi.y, g.wo.y);
    vec2 h_z = two_sum(g.wi.z, g.wo.z);
    vec2 across = add_compensated(multiply_compensated(h_x, h_x), multiply_compensated(h_y, h_y));
    vec2 along = multiply_compensated(h_z, h_z);
    vec2 h2 = add_compensated(across, along);
    // The logarithm of whichever of 1 - cos^2 and sin^2 has kept its digits.
    vec2 shift = -divide_compensated(along, h2);
    if (shift.x < -0.5) {
        vec2 sin2 = divide_compensated(across, h2);
        shift = add_compensated(vec2(-1.0, 0.0), sin2.x > SHEEN_SIN2_MIN ? sin2 : vec2(SHEEN_SIN2_MIN, 0.0));
    }
    vec2 exponent = divide_compensated(0.25 * log1p_compensated(shift), alpha);
    float power_half = exponent.x > -87.0 ? exp_accurate(exponent.x, exponent.y) : 0.0;
    return vec2((2.0 + 1.0 / alpha.x) / (2.0 * PI) * power_half, power_half);
}

// log(Lambda) at the cosine x (Conty and Kulla 2017).
float charlie_curve(float x, float alpha) {
    float t = (1.0 - alpha) * (1.0 - alpha);
    float a = 21.5473 + t * (25.3245 - 21.5473);
    float b = 3.82987 + t * (3.32435 - 3.82987);
    float c = 0.19823 + t * (0.16801 - 0.19823);
    float d = -1.97760 + t * (-1.27393 + 1.97760);
    float e = -4.32054 + t * (-4.85967 + 4.32054);
    return a / (1.0 + b * exp_accurate(c * log_accurate(max(x, SHEEN_LOG_MIN)), 0.0)) + d * x + e;
}

float charlie_lambda(float cos_theta, float alpha) {
    bool is_grazing = cos_theta < 0.5;
    float value = charlie_curve(is_grazing ? cos_theta : 1.0 - cos_theta, alpha);
    return exp_accurate(is_grazing ? value : 2.0 * charlie_curve(0.5, alpha) - value, 0.0);
}

// Visibility G / (4 cos_i cos_o) of Charlie's fitted Lambda (Conty and Kulla 2017).
float v_charlie(Geometry g, float roughness) {
    float alpha = charlie_alpha(roughness);
    float lambdas = charlie_lambda(g.cos_i, alpha) + charlie_lambda(g.cos_o, alpha);
    return 0.25 / ((1.0 + lambdas) * (g.cos_i * g.cos_o));
}

// The fraction of light that d_charlie v_charlie reflects, cut at 1.
float charlie_albedo(float cos_theta, float roughness) {
    float r = max(roughness, CHARLIE_ROUGHNESS_MIN);
    float u = sqrt(cos_theta);
    float top = 0.5555556 + r * (2.7528488 + r * (-2.2876804 + r * 3.7988741));
    float top_1 = -2.2696713 + r * (18.0888992 + r * 32.2405614);
    top = top + u * (top_1 + u * (-0.5433003 + r * -34.6299911 + u * 3.6170591));
    float bottom = 1.0 + r * (-6.0202966 + r * (44.8655913 + r * (-66.6558121 + r * 33.5152482)));
    float bottom_1 = -9.589783 + r * (18.8833431 + r * (17.6356141 + r * -7.8650279));
    float bottom_2 = 46.7194539 + r * (28.7687285 + r * 69.1985613);
    float bottom_3 = -113.9240706 + r * -69.4224305;
    bottom = bottom + u * (bottom_1 + u * (bottom_2 + u * (bottom_3 + u * 132.5082692)));
    return clamp(top / bottom, 0.0, 1.0);
}

// The fraction of light that the fuzz reflects, cut at 0.
float fuzz_albedo(float cos_theta, float roughness) {
    float x = cos_theta;
    float y = max(roughness, FUZZ_ROUGHNESS_MIN);
    float s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y));
    float m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y);
    float offset = y * (0.000654023 + (-0.0207818 + 0.119681 * y) * y) / (1.26264 + y * (-1.92021 + y));
    float t = (x - m) / s;
    float exponent = -0.5 * t * t;
    float bell = exponent > -87.0 ? exp_accurate(exponent, 0.0) : 0.0;
    return max(bell / (s * sqrt(2.0 * PI)) + offset, 0.0);
}

// The fuzz in 1/sr: its albedo times a linearly transformed cosine about the viewer's azimuth (Zeltner 2022).
float fuzz(Geometry g, float roughness) {
    float x = g.cos_o;
    float y = max(roughness, FUZZ_ROUGHNESS_MIN);
    float a = (2.58126 * x + 0.813703 * y) * y / (1.0 + 0.310327 * x * x + 2.60994 * x * y);
    // MaterialX's second coefficient is b = shear sin_o; with the azimuths' dot product no sine needs to be divided by.
    float shear = (y - 1.0) * y * y * y / (0.0000254053 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y);
    shear = shear / sqrt(1.0 + x);
    float b2 = shear * shear * g.sin2_o;
    float length2 = a * a * g.sin2_i + 2.0 * a * shear * g.dot_xy * g.cos_i + (1.0 + b2) * g.cos_i * g.cos_i;
    float ratio = a / length2;
    return fuzz_albedo(x, roughness) * (ratio * ratio) / PI;
}
