// Lambert's ideal diffuse reflector: f = albedo / pi. The twin of this file is brdf/models/lambert.py.
//
// - Lambert 1760, "Photometria".

#include "common.glsl"
#include "proposals.glsl"

vec3 lambert(lambert_params m, Geometry g) {
    return m.albedo / PI;
}

Proposals lambert_proposals(lambert_params m, float cos_o) {
    Proposals p = no_proposals();
    p.diffuse = channel_mean(m.albedo);
    return p;
}
