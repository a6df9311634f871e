// A small light, by the material's own values at its middle. shaders/sun.py says when.

#include "common.glsl"
#include "material"

// World space, and the irradiance of a surface that faces it.
uniform vec3 sun_direction;
uniform vec3 sun_irradiance;
// Closer to the horizon than this cosine, a part of it is below.
uniform float sun_edge;

// The mean cosine of the part above the horizon times that part, for the middle's cosine: a parabola between 0 and the
// cosine itself, as of a light that is evenly spread from -sun_edge to sun_edge.
float cos_risen(float cosine) {
    float risen = cosine + sun_edge;
    return cosine < sun_edge ? 0.25 * risen * risen / sun_edge : cosine;
}

// The radiance towards the unit vector v from a surface whose frame has the columns tangent, bitangent and normal.
vec3 lit_by_sun(mat3 frame, vec3 v, float cos_o) {
    vec3 wi = sun_direction * frame;
    if (wi.z <= HORIZON - sun_edge) {
        return vec3(0.0);
    }
    wi = normalize(vec3(wi.xy, cos_risen(wi.z)));
    vec3 wo = normalize(vec3((v * frame).xy, cos_o));
    return wi.z > HORIZON ? lobes(geometry(wi, wo)) * sun_irradiance * wi.z : vec3(0.0);
}
