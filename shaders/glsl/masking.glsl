// Masking and shadowing, as visibility V = G / (4 cos_i cos_o), which stays finite where G and a cosine vanish.
//
// - Smith 1967, "Geometrical shadowing of a random rough surface".
// - Heitz 2014, "Understanding the Masking-Shadowing Function in Microfacet-Based BRDFs".
//
// The twin of this file is brdf/masking.py.

#include "common.glsl"

// Smith visibility with height correlation (Heitz 2014, eq. 99); cos_lambda from distributions.glsl.
float v_smith(Geometry g, float cos_lambda_i, float cos_lambda_o) {
    return 0.25 / (g.cos_i * g.cos_o + g.cos_o * cos_lambda_i + g.cos_i * cos_lambda_o);
}

// Smith visibility of independent masking and shadowing (Heitz 2014, eq. 98).
float v_smith_separable(Geometry g, float cos_lambda_i, float cos_lambda_o) {
    return 0.25 / ((g.cos_i + cos_lambda_i) * (g.cos_o + cos_lambda_o));
}
