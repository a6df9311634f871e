// The geometry of a pair of directions, computed once per evaluation and shared by all lobes of a sum.
//
// The half vector stays unnormalised, h = wi + wo; nothing starts from a rounded n.h. The twin of this file is
// brdf/frame.py, which says why.

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
    float h2 = h.x * h.x + h.y * h.y + h.z * h.z;
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
    g.h2 = h2;
    g.cos_d = cos_d;
    g.one_minus_cos_d = d2 / ((h2 + d2) * (1.0 + cos_d));
    return g;
}
