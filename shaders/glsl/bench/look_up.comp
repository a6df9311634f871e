// What a cube map holds in given directions.

layout(local_size_x = 64) in;

layout(std430, binding = 0) readonly buffer Directions { vec4 directions[]; };
layout(std430, binding = 1) writeonly buffer Values { vec4 values[]; };

uniform samplerCube cube;

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < uint(directions.length())) {
        values[i] = textureLod(cube, directions[i].xyz, 0.0);
    }
}
