// Computes the generated result() for a batch of pairs of vectors, tightly packed as three floats each.

#include "result"

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer First { float first[]; };
layout(std430, binding = 1) readonly buffer Second { float second[]; };
layout(std430, binding = 2) writeonly buffer Value { float value[]; };

uniform uint pairs;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i >= pairs) {
        return;
    }
    vec3 a = vec3(first[3u * i], first[3u * i + 1u], first[3u * i + 2u]);
    vec3 b = vec3(second[3u * i], second[3u * i + 1u], second[3u * i + 2u]);
    vec3 f = result(a, b);
    value[3u * i] = f.x;
    value[3u * i + 1u] = f.y;
    value[3u * i + 2u] = f.z;
}
