// Fresnel reflectance.
//
// - Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
//
// The twin of this file is brdf/fresnel.py.

// Schlick's approximation (Schlick 1994, eq. 15), from 1 - cos(theta_d) so that no digit is lost near 0.
vec3 f_schlick(vec3 f0, float one_minus_cos_d) {
    float x2 = one_minus_cos_d * one_minus_cos_d;
    return f0 + (1.0 - f0) * (x2 * x2 * one_minus_cos_d);
}
