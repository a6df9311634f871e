// The subsurface term of Disney 2012, after Hanrahan and Krueger. The twin of this file is
// brdf/models/hanrahan_krueger.py, which holds the formula.
//
// - Hanrahan, Krueger 1993, "Reflection from Layered Surfaces due to Subsurface Scattering".
// - Burley 2012, "Physically Based Shading at Disney", section 5.3, with the code of the BRDF Explorer.

#include "common.glsl"
#include "diffuse.glsl"
#include "proposals.glsl"

vec3 hanrahan_krueger(hanrahan_krueger_params m, Geometry g) {
    return m.albedo / PI * subsurface(g, m.roughness);
}

Proposals hanrahan_krueger_proposals(hanrahan_krueger_params m, float cos_o) {
    Proposals p = no_proposals();
    p.diffuse = channel_mean(m.albedo);
    return p;
}
