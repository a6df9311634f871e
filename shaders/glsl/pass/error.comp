// The squared error of the mean of two sums of frames, from their difference, as a display shows it; shaders/
// accumulation.py says why. One work group adds up 16 x 16 pixels.
//
// Compiled with SKY, 1 if the sky fills what the meshes leave, and NEUTRAL, 1 if the picture is tone-mapped.

#include "tone_map.glsl"

layout(local_size_x = 16, local_size_y = 16) in;

uniform sampler2D sum_even;
uniform sampler2D sum_odd;
// 1 / frames in each sum, and the factor of colour.
uniform float mean;
uniform float exposure;
// For each work group: the squared error times coverage, and the coverage.
layout(std430, binding = 0) writeonly buffer GroupError { vec2 group_error[]; };

shared vec2 group_sum[256];

vec3 displayed(vec4 sum) {
    vec3 c = sum.rgb * (mean * exposure);
#if !SKY
    c = sum.a > 0.0 ? c / (sum.a * mean) : vec3(0.0);
#endif
#if NEUTRAL
    c = khronos_neutral(c);
#endif
    return srgb_encode_clipped(c);
}

void main() {
    ivec2 pixel = ivec2(gl_GlobalInvocationID.xy);
    vec2 own = vec2(0.0);
    if (all(lessThan(pixel, textureSize(sum_even, 0)))) {
        vec4 even = texelFetch(sum_even, pixel, 0);
        vec4 odd = texelFetch(sum_odd, pixel, 0);
        vec3 half_difference = 0.5 * (displayed(even) - displayed(odd));
        float coverage = 0.5 * mean * (even.a + odd.a);
        own = coverage * vec2(dot(half_difference, half_difference) / 3.0, 1.0);
    }
    uint index = gl_LocalInvocationIndex;
    group_sum[index] = own;
    for (uint stride = 128u; stride > 0u; stride >>= 1u) {
        barrier();
        if (index < stride) {
            group_sum[index] += group_sum[index + stride];
        }
    }
    if (index == 0u) {
        group_error[gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x] = group_sum[0];
    }
}
