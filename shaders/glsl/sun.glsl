// A small light, by the material's own values at its middle, less what blurs of the environment with it already show.
// shaders/sun.py says when.

#include "common.glsl"
#include "material"

// World space, the environment's axes, and the irradiance of a surface that faces it.
uniform vec3 sun_direction;
uniform vec3 sun_in_environment;
uniform vec3 sun_irradiance;
// Closer to the horizon than this cosine, a part of it is below.
uniform float sun_edge;

// The mean cosine of the part above the horizon times that part, for the middle's cosine: a parabola between 0 and the
// cosine itself, as of a light that is evenly spread from -sun_edge to sun_edge.
float cos_risen(float cosine) {
    float risen = cosine + sun_edge;
    return cosine < sun_edge ? 0.25 * risen * risen / sun_edge : cosine;
}

// The outermost half pixel of a ball of 500: there a sun behind it would be seen as a row of dots.
const float COS_O_RIM = 0.05;

// The radiance towards the unit vector v from a surface whose frame has the columns tangent, bitangent and normal;
// `shown` is what is shown already, per irradiance.
vec3 lit_by_sun(mat3 frame, vec3 v, float cos_o, vec3 shown) {
    vec3 wi = sun_direction * frame;
    if (wi.z <= HORIZON - sun_edge) {
        return vec3(0.0);
    }
    wi = normalize(vec3(wi.xy, cos_risen(wi.z)));
    vec3 wo = vec3((v * frame).xy, max(cos_o, COS_O_RIM));
    return wi.z > HORIZON ? max(lobes(geometry(wi, wo)) * wi.z - shown, 0.0) * sun_irradiance : vec3(0.0);
}
