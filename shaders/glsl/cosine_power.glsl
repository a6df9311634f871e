// Powers of a cosine: the lobes of Phong, of Blinn, and of Ashikhmin and Shirley, exact up to an exponent of 1e5. The
// twin of this file is brdf/cosine_power.py, which holds the references.
//
// A power n multiplies the rounding of the logarithm by n: the logarithm is carried with its rounding error. A power is
// given as two equal factors: their product may lie below float32's range where the lobe does not.

#include "common.glsl"
#include "compensated.glsl"
#include "half_vector.glsl"

// Below it a power of 1e5 is 1, and the ratio of two squares of slopes still has its digits.
const float TAN2_MIN = 1e-20;

// log(1 + x) for x in (-1, 1e30), both with their rounding errors: relative error 2e-9.
vec2 log1p_compensated(vec2 x) {
    vec2 u = add_compensated(vec2(1.0, 0.0), x);
    // u = 2^k m with m from sqrt(1/2) to sqrt(2), and log(m) = 2 atanh((m - 1) / (m + 1)).
    int k = (floatBitsToInt(u.x) - floatBitsToInt(0.70710678)) >> 23;
    float scale = intBitsToFloat((127 - k) << 23);
    vec2 r = add_compensated(vec2(-1.0, 0.0), u * scale);
    vec2 z = divide_compensated(r, add_compensated(vec2(2.0, 0.0), r));
    float z2 = z.x * z.x;
    // The series of 2 atanh(z) - 2 z to the 13th degree: z^2 <= 0.0295 leaves 1e-10.
    float tail = 2.0 / 7.0 + z2 * (2.0 / 9.0 + z2 * (2.0 / 11.0 + z2 * (2.0 / 13.0)));
    tail = z.x * z2 * (2.0 / 3.0 + z2 * (2.0 / 5.0 + z2 * tail));
    vec2 log_m = add_compensated(2.0 * z, vec2(tail, 0.0));
    // ln(2) in two parts, of which 355/512 has an exact product with k (Cody and Waite 1980).
    vec2 log_scale = two_sum(float(k) * 0.693359375, float(k) * -2.12194440e-4);
    return add_compensated(log_scale, log_m);
}

// cos^n of the angle between wi and the direction that mirrors wo; zero from a right angle on.
vec2 cos_mirror_power(Geometry g, float exponent) {
    // wi - mirror(wo) = (h_x, h_y, cos_i - cos_o), and 1 - cos is half the square of its length.
    vec2 h_x = vec2(g.h_x, g.h_low.x);
    vec2 h_y = vec2(g.h_y, g.h_low.y);
    vec2 d_z = two_sum(g.wi.z, -g.wo.z);
    vec2 length2 = add_compensated(multiply_compensated(h_x, h_x), multiply_compensated(h_y, h_y));
    length2 = add_compensated(length2, multiply_compensated(d_z, d_z));
    if (length2.x > 2.0 || (length2.x == 2.0 && length2.y >= 0.0)) {
        return vec2(0.0);
    }
    return exp_halves(multiply_compensated(vec2(-exponent, 0.0), log1p_compensated(-0.5 * length2)));
}

// cos(theta_h)^n.
vec2 cos_h_power(Geometry g, float exponent) {
    // log(cos) = -log(1 + tan^2) / 2
    HalfSlopes t = half_slopes(g);
    vec2 tan2 = add_compensated(multiply_compensated(t.x, t.x), multiply_compensated(t.y, t.y));
    return exp_halves(multiply_compensated(vec2(0.5 * exponent, 0.0), log1p_compensated(tan2)));
}

// cos(theta_h)^n with n = n_x cos^2(phi) + n_y sin^2(phi), where phi is the azimuth of the half vector from an axis at
// `rotation` (Ashikhmin and Shirley 2000).
vec2 cos_h_power_anisotropic(Geometry g, float exponent_x, float exponent_y, float rotation) {
    HalfSlopes t = half_slopes(turned(g, rotation));
    vec2 t2_x = multiply_compensated(t.x, t.x);
    vec2 t2_y = multiply_compensated(t.y, t.y);
    vec2 tan2 = add_compensated(t2_x, t2_y);
    if (tan2.x < TAN2_MIN) {
        return vec2(1.0);
    }
    vec2 along_x = multiply_compensated(vec2(exponent_x, 0.0), t2_x);
    vec2 along_y = multiply_compensated(vec2(exponent_y, 0.0), t2_y);
    vec2 exponent = divide_compensated(add_compensated(along_x, along_y), tan2);
    return exp_halves(multiply_compensated(0.5 * exponent, log1p_compensated(tan2)));
}

// The slope alpha of the microfacets whose highlight is as wide as that of cos(theta_h)^n (Walter 2007).
float slope_of_exponent(float exponent) {
    return sqrt(2.0 / (exponent + 2.0));
}
