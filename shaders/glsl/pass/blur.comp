// An environment blurred by a narrow kernel. Its lamps, lights without size, are weighed by the kernel itself. The rest
// is the mean of a cube map's texels at points that lie as dense as the kernel is high, each at the level whose texels
// fill the gaps to its neighbours.
//
// - Colbert, Krivanek 2007, "GPU-Based Importance Sampling", GPU Gems 3, chapter 20.
//
// Compiled with POINTS, and TWICE_POWER: 0 for the infinite one.

#include "cube.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform imageCube cube;
// Directions about +z, and the level.
layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };
uniform samplerCube dim_cube;
// Pairs of a direction and what the lamp sends from there.
layout(std430, binding = 1) readonly buffer Lamps { vec4 lamps[]; };

uniform int lamp_count;
uniform float kernel_width;
// Of the kernel at its middle, 1/sr.
uniform float kernel_height;

float kernel(vec3 w, vec3 middle) {
    vec3 apart = w - middle;
    vec3 between = w + middle;
    float x = dot(apart, apart) / max(dot(between, between), 1e-20) / (kernel_width * kernel_width);
#if TWICE_POWER == 0
    return x < 80.0 ? kernel_height * exp(-x) : 0.0;
#else
    float root = inversesqrt(1.0 + x);
    float value = kernel_height;
    for (int i = 0; i < TWICE_POWER; i++) {
        value *= root;
    }
    return value;
#endif
}

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    int size = imageSize(cube).x;
    if (texel.x >= size || texel.y >= size) {
        return;
    }
    vec3 z = normalize(cube_direction(texel.z, 2.0 * (vec2(texel.xy) + 0.5) / float(size) - 1.0));
    vec3 x = normalize(cross(abs(z.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), z));
    vec3 y = cross(z, x);
    vec3 sum = vec3(0.0);
    for (int i = 0; i < POINTS; i++) {
        vec4 point = points[i];
        sum += textureLod(dim_cube, point.x * x + point.y * y + point.z * z, point.w).rgb;
    }
    sum /= float(POINTS);
    for (int i = 0; i < lamp_count; i++) {
        sum += kernel(lamps[2 * i].xyz, z) * lamps[2 * i + 1].rgb;
    }
    imageStore(cube, texel, vec4(sum, 1.0));
}
