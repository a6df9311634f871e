// A mesh in world space through the camera, shifted by a fraction of a pixel for antialiasing.

in vec3 position;
in vec3 normal;

uniform mat4 view_projection;
uniform vec2 jitter_ndc;

// The depth pass and the surface pass compute the same depth to the last bit.
invariant gl_Position;
out vec3 world_position;
out vec3 world_normal;

void main() {
    world_position = position;
    world_normal = normal;
    gl_Position = view_projection * vec4(position, 1.0);
    gl_Position.xy += jitter_ndc * gl_Position.w;
}
