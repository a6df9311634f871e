// A BRDF given as a table over half and difference angles, isotropic, trilinear between its nodes. Its Python side,
// which lays the table out, is shaders/tabulated.py.
//
// - Rusinkiewicz 1998, "A New Change of Variables for Efficient BRDF Representation", Eurographics Workshop on Rendering.
//
// Values are interpolated as they are, not their logarithms: a mean of neighbours lies between them, so that it is
// never negative, a zero is a value like any other, and it is what the format of a measured table defines.

#include "common.glsl"
#include "elementary.glsl"
#include "proposals.glsl"

layout(std140, binding = 0) uniform Material {
    // Nodes along theta_h, theta_d and phi_d; cells along these axes over their whole range, 2 pi for phi_d.
    ivec3 table_nodes;
    vec3 table_cells;
    // Where in a cell its node lies: 0 at the lower edge, 0.5 in the middle.
    float table_offset;
    // The table holds f times cos_o to this power, 0 or 1.
    float table_cos_power;
    // Weights of the cosine and of the specular lobe, and the lobe's slope.
    vec3 table_proposal;
};
layout(std430, binding = 4) readonly buffer TableValues { float table_values[]; };

// The nodes below and above a place on an axis, and how far it lies from the one to the other.
struct Bracket {
    int lower;
    int upper;
    float share;
};

// Beyond the first and last node their values continue.
Bracket bracket_clamped(float place, int nodes) {
    float inside = clamp(place, 0.0, float(nodes - 1));
    int lower = min(int(inside), max(nodes - 2, 0));
    return Bracket(lower, min(lower + 1, nodes - 1), inside - float(lower));
}

// For places above -nodes.
Bracket bracket_periodic(float place, int nodes) {
    float whole = floor(place);
    int lower = (int(whole) + nodes) % nodes;
    return Bracket(lower, (lower + 1) % nodes, place - whole);
}

// The angle of a vector about the origin in [0, 2 pi], 0 for a vector of length 0.
float azimuth(float x, float y) {
    if (x == 0.0 && y == 0.0) {
        return 0.0;
    }
    float angle = atan_quadrant(abs(y), abs(x));
    angle = x < 0.0 ? PI - angle : angle;
    return y < 0.0 ? 2.0 * PI - angle : angle;
}

// theta_h, theta_d and phi_d of a pair of directions (Rusinkiewicz 1998): arc tangents of lengths that are rounded but
// once, never the arc cosine of a rounded cosine. Where h is the normal, phi_d is the azimuth of wi; where wi is wo, 0.
vec3 half_difference(Geometry g) {
    float sine = length(vec2(g.h_x, g.h_y));
    vec2 direction = sine > 0.0 ? vec2(g.h_x, g.h_y) / sine : vec2(1.0, 0.0);
    float sin_d = sqrt(g.one_minus_cos_d * (1.0 + g.cos_d));
    // Components of wi - wo across h; those of wi are half of them and would cancel.
    vec3 apart = g.wi - g.wo;
    float across = (g.h_z * dot(direction, apart.xy) - sine * apart.z) / sqrt(g.h2);
    float along = direction.x * apart.y - direction.y * apart.x;
    return vec3(atan_quadrant(sine, g.h_z), atan_quadrant(sin_d, g.cos_d), azimuth(across, along));
}

vec3 table_node(int row, int column, int layer) {
    int start = 3 * ((row * table_nodes.y + column) * table_nodes.z + layer);
    return vec3(table_values[start], table_values[start + 1], table_values[start + 2]);
}

vec3 table_along_phi_d(int row, int column, Bracket phi_d) {
    return mix(table_node(row, column, phi_d.lower), table_node(row, column, phi_d.upper), phi_d.share);
}

vec3 table_along_theta_d(int row, Bracket theta_d, Bracket phi_d) {
    vec3 lower = table_along_phi_d(row, theta_d.lower, phi_d);
    return mix(lower, table_along_phi_d(row, theta_d.upper, phi_d), theta_d.share);
}

vec3 lobes(Geometry g) {
    // theta_h runs with the square of the axis: dense at the highlight.
    vec3 angles = half_difference(g) / vec3(0.5 * PI, 0.5 * PI, 2.0 * PI);
    vec3 place = vec3(sqrt(angles.x), angles.yz) * table_cells - table_offset;
    Bracket theta_h = bracket_clamped(place.x, table_nodes.x);
    Bracket theta_d = bracket_clamped(place.y, table_nodes.y);
    Bracket phi_d = bracket_periodic(place.z, table_nodes.z);
    vec3 lower = table_along_theta_d(theta_h.lower, theta_d, phi_d);
    vec3 value = mix(lower, table_along_theta_d(theta_h.upper, theta_d, phi_d), theta_h.share);
    return table_cos_power == 0.0 ? value : value / g.cos_o;
}

vec3 brdf(vec3 wi, vec3 wo) {
    if (!above_horizon(wi, wo)) {
        return vec3(0.0);
    }
    return lobes(geometry(wi, wo));
}

float diffuse_proposal(float cos_o) {
    return table_proposal.x;
}

// PROPOSALS, 0 or 1, is defined by what includes this file.
SpecularLobe specular_proposal(int i, float cos_o) {
    return SpecularLobe(table_proposal.y, table_proposal.z, table_proposal.z, 0.0);
}
