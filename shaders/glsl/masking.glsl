// Masking and shadowing, as visibility V = G / (4 cos_i cos_o), which stays finite where G and a cosine vanish.
// The twin of this file is brdf/masking.py, which holds the references.

#include "common.glsl"

// Smith visibility with height correlation (Heitz 2014, eq. 99); cos_lambda from distributions.glsl.
float v_smith(Geometry g, float cos_lambda_i, float cos_lambda_o) {
    return 0.25 / (g.cos_i * g.cos_o + g.cos_o * cos_lambda_i + g.cos_i * cos_lambda_o);
}

// Smith visibility of independent masking and shadowing (Heitz 2014, eq. 98).
float v_smith_separable(Geometry g, float cos_lambda_i, float cos_lambda_o) {
    return 0.25 / ((g.cos_i + cos_lambda_i) * (g.cos_o + cos_lambda_o));
}

// Schlick's rational masking (Schlick 1994), with k from k_direct or k_image_based.
float v_schlick(Geometry g, float k) {
    return 0.25 / ((g.cos_i * (1.0 - k) + k) * (g.cos_o * (1.0 - k) + k));
}

// Schlick's k for direct light: (r + 1)^2 / 8 of the perceptual roughness r = sqrt(alpha) (Karis 2013).
float k_direct(float alpha) {
    float r = sqrt(alpha) + 1.0;
    return r * r / 8.0;
}

// Schlick's k for image-based light: r^2 / 2 of the perceptual roughness r = sqrt(alpha) (Karis 2013).
float k_image_based(float alpha) {
    return alpha / 2.0;
}

// V-cavities: G = min(1, 2 cos_h cos_i / cos_d, 2 cos_h cos_o / cos_d) (Torrance and Sparrow 1967).
float v_cavity(Geometry g) {
    float cos_min = min(g.cos_i, g.cos_o);
    float cos_max = max(g.cos_i, g.cos_o);
    float cos_h = g.h_z / sqrt(g.h2);
    return min(1.0, 2.0 * cos_h * (cos_min / g.cos_d)) * (0.25 / cos_max) / cos_min;
}

// G = min(cos_i, cos_o), that is cos_i cos_o / max(cos_i, cos_o) (Neumann 1999).
float v_neumann(Geometry g) {
    return 0.25 / max(g.cos_i, g.cos_o);
}

// G = cos_i cos_o / cos^2(theta_d) (Kelemen and Szirmay-Kalos 2001).
float v_kelemen(Geometry g) {
    return 0.25 / (g.cos_d * g.cos_d);
}
