// A light without size, by the material's own values. shaders/sun.py says when.

#include "common.glsl"
#include "material"

// World space, and the irradiance of a surface that faces it.
uniform vec3 sun_direction;
uniform vec3 sun_irradiance;

// The radiance towards the unit vector v from a surface whose frame has the columns tangent, bitangent and normal.
vec3 lit_by_sun(mat3 frame, vec3 v, float cos_o) {
    vec3 wi = sun_direction * frame;
    if (wi.z <= HORIZON) {
        return vec3(0.0);
    }
    vec3 wo = normalize(vec3((v * frame).xy, cos_o));
    return lobes(geometry(wi, wo)) * sun_irradiance * wi.z;
}
