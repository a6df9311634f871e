// OpenPBR Surface 1.1, the opaque part: base, specular, coat and fuzz. The twin of this file is brdf/models/openpbr.py,
// which holds the formula.
//
// - Academy Software Foundation, "OpenPBR Surface" 1.1, specification and MaterialX reference implementation.

#include "common.glsl"
#include "diffuse.glsl"
#include "distributions.glsl"
#include "elementary.glsl"
#include "fresnel.glsl"
#include "layering.glsl"
#include "masking.glsl"
#include "proposals.glsl"
#include "sheen.glsl"

const float OPENPBR_ROUGHNESS_MIN = 0.01;
const float OPENPBR_ALPHA_MIN = 1e-4;
// Below it a coat is black: its logarithm is finite and every power of it is nothing.
const float OPENPBR_TRANSMITTANCE_MIN = 1e-30;

// Roughness of the base as seen through a rough coat (OpenPBR 1.1, "Roughening").
float openpbr_coated_roughness(float roughness, float coat_roughness, float coat_weight) {
    float r = max(roughness, OPENPBR_ROUGHNESS_MIN);
    float r_coat = max(coat_roughness, OPENPBR_ROUGHNESS_MIN);
    float r2 = r * r;
    float r2_coat = r_coat * r_coat;
    float roughened = sqrt(sqrt(min(r2 * r2 + 2.0 * r2_coat * r2_coat, 1.0)));
    return (1.0 - coat_weight) * r + coat_weight * roughened;
}

// GGX slopes along and across the tangent, with the mean square of the isotropic one (OpenPBR 1.1, "Microfacet model").
vec2 openpbr_slopes(float roughness, float anisotropy) {
    float across = 1.0 - anisotropy;
    float alpha_x = roughness * roughness * sqrt(2.0 / (1.0 + across * across));
    return vec2(alpha_x, max(across * alpha_x, OPENPBR_ALPHA_MIN));
}

// The slope in the plane of the viewer where it grazes, the mean over both axes where it is above.
float openpbr_viewed_slope(Geometry g, vec2 alpha) {
    float mean_square = 0.5 * (alpha.x * alpha.x + alpha.y * alpha.y);
    return sqrt(min(alpha_sin2(g.wo, alpha.x, alpha.y) + mean_square * (g.cos_o * g.cos_o), 1.0));
}

// Reflectance of the base dielectric at normal incidence below air and coat (OpenPBR 1.1, "Coat").
float openpbr_specular_f0(float specular_ior, float coat_ior, float coat_weight) {
    float below_coat = abs(specular_ior - coat_ior) / min(specular_ior, coat_ior);
    // The index less 1, which a coat of nearly the same index makes small.
    float excess = (1.0 - coat_weight) * (specular_ior - 1.0) + coat_weight * below_coat;
    float root = excess / (2.0 + excess);
    return root * root;
}

// What the coat lets through along the refracted paths in and out (OpenPBR 1.1, "View-dependent absorption").
vec3 openpbr_coat_absorption(vec3 coat_color, float coat_ior, Geometry g) {
    float excess = (coat_ior - 1.0) * (coat_ior + 1.0);
    float length_i = coat_ior / sqrt(g.cos_i * g.cos_i + excess);
    float length_o = coat_ior / sqrt(g.cos_o * g.cos_o + excess);
    vec3 passed;
    for (int i = 0; i < 3; i++) {
        float depth = 0.5 * (length_i + length_o) * log_accurate(max(coat_color[i], OPENPBR_TRANSMITTANCE_MIN));
        passed[i] = depth > -87.0 ? exp_accurate(depth, 0.0) : 0.0;
    }
    return passed;
}

float openpbr_d_v(Geometry g, vec2 alpha) {
    float cos_lambda_i = cos_lambda_ggx(g.cos_i, alpha_sin2(g.wi, alpha.x, alpha.y));
    float cos_lambda_o = cos_lambda_ggx(g.cos_o, alpha_sin2(g.wo, alpha.x, alpha.y));
    return d_ggx(g, alpha.x, alpha.y) * v_smith(g, cos_lambda_i, cos_lambda_o);
}

float openpbr_roughness(openpbr_params m) {
    return openpbr_coated_roughness(m.specular_roughness, m.coat_roughness, m.coat_weight);
}

float openpbr_coat_alpha(openpbr_params m) {
    float r = max(m.coat_roughness, OPENPBR_ROUGHNESS_MIN);
    return r * r;
}

float openpbr_base_f0(openpbr_params m) {
    return m.specular_weight * openpbr_specular_f0(m.specular_ior, m.coat_ior, m.coat_weight);
}

vec3 openpbr_metal(openpbr_params m, float cos_d, float one_minus_cos_d) {
    vec3 f = f_schlick_f82(m.base_weight * m.base_color, m.specular_color, cos_d, one_minus_cos_d);
    return m.specular_weight * f;
}

