// Burley's diffuse term of Disney 2012, with retro-reflection. The twin of this file is brdf/models/burley.py, which
// holds the formula.
//
// - Burley 2012, "Physically Based Shading at Disney", section 5.3, with the code of the BRDF Explorer.

#include "common.glsl"
#include "diffuse.glsl"
#include "proposals.glsl"

vec3 burley(burley_params m, Geometry g) {
    return m.albedo / PI * retro_reflective(g, m.roughness);
}

Proposals burley_proposals(burley_params m, float cos_o) {
    Proposals p = no_proposals();
    p.diffuse = channel_mean(m.albedo);
    return p;
}
