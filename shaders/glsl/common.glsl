// The geometry of a pair of directions, computed once per evaluation and shared by all lobes of a sum.
//
// The half vector stays unnormalised, h = wi + wo; nothing starts from a rounded n.h. The twin of this file is
// brdf/frame.py, which says why; its vector m, of which it takes derivatives, is h here.

#include "compensated.glsl"

const float PI = 3.14159265358979;

// Below this cosine a direction counts as below the horizon.
const float HORIZON = 1e-9;

struct Geometry {
    vec3 wi;
    vec3 wo;
    float cos_i;
    float cos_o;
    float sin2_i;
    float sin2_o;
    float dot_xy;
    float h_x;
    float h_y;
    float h_z;
    // The rounding errors of the sums h_x, h_y, h_z.
    vec3 h_low;
    float h_z2;
    float h2;
    float cos_d;
    float one_minus_cos_d;
};

bool above_horizon(vec3 wi, vec3 wo) {
    return wi.z > HORIZON && wo.z > HORIZON;
}

Geometry geometry(vec3 wi, vec3 wo) {
    vec3 h = wi + wo;
    vec3 d = wi - wo;
    vec3 h_low = vec3(two_sum(wi.x, wo.x).y, two_sum(wi.y, wo.y).y, two_sum(wi.z, wo.z).y);
    // What was lost to rounding matters most here, in a narrow highlight.
    float h_z2 = h.z * h.z + 2.0 * h.z * h_low.z;
    float h2 = h.x * h.x + h.y * h.y + h_z2;
    float d2 = d.x * d.x + d.y * d.y + d.z * d.z;
    float cos_d = sqrt(h2 / (h2 + d2));
    Geometry g;
    g.wi = wi;
    g.wo = wo;
    g.cos_i = wi.z;
    g.cos_o = wo.z;
    g.sin2_i = wi.x * wi.x + wi.y * wi.y;
    g.sin2_o = wo.x * wo.x + wo.y * wo.y;
    g.dot_xy = wi.x * wo.x + wi.y * wo.y;
    g.h_x = h.x;
    g.h_y = h.y;
    g.h_z = h.z;
    g.h_low = h_low;
    g.h_z2 = h_z2;
    g.h2 = h2;
    g.cos_d = cos_d;
    g.one_minus_cos_d = d2 / ((h2 + d2) * (1.0 + cos_d));
    return g;
}

// A direction seen from a tangent frame of which cosine and sine are given with their rounding errors: beside the axis of
// a narrow slope the plain products would cancel.
vec3 turned_direction(vec3 w, vec2 c, vec2 s) {
    vec2 x = add_compensated(scale_compensated(c, w.x), scale_compensated(s, w.y));
    vec2 y = add_compensated(scale_compensated(c, w.y), scale_compensated(s, -w.x));
    return vec3(x.x, y.x, w.z);
}

// The geometry seen from a tangent frame that is turned about the normal by `rotation` radians, in
// [-pi/2, pi/2].
Geometry turned(Geometry g, float rotation) {
    vec2 s = sin_compensated(rotation);
    vec2 s_half = sin_compensated(0.5 * rotation);
    // cos(x) = 1 - 2 sin^2(x / 2)
    vec2 c = add_compensated(vec2(1.0, 0.0), -2.0 * multiply_compensated(s_half, s_half));
    vec2 h_x = vec2(g.h_x, g.h_low.x);
    vec2 h_y = vec2(g.h_y, g.h_low.y);
    vec2 turned_x = add_compensated(multiply_compensated(c, h_x), multiply_compensated(s, h_y));
    vec2 turned_y = add_compensated(multiply_compensated(c, h_y), -multiply_compensated(s, h_x));
    g.wi = turned_direction(g.wi, c, s);
    g.wo = turned_direction(g.wo, c, s);
    g.h_x = turned_x.x;
    g.h_y = turned_y.x;
    g.h_low = vec3(turned_x.y, turned_y.y, g.h_low.z);
    return g;
}
