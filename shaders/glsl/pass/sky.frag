// The environment behind the meshes, with coverage 0: that is the share of the meshes.

#include "environment.glsl"

in vec2 ndc;

uniform vec2 jitter_ndc;
// Columns: right, up and forward, the first two as long as half the picture at distance 1.
uniform mat3 view_rays;
uniform mat3 world_to_environment;

out vec4 color;

void main() {
    vec3 ray = view_rays * vec3(ndc - jitter_ndc, 1.0);
    color = vec4(environment_radiance(environment_uv(world_to_environment * ray)), 0.0);
}
