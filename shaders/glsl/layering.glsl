// A dielectric boundary above something else: what it reflects in all, and what it lets through. The twin of this file
// is brdf/layering.py, which holds the references and says what the fits are worth.

#include "common.glsl"

// Below it only the strength of a boundary falls on, not its shape.
const float F0_SHAPE_MIN = 1e-8;

// Reflectance of a boundary at normal incidence.
float f0_of_ior(float ior) {
    float root = (ior - 1.0) / (ior + 1.0);
    return root * root;
}

// Unpolarised reflectance of a smooth dielectric in a rarer medium; f0 in [0, 1).
float f_dielectric_f0(float f0, float cos_d) {
    float root = sqrt(max(f0, F0_SHAPE_MIN));
    // ior^2 - 1 = 4 root / (1 - root)^2, and its square holds f0 itself.
    float scale = 4.0 / ((1.0 - root) * (1.0 - root));
    float excess = root * scale;
    float c2 = cos_d * cos_d;
    float refracted = sqrt(c2 + excess);
    float s = cos_d + refracted;
    float p = cos_d + excess * cos_d + refracted;
    float perpendicular = scale / (s * s);
    float parallel = scale * ((2.0 + excess) * c2 - 1.0) / (p * p);
    return 0.5 * f0 * (perpendicular * perpendicular + parallel * parallel);
}

// 1 - f_dielectric_f0, to all its digits where it vanishes.
float t_dielectric_f0(float f0, float cos_d) {
    float f0_shape = max(f0, F0_SHAPE_MIN);
    float root = sqrt(f0_shape);
    float excess = 4.0 * root / ((1.0 - root) * (1.0 - root));
    float refracted = sqrt(cos_d * cos_d + excess);
    float dense = cos_d + excess * cos_d;
    float s = cos_d + refracted;
    float p = dense + refracted;
    float t = 2.0 * ((cos_d / s) * (refracted / s) + (dense / p) * (refracted / p));
    float strength = f0 / f0_shape;
    return (1.0 - strength) + strength * t;
}

// The cosine-weighted mean of a dielectric's reflectance over the hemisphere.
float mean_dielectric(float ior) {
    float x = ior - 1.0;
    return x * (0.33969125 + x * 1.44759214) / (1.0 + x * (9.04827686 + x * 1.07453747));
}

// What mirror facets of GGX lose by single scattering.
float facet_loss(float cos_theta, float alpha) {
    float x = cos_theta;
    float y = alpha;
    float top = 0.186667 + y * (0.1372121 + y * 2.4538996) + x * (-0.1590233 + y * 0.7685502 + x * 0.0084945);
    float bottom = y * y * (1.0 + y * -0.3120841);
    bottom = bottom + x * (y * (-0.3264945 + y * 4.9731301) + x * (0.9555886 + y * -2.0209391 + x * 0.5346649));
    return x * y * top / bottom;
}

// The cosine at which a smooth boundary reflects the share that a rough one does.
float mean_cosine(float cos_theta, float alpha) {
    float x = cos_theta;
    float y = alpha;
    float top = 3.475141 + y * (18.3377032 + y * -10.1241678) + x * (-9.1174667 + y * -6.8121414 + x * 0.509954);
    float bottom = y * (1.0 + y * 23.9834816) + x * (2.9893433 + y * 15.2565615 + x * 21.4730263);
    return min(x + y * (x + y) * top / bottom, 1.0);
}

// The share of light that a boundary of GGX facets reflects.
float dielectric_albedo(float f0, float cos_theta, float alpha) {
    return (1.0 - facet_loss(cos_theta, alpha)) * f_dielectric_f0(f0, mean_cosine(cos_theta, alpha));
}

// 1 - dielectric_albedo, the share that reaches the layer below, to all its digits where it vanishes.
float dielectric_transmission(float f0, float cos_theta, float alpha) {
    float loss = facet_loss(cos_theta, alpha);
    float cosine = mean_cosine(cos_theta, alpha);
    return loss * f_dielectric_f0(f0, cosine) + t_dielectric_f0(f0, cosine);
}
