// Lambert's ideal diffuse reflector: f = albedo / pi. The twin of this file is brdf/models/lambert.py.
//
// - Lambert 1760, "Photometria".

#include "common.glsl"

vec3 lambert(lambert_params m, Geometry g) {
    return m.albedo / PI;
}
