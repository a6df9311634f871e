// Which points of the meshes are seen: what passes that shade them need, so that each pixel is shaded once and in one
// draw. Small triangles would leave most of a GPU's lanes idle.

in vec3 world_position;
in vec3 world_normal;

// The number of the part, from 1.
uniform float part;

layout(location = 0) out vec4 position_part;
layout(location = 1) out vec4 normal;

void main() {
    position_part = vec4(world_position, part);
    normal = vec4(world_normal, 0.0);
}
