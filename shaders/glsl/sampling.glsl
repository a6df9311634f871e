// Points, and directions from points with their densities in 1/sr.
//
// - Roberts 2018, "The Unreasonable Effectiveness of Quasirandom Sequences": R2, from p^3 = p + 1.
// - Cranley, Patterson 1976, "Randomization of Number Theoretic Methods for Multiple Integration": the shift per pixel.
// - Jarzynski, Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3): pcg3d.
// - Ahmed, Wonka 2020, "Screen-Space Blue-Noise Diffusion of Monte Carlo Sampling Error via Hierarchical Ordering of
//   Pixels", ACM TOG 39(6).
// - Eto, Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", SIGGRAPH Asia technical communications.
// - Dupuy, Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".

#include "common.glsl"
#include "distributions.glsl"
#include "proposals.glsl"

// A hash of three integers (Jarzynski and Olano 2020, listing of pcg3d).
uvec3 pcg3d(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// How far along a Hilbert curve over 4096 x 4096 pixels a pixel lies.
uint hilbert_index(uvec2 p) {
    uint index = 0u;
    for (uint half_side = 2048u; half_side > 0u; half_side >>= 1u) {
        bool right = (p.x & half_side) != 0u;
        bool lower = (p.y & half_side) != 0u;
        index = (index << 2u) | ((right ? 3u : 0u) ^ (lower ? 1u : 0u));
        // Each quarter holds a turned copy of the curve.
        p = right && !lower ? ~p : p;
        p = lower ? p : p.yx;
    }
    return index;
}

// The shift of a pixel's points. Pixels that are neighbours on the curve get shifts spread as evenly as its points, so
// that errors alternate from pixel to pixel and the eye averages them (after Ahmed and Wonka 2020). The factors are the
// fractions of sqrt(2) and sqrt(3) in units of 2^-32.
uvec2 pixel_shift(uvec2 pixel, uint stream) {
    return pcg3d(uvec3(stream)).xy + hilbert_index(pixel) * uvec2(1779033703u, 3144134277u);
}

// Point `index` of the R2 sequence (Roberts 2018), shifted, in units of 2^-32, so that no index loses digits.
uvec2 sequence_point(uint index, uvec2 shift) {
    return shift + index * uvec2(3242174889u, 2447445414u);
}

// A point in units of 2^-32 as one in [0, 1)^2.
vec2 unit_point(uvec2 point) {
    return vec2(point >> 8u) * (1.0 / 16777216.0);
}

// Density cos(theta) / pi.
vec3 sample_cosine(vec2 u) {
    float radius = sqrt(u.x);
    float phi = 2.0 * PI * u.y;
    return vec3(radius * cos(phi), radius * sin(phi), sqrt(1.0 - u.x));
}

// The scale of the spherical cap's bound (Eto and Tokuyoshi 2023, eq. 5); alpha is the smaller slope.
float cap_bound(vec3 wo, float alpha) {
    float a2 = alpha * alpha;
    float s = 1.0 + length(wo.xy);
    float s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

// A direction wi that mirrors wo, above the horizon, about a visible normal of GGX, for slopes in [1e-4, 1]; it may end
// below the horizon (Eto and Tokuyoshi 2023).
vec3 sample_ggx(vec3 wo, float alpha_x, float alpha_y, vec2 u) {
    vec3 wo_standard = normalize(vec3(alpha_x * wo.x, alpha_y * wo.y, wo.z));
    float phi = 2.0 * PI * u.x;
    float bound = cap_bound(wo, min(alpha_x, alpha_y)) * wo_standard.z;
    // In (-bound, 1]: the cap of directions that the standard hemisphere can reflect to.
    float z = (1.0 - u.y) * (1.0 + bound) - bound;
    float sine = sqrt(max(1.0 - z * z, 0.0));
    vec3 m_standard = wo_standard + vec3(sine * cos(phi), sine * sin(phi), z);
    // m_standard is zero only for a point exactly opposite to wo_standard, which the bound excludes.
    vec3 m = normalize(vec3(alpha_x * m_standard.x, alpha_y * m_standard.y, m_standard.z));
    return normalize(2.0 * dot(wo, m) * m - wo);
}

// The density of sample_ggx (Eto and Tokuyoshi 2023, eq. 8).
float pdf_ggx(Geometry g, float alpha_x, float alpha_y) {
    float t = sqrt(alpha_sin2(g.wo, alpha_x, alpha_y) + g.cos_o * g.cos_o);
    return d_ggx(g, alpha_x, alpha_y) / (2.0 * (cap_bound(g.wo, min(alpha_x, alpha_y)) * g.cos_o + t));
}

// The slopes of a specular lobe, brought into the range that the cap's bound allows.
vec2 lobe_slopes(SpecularLobe lobe) {
    return clamp(vec2(lobe.alpha_x, lobe.alpha_y), 1e-4, 1.0);
}

vec3 sample_lobe(SpecularLobe lobe, vec3 wo, vec2 u) {
    vec2 alpha = lobe_slopes(lobe);
    if (lobe.rotation == 0.0) {
        return sample_ggx(wo, alpha.x, alpha.y, u);
    }
    float s = sin_compensated(lobe.rotation).x;
    float c = sin_compensated(0.5 * PI - abs(lobe.rotation)).x;
    vec3 w = sample_ggx(vec3(c * wo.x + s * wo.y, c * wo.y - s * wo.x, wo.z), alpha.x, alpha.y, u);
    return vec3(c * w.x - s * w.y, c * w.y + s * w.x, w.z);
}

float pdf_lobe(SpecularLobe lobe, Geometry g) {
    vec2 alpha = lobe_slopes(lobe);
    if (lobe.rotation != 0.0) {
        g = turned(g, lobe.rotation);
    }
    return pdf_ggx(g, alpha.x, alpha.y);
}
