// What the microfacet models share: the choices of visibility and of Fresnel, and multiple scattering.
// The twins of this file are brdf/microfacet.py and brdf/energy.py, which hold the references.

#include "common.glsl"
#include "fresnel.glsl"
#include "masking.glsl"
#include "proposals.glsl"

// What a facet's reflectance depends on; only those that the choice `option` names are looked at.
struct Fresnel {
    int option;
    vec3 f0;
    vec3 f90;
    vec3 f82;
    float ior;
    vec3 eta;
    vec3 k;
};

// The choices of a microfacet model are the same for all: one macro builds each part from any of their structs.
#define FRESNEL_OF(m) Fresnel(m.fresnel, m.f0, m.f90, m.f82, m.ior, m.eta, m.k)
#define IS_ANISOTROPIC(m) (m.anisotropy == ANISOTROPY_ANISOTROPIC)
#define SLOPES(m) (IS_ANISOTROPIC(m) ? vec2(m.alpha_x, m.alpha_y) : vec2(m.alpha))
#define MEAN_SLOPE(m) (IS_ANISOTROPIC(m) ? sqrt(m.alpha_x * m.alpha_y) : m.alpha)
#define ROTATION(m) (IS_ANISOTROPIC(m) ? m.rotation : 0.0)

float visibility(int option, Geometry g, float cos_lambda_i, float cos_lambda_o, float alpha) {
    if (option == MASKING_SMITH) {
        return v_smith(g, cos_lambda_i, cos_lambda_o);
    }
    if (option == MASKING_SMITH_SEPARABLE) {
        return v_smith_separable(g, cos_lambda_i, cos_lambda_o);
    }
    if (option == MASKING_SCHLICK_DIRECT) {
        return v_schlick(g, k_direct(alpha));
    }
    if (option == MASKING_SCHLICK_IMAGE_BASED) {
        return v_schlick(g, k_image_based(alpha));
    }
    if (option == MASKING_V_CAVITY) {
        return v_cavity(g);
    }
    if (option == MASKING_NEUMANN) {
        return v_neumann(g);
    }
    return v_kelemen(g);
}

vec3 fresnel_reflectance(Fresnel f, float cos_d, float one_minus_cos_d) {
    if (f.option == FRESNEL_SCHLICK) {
        return f_schlick(f.f0, one_minus_cos_d);
    }
    if (f.option == FRESNEL_SCHLICK_F90) {
        return f_schlick_f90(f.f0, f.f90, cos_d, one_minus_cos_d);
    }
    if (f.option == FRESNEL_SCHLICK_F82) {
        return f_schlick_f82(f.f0, f.f82, cos_d, one_minus_cos_d);
    }
    if (f.option == FRESNEL_SPHERICAL_GAUSSIAN) {
        return f_spherical_gaussian(f.f0, cos_d);
    }
    if (f.option == FRESNEL_DIELECTRIC) {
        return vec3(f_dielectric(f.ior, cos_d));
    }
    return f_conductor(f.eta, f.k, cos_d, one_minus_cos_d);
}

// The tables' variable, in which the loss at grazing angles has the same shape for all slopes.
float reduced_cos(float cos_theta, float alpha) {
    return cos_theta * (1.0 + alpha) / (cos_theta + alpha);
}

// The cosine-weighted mean of a reflectance over the hemisphere: 5 Gauss-Legendre nodes in the cosine.
vec3 fresnel_average(Fresnel f) {
    const vec3 COSINE = vec3(0.0469100770, 0.230765345, 0.5);
    const vec3 WEIGHT = vec3(0.236926885, 0.478628670, 0.568888889);
    vec3 total = WEIGHT.z * COSINE.z * fresnel_reflectance(f, COSINE.z, COSINE.z);
    for (int i = 0; i < 2; i++) {
        float low = COSINE[i];
        total += WEIGHT[i] * low * fresnel_reflectance(f, low, 1.0 - low);
        total += WEIGHT[i] * (1.0 - low) * fresnel_reflectance(f, 1.0 - low, low);
    }
    return total;
}

// As in brdf/energy.py.
const float SOFTNESS = 8e-3;

// A loss that is nothing but rounding errors, rounded up smoothly.
float softened(float loss) {
    return 0.5 * (loss + sqrt(loss * loss + SOFTNESS * SOFTNESS));
}

// What is reflected after several facets, in 1/sr, from the losses 1 - E of both directions, as their table has them,
// and 1 - E_avg (Kulla and Conty 2017).
vec3 multiple_scattering(Fresnel fresnel, float loss_i, float loss_o, float mean_loss) {
    vec3 f = fresnel_average(fresnel);
    vec3 f_multiple = f * f * (1.0 - mean_loss) / (1.0 - f * mean_loss);
    return f_multiple * (softened(loss_i) / mean_loss * (softened(loss_o) / PI));
}

// What of the cosine is proposed beside facets of weight 1, from their loss: as much light as several facets reflect, and
// more at wide slopes, where the facets' own proposals are GGX's whatever they are.
float cosine_share(float loss_o, float alpha) {
    return softened(loss_o) + alpha * alpha;
}

// GGX normals of these slopes, and a share `diffuse` of the cosine beside them.
Proposals mixture(Fresnel fresnel, vec2 slopes, float rotation, float diffuse, float cos_o) {
    float weight = channel_mean(fresnel_reflectance(fresnel, cos_o, 1.0 - cos_o));
    Proposals p = no_proposals();
    p.diffuse = diffuse * weight;
    p.specular[0] = SpecularLobe(weight, slopes.x, slopes.y, rotation);
    return p;
}
