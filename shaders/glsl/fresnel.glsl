// Fresnel reflectance. The twin of this file is brdf/fresnel.py, which holds the references.

#include "elementary.glsl"

// The cosine at which f82 is given, about 82 degrees.
const float COS_82 = 1.0 / 7.0;

float schlick_weight(float one_minus_cos) {
    float x2 = one_minus_cos * one_minus_cos;
    return x2 * x2 * one_minus_cos;
}

// Schlick's approximation (Schlick 1994, eq. 15), from 1 - cos so that no digit is lost near 0.
vec3 f_schlick(vec3 f0, float one_minus_cos_d) {
    return f0 + (1.0 - f0) * schlick_weight(one_minus_cos_d);
}

// Schlick's approximation that ends in f90 instead of 1 at grazing angles.
vec3 f_schlick_f90(vec3 f0, vec3 f90, float cos_d, float one_minus_cos_d) {
    // 1 - u^5 = (1 - u) (1 + u + ... + u^4), where the difference would cancel.
    float u = one_minus_cos_d;
    float rest = cos_d * (1.0 + u * (1.0 + u * (1.0 + u * (1.0 + u))));
    return f0 * rest + f90 * schlick_weight(u);
}

// Schlick's approximation times a tint f82 at about 82 degrees (Hoffman 2019), cut at 0.
vec3 f_schlick_f82(vec3 f0, vec3 f82, float cos_d, float one_minus_cos_d) {
    float x5 = schlick_weight(one_minus_cos_d);
    float x5_82 = schlick_weight(1.0 - COS_82);
    vec3 at_82 = f0 + (1.0 - f0) * x5_82;
    // The dip, cos (1 - cos)^6 over its value at 82 degrees, where it is largest: near there 1 - dip is written as the
    // double zero that it is, for a bright f0 with a dark tint is nothing but that.
    float t = 7.0 * cos_d - 1.0;
    if (abs(t) < 0.5) {
        float rest = 35.0 / 432.0 - t * (7.0 / 648.0 - t * (35.0 / 46656.0 - t * (1.0 / 46656.0)));
        float one_minus_dip = t * t * (7.0 / 12.0 - t * (35.0 / 108.0 - t * rest));
        return max((1.0 - f0) * (x5 - x5_82) + at_82 * f82 + at_82 * (1.0 - f82) * one_minus_dip, 0.0);
    }
    float dip = cos_d * one_minus_cos_d * x5 * (1.0 / (COS_82 * x5_82 * (1.0 - COS_82)));
    return max(f0 + (1.0 - f0) * x5 - at_82 * (1.0 - f82) * dip, 0.0);
}

// Schlick's power as a spherical Gaussian (Karis 2013).
vec3 f_spherical_gaussian(vec3 f0, float cos_d) {
    return f0 + (1.0 - f0) * exp_accurate(0.693147181 * ((-5.55473 * cos_d - 6.98316) * cos_d), 0.0);
}

// Unpolarised reflectance of a smooth dielectric of index ior >= 1 (Cook and Torrance 1982).
float f_dielectric(float ior, float cos_d) {
    float g = sqrt((ior - 1.0) * (ior + 1.0) + cos_d * cos_d);
    // (g - c) / (g + c) with the difference of squares factored, which holds at ior = 1.
    float s = g + cos_d;
    float perpendicular = ((ior - 1.0) / s) * ((ior + 1.0) / s);
    float ratio = (cos_d * s - 1.0) / (cos_d * (g - cos_d) + 1.0);
    return 0.5 * perpendicular * perpendicular * (1.0 + ratio * ratio);
}

// Unpolarised reflectance of a smooth conductor of complex index eta + i k, both above 0 (Born and Wolf 1999).
vec3 f_conductor(vec3 eta, vec3 k, float cos_d, float one_minus_cos_d) {
    float sin2 = one_minus_cos_d * (1.0 + cos_d);
    // (p + i q)^2 = (eta + i k)^2 - sin^2, the refracted wave's normal component squared.
    vec3 real = (eta - k) * (eta + k) - sin2;
    vec3 product = eta * k;
    vec3 large = 0.5 * (sqrt(real * real + 4.0 * product * product) + abs(real));
    // p^2 q^2 = product^2: the smaller of the two without cancellation.
    vec3 small = product * product / large;
    bvec3 positive = greaterThan(real, vec3(0.0));
    vec3 p = sqrt(mix(small, large, positive));
    vec3 q2 = mix(large, small, positive);
    vec3 minus = p - cos_d;
    vec3 plus = p + cos_d;
    vec3 perpendicular = (minus * minus + q2) / (plus * plus + q2);
    minus = p * cos_d - sin2;
    plus = p * cos_d + sin2;
    q2 = q2 * cos_d * cos_d;
    vec3 parallel = (minus * minus + q2) / (plus * plus + q2);
    return 0.5 * perpendicular * (1.0 + parallel);
}
