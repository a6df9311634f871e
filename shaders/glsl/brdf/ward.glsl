// Ward's Gaussian highlight in three normalisations. The twin of this file is brdf/models/ward.py, which holds the
// formulas and the references.

#include "common.glsl"
#include "half_vector.glsl"
#include "proposals.glsl"

// The Gaussian as two factors.
vec2 ward_gaussian(HalfSlopes t, float alpha_x, float alpha_y) {
    vec2 t_x = divide_compensated(t.x, vec2(alpha_x, 0.0));
    vec2 t_y = divide_compensated(t.y, vec2(alpha_y, 0.0));
    // An exponent that its square would take out of range is far beyond zero.
    if (max(abs(t_x.x), abs(t_y.x)) > 1e3) {
        return vec2(0.0);
    }
    return exp_halves(add_compensated(multiply_compensated(t_x, t_x), multiply_compensated(t_y, t_y)));
}

vec3 ward(ward_params m, Geometry g) {
    bool isotropic = m.anisotropy == ANISOTROPY_ISOTROPIC;
    float alpha_x = isotropic ? m.alpha : m.alpha_x;
    float alpha_y = isotropic ? m.alpha : m.alpha_y;
    HalfSlopes t;
    if (isotropic) {
        t = half_slopes(g);
    } else {
        t = half_slopes(turned(g, m.rotation));
    }
    vec2 gaussian = ward_gaussian(t, alpha_x, alpha_y);
    float shape;
    if (m.form == FORM_WARD) {
        shape = 0.25 * gaussian.x / sqrt(g.cos_i) / sqrt(g.cos_o);
    } else if (m.form == FORM_DUER) {
        shape = 0.25 * gaussian.x / g.cos_i / g.cos_o;
    } else {
        float secant2 = 1.0 + t.x.x * t.x.x + t.y.x * t.y.x;
        shape = gaussian.x * secant2 / g.h_z / g.h_z;
    }
    return m.specular * (shape / (PI * alpha_x * alpha_y) * gaussian.y);
}

Proposals ward_proposals(ward_params m, float cos_o) {
    float weight = channel_mean(m.specular);
    Proposals p = no_proposals();
    p.specular[0] = m.anisotropy == ANISOTROPY_ISOTROPIC ? SpecularLobe(weight, m.alpha, m.alpha, 0.0)
                                                         : SpecularLobe(weight, m.alpha_x, m.alpha_y, m.rotation);
    return p;
}