// The base without what lies above.
vec3 openpbr_base(openpbr_params m, Geometry g) {
    float roughness = openpbr_roughness(m);
    float f0 = openpbr_base_f0(m);
    Geometry t = g;
    if (m.specular_roughness_anisotropy > 0.0) {
        t = turned(g, m.rotation);
    }
    vec2 alpha = openpbr_slopes(roughness, m.specular_roughness_anisotropy);
    float d_v = openpbr_d_v(t, alpha);
    vec3 gloss = m.specular_color * f_dielectric_f0(f0, g.cos_d);
    vec3 rho = m.base_weight * m.base_color;
    float lost_i = single_scattering_loss(g.cos_i, g.sin2_i);
    float lost_o = single_scattering_loss(g.cos_o, g.sin2_o);
    vec3 diffuse = energy_preserving(g, rho, m.base_diffuse_roughness, lost_i, lost_o);
    diffuse = dielectric_transmission(f0, g.cos_o, openpbr_viewed_slope(t, alpha)) * diffuse;
    float metalness = m.base_metalness;
    if (metalness == 0.0) {
        return diffuse + gloss * d_v;
    }
    vec3 metal = openpbr_metal(m, g.cos_d, g.one_minus_cos_d);
    return (1.0 - metalness) * diffuse + ((1.0 - metalness) * gloss + metalness * metal) * d_v;
}

// The factor on the base for the light that the coat throws back to it (OpenPBR 1.1, "Darkening").
vec3 openpbr_darkening(openpbr_params m, float cos_o) {
    float f0 = openpbr_base_f0(m);
    float metalness = m.base_metalness;
    // What the base absorbs at normal incidence, 1 - E_b, as a sum of what cannot be negative.
    vec3 absorbed = 1.0 - m.base_weight * m.base_color;
    vec3 absorbed_dielectric = f0 * (1.0 - m.specular_color) + (1.0 - f0) * absorbed;
    vec3 absorbed_metal = (1.0 - m.specular_weight) + m.specular_weight * absorbed;
    absorbed = (1.0 - metalness) * absorbed_dielectric + metalness * absorbed_metal;
    // How rough the base is in all: its diffuse part fully, its highlights as far as they are.
    float r = m.specular_roughness;
    float rough = (1.0 - metalness) * ((1.0 - f0) + f0 * r) + metalness * r;
    // 1 - K of a smooth and of a rough base.
    float leaves_smooth = t_dielectric_f0(f0_of_ior(m.coat_ior), cos_o);
    float leaves_rough = (1.0 - mean_dielectric(m.coat_ior)) / (m.coat_ior * m.coat_ior);
    float leaves = (1.0 - rough) * leaves_smooth + rough * leaves_rough;
    // (1 - K) / (1 - E_b K) = (1 - K) / ((1 - E_b) K + (1 - K))
    vec3 delta = leaves / (absorbed * (1.0 - leaves) + leaves);
    float strength = m.coat_weight * m.coat_darkening;
    return (1.0 - strength) + strength * delta;
}

// The base and the coat on it.
vec3 openpbr_coated(openpbr_params m, Geometry g) {
    float weight = m.coat_weight;
    float f0_coat = f0_of_ior(m.coat_ior);
    float alpha_coat = openpbr_coat_alpha(m);
    float coat = openpbr_d_v(g, vec2(alpha_coat)) * f_dielectric_f0(f0_coat, g.cos_d);
    vec3 passed = dielectric_transmission(f0_coat, g.cos_o, alpha_coat)
                * openpbr_coat_absorption(m.coat_color, m.coat_ior, g);
    vec3 below = ((1.0 - weight) + weight * passed) * openpbr_darkening(m, g.cos_o);
    return weight * coat + below * openpbr_base(m, g);
}

vec3 openpbr(openpbr_params m, Geometry g) {
    vec3 coated;
    if (m.coat_weight == 0.0) {
        coated = openpbr_base(m, g);
    } else {
        coated = openpbr_coated(m, g);
    }
    if (m.fuzz_weight == 0.0) {
        return coated;
    }
    vec3 fibres = m.fuzz_weight * m.fuzz_color * fuzz(g, m.fuzz_roughness);
    return fibres + (1.0 - m.fuzz_weight * fuzz_albedo(g.cos_o, m.fuzz_roughness)) * coated;
}

Proposals openpbr_proposals(openpbr_params m, float cos_o) {
    float f0_coat = f0_of_ior(m.coat_ior);
    float alpha_coat = openpbr_coat_alpha(m);
    float covered = m.fuzz_weight * fuzz_albedo(cos_o, m.fuzz_roughness);
    float coat = m.coat_weight * (1.0 - covered) * dielectric_albedo(f0_coat, cos_o, alpha_coat);
    float passed = dielectric_transmission(f0_coat, cos_o, alpha_coat) * channel_mean(m.coat_color);
    float below = (1.0 - covered) * ((1.0 - m.coat_weight) + m.coat_weight * passed);

    float base_color = m.base_weight * channel_mean(m.base_color);
    float roughness = openpbr_roughness(m);
    float f0 = openpbr_base_f0(m);
    float gloss = channel_mean(m.specular_color) * dielectric_albedo(f0, cos_o, roughness * roughness);
    float diffuse = base_color * dielectric_transmission(f0, cos_o, roughness * roughness);
    float metal = channel_mean(openpbr_metal(m, cos_o, 1.0 - cos_o));
    float specular = (1.0 - m.base_metalness) * gloss + m.base_metalness * metal;
    vec2 alpha = openpbr_slopes(roughness, m.specular_roughness_anisotropy);
    Proposals p = no_proposals();
    // The cosine stands for the diffuse base and for the fuzz, both broad.
    p.diffuse = covered * channel_mean(m.fuzz_color) + below * (1.0 - m.base_metalness) * diffuse;
    p.specular[0] = SpecularLobe(below * specular, alpha.x, alpha.y, m.rotation);
    p.specular[1] = SpecularLobe(coat, alpha_coat, alpha_coat, 0.0);
    return p;
}
