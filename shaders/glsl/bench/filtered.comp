// A peer: one level of a cube map by filtered importance sampling, the same points turned to every texel.
//
// - Colbert, Krivanek 2007, "GPU-Based Importance Sampling", GPU Gems 3, chapter 20.
//
// Compiled with POINTS, and WEIGHTED, 1 if samples count by their cosine as the split sum's do (Karis 2013).

#include "cube.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform imageCube cube;
// Directions about +z, and the level that is read.
layout(std430, binding = 0) readonly buffer Points { vec4 points[]; };

uniform samplerCube sky_cube;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    int size = imageSize(cube).x;
    if (texel.x >= size || texel.y >= size) {
        return;
    }
    vec3 z = normalize(cube_direction(texel.z, 2.0 * (vec2(texel.xy) + 0.5) / float(size) - 1.0));
    vec3 x = normalize(cross(abs(z.y) < 0.9 ? vec3(0.0, 1.0, 0.0) : vec3(1.0, 0.0, 0.0), z));
    vec3 y = cross(z, x);
    vec4 sum = vec4(0.0);
    for (int i = 0; i < POINTS; i++) {
        vec4 point = points[i];
        vec3 radiance = textureLod(sky_cube, point.x * x + point.y * y + point.z * z, point.w).rgb;
#if WEIGHTED
        sum += point.z * vec4(radiance, 1.0);
#else
        sum += vec4(radiance, 1.0);
#endif
    }
    imageStore(cube, texel, vec4(sum.rgb / sum.a, 1.0));
}
