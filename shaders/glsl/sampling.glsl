// Directions drawn from visible normals of GGX, with their density in 1/sr. What does not depend on the direction drawn
// is computed once per viewer.
//
// - Eto, Tokuyoshi 2023, "Bounded VNDF Sampling for Smith-GGX Reflections", SIGGRAPH Asia technical communications.
// - Dupuy, Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps".
//
// The twin of this file is brdf/sampling.py.

#include "common.glsl"
#include "distributions.glsl"
#include "elementary.glsl"
#include "proposals.glsl"

// A specular lobe seen by one viewer.
struct SeenLobe {
    // In [1e-4, 1], which the cap's bound allows.
    vec2 alpha;
    // Cosine and sine of the lobe's rotation.
    vec2 turn;
    // wo in the lobe's own axes.
    vec3 wo;
    // The scale of the spherical cap's bound.
    float bound;
    // The density is `scale` times the squared ratio of |h|^2 to the form that d_ggx has, of these coefficients.
    float scale;
    vec3 form;
};

// The scale of the spherical cap's bound (Eto and Tokuyoshi 2023, eq. 5); alpha is the smaller slope.
float cap_bound(vec3 wo, float alpha) {
    float a2 = alpha * alpha;
    float s = 1.0 + length(wo.xy);
    float s2 = s * s;
    return (1.0 - a2) * s2 / (s2 + a2 * wo.z * wo.z);
}

vec2 turned_by(vec2 turn, vec2 v) {
    return vec2(turn.x * v.x + turn.y * v.y, turn.x * v.y - turn.y * v.x);
}

SeenLobe seen_lobe(SpecularLobe lobe, vec3 wo) {
    SeenLobe seen;
    seen.alpha = clamp(vec2(lobe.alpha_x, lobe.alpha_y), 1e-4, 1.0);
    seen.turn = circle_point(lobe.rotation * (0.5 / PI));
    seen.wo = vec3(turned_by(seen.turn, wo.xy), wo.z);
    seen.bound = cap_bound(wo, min(seen.alpha.x, seen.alpha.y));
    float area = seen.alpha.x * seen.alpha.y;
    float t = sqrt(alpha_sin2(seen.wo, seen.alpha.x, seen.alpha.y) + wo.z * wo.z);
    // Eto and Tokuyoshi 2023, eq. 8
    seen.scale = area / (2.0 * PI * (seen.bound * wo.z + t));
    seen.form = vec3(seen.alpha.y / seen.alpha.x, seen.alpha.x / seen.alpha.y, area);
    return seen;
}

// A direction wi that mirrors wo, above the horizon, about a visible normal; it may end below the horizon (Eto and
// Tokuyoshi 2023). The first of the two numbers in [0, 1) is given as the point of the circle that it stands for.
vec3 sample_lobe(SeenLobe lobe, vec2 circle, float u) {
    vec3 wo_standard = normalize(vec3(lobe.alpha * lobe.wo.xy, lobe.wo.z));
    float bound = lobe.bound * wo_standard.z;
    // In (-bound, 1]: the cap of directions that the standard hemisphere can reflect to.
    float z = (1.0 - u) * (1.0 + bound) - bound;
    float sine = sqrt(max(1.0 - z * z, 0.0));
    vec3 m_standard = wo_standard + vec3(sine * circle, z);
    // m_standard is zero only for a point exactly opposite to wo_standard, which the bound excludes.
    vec3 m = normalize(vec3(lobe.alpha * m_standard.xy, m_standard.z));
    vec3 w = normalize(2.0 * dot(lobe.wo, m) * m - lobe.wo);
    return vec3(turned_by(vec2(lobe.turn.x, -lobe.turn.y), w.xy), w.z);
}

// The density of sample_lobe. It needs less care than the value of a lobe, which is compared with float64: its rounding
// errors are noise far below that of the samples.
float pdf_lobe(SeenLobe lobe, Geometry g) {
    vec2 h = turned_by(lobe.turn, vec2(g.h_x, g.h_y));
    float ratio = g.h2 / (dot(lobe.form.xy, h * h) + lobe.form.z * g.h_z2);
    return lobe.scale * (ratio * ratio);
}
