// Diffuse terms that layered models share, without their models' parameters. The twin of this file is brdf/diffuse.py,
// which holds the references.

#include "common.glsl"
#include "compensated.glsl"
#include "elementary.glsl"
#include "fresnel.glsl"

// EON's constants: the directional and the average albedo of Fujii's term are A (1 + r G / pi) and A (1 + c2 r).
const float DIFFUSE_C1 = 0.287793409;
const float DIFFUSE_C2 = 0.0724882125;
// Smallest squared sine of which a root is taken: below it G, the cube of the sine, is zero.
const float DIFFUSE_SIN2_MIN = 1e-20;

// Burley's factor on Lambert's term: darker at grazing angles where smooth, brighter towards the light where rough.
float retro_reflective(Geometry g, float roughness) {
    // |wi + wo| = 2 cos_d
    float excess = 0.5 * roughness * g.h2 - 0.5;
    return (1.0 + excess * schlick_weight(1.0 - g.cos_i)) * (1.0 + excess * schlick_weight(1.0 - g.cos_o));
}

float fresnel_subsurface(float f_ss90, float cos_theta) {
    // 1 + (f_ss90 - 1) (1 - cos)^5, which would cancel at grazing angles, from 1 - u^5 = (1 - u) (1 + u + ... + u^4).
    float u = 1.0 - cos_theta;
    return cos_theta * (1.0 + u * (1.0 + u * (1.0 + u * (1.0 + u)))) + f_ss90 * schlick_weight(u);
}

// Disney 2012's factor on Lambert's term after Hanrahan and Krueger: flattened by scattering inside.
float subsurface(Geometry g, float roughness) {
    float f_ss90 = 0.25 * roughness * g.h2;
    float f_ss = fresnel_subsurface(f_ss90, g.cos_i) * fresnel_subsurface(f_ss90, g.cos_o);
    // 1 / (cos_i + cos_o) - 1/2
    float spread = 0.5 * ((1.0 - g.cos_i) + (1.0 - g.cos_o)) / (g.cos_i + g.cos_o);
    return 1.25 * (f_ss * spread + 0.5);
}

// c1 - G / pi in closed form: proportional to the light that Fujii's single scattering loses.
float single_scattering_loss(float cos_theta, float sin2_theta) {
    float sine = sqrt(max(sin2_theta, DIFFUSE_SIN2_MIN));
    // Expanded about the horizon, where the published terms cancel: pi/2 - theta = atan(cos / sin), and 1 - sin and
    // 1 - sin^3 are multiples of cos^2.
    float square = (0.5 * PI - 2.0 / 3.0) * cos_theta * cos_theta / (1.0 + sine);
    float angle = sine * atan_quadrant(cos_theta, sine);
    float cube = cos_theta * cos_theta * cos_theta * sine * (2.0 + sine) / (3.0 * (1.0 + sine) * (1.0 + sine));
    return (square + (angle - cube)) / PI;
}

// EON, the energy-preserving Oren-Nayar term, in 1/sr (Portsmouth 2025, listing 1), with single_scattering_loss or its
// published polynomial for both directions; see brdf/eon.glsl.
vec3 energy_preserving(Geometry g, vec3 rho, float roughness, float lost_i, float lost_o) {
    float a = 1.0 / (1.0 + DIFFUSE_C1 * roughness);
    float single;
    // Where both directions graze the surface, 1 / t multiplies the rounding of a plain dot product.
    float s = difference_of_products(g.wi.x, g.wo.x, -g.wi.y, g.wo.y);
    if (s > 0.0) {
        single = a * (1.0 + roughness * (s / max(g.cos_i, g.cos_o)));
    } else {
        // 1 + s from |wi + wo|^2 in the tangent plane and the cosines: no difference that opposite directions cancel.
        float one_plus_s = 0.5 * (g.h_x * g.h_x + g.h_y * g.h_y + g.cos_i * g.cos_i + g.cos_o * g.cos_o);
        single = a * ((1.0 - roughness) + roughness * one_plus_s);
    }

    float lost_mean = a * roughness * (DIFFUSE_C1 - DIFFUSE_C2);
    vec3 rho_ms = rho * rho * (1.0 - lost_mean) / (1.0 - rho * lost_mean);
    float multiple = a * roughness * (lost_i * lost_o) / (DIFFUSE_C1 - DIFFUSE_C2);
    return (rho * single + rho_ms * multiple) / PI;
}
