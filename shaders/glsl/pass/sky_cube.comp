// From a latitude-longitude picture to a cube map: the mean of SIDE x SIDE points of each texel, radiance above a limit
// left out.

#include "cube.glsl"
#include "environment.glsl"

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform imageCube cube;

uniform float limit;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    int size = imageSize(cube).x;
    if (texel.x >= size || texel.y >= size) {
        return;
    }
    vec3 sum = vec3(0.0);
    for (int i = 0; i < SIDE * SIDE; i++) {
        vec2 within = (vec2(i % SIDE, i / SIDE) + 0.5) / float(SIDE);
        vec3 w = normalize(cube_direction(texel.z, 2.0 * (vec2(texel.xy) + within) / float(size) - 1.0));
        sum += min(environment_radiance(environment_uv(w)), limit);
    }
    imageStore(cube, texel, vec4(sum / float(SIDE * SIDE), 1.0));
}
