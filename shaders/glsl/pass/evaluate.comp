// Evaluates the generated brdf() for a batch of pairs of directions, tightly packed as three floats each.

#include "material"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Incident { float incident[]; };
layout(std430, binding = 1) readonly buffer Outgoing { float outgoing[]; };
layout(std430, binding = 2) writeonly buffer Value { float value[]; };

uniform uint pairs;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= pairs) {
        return;
    }
    vec3 wi = vec3(incident[3u * i], incident[3u * i + 1u], incident[3u * i + 2u]);
    vec3 wo = vec3(outgoing[3u * i], outgoing[3u * i + 1u], outgoing[3u * i + 2u]);
    vec3 f = brdf(wi, wo);
    value[3u * i] = f.r;
    value[3u * i + 1u] = f.g;
    value[3u * i + 2u] = f.b;
}
