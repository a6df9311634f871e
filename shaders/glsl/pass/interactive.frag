// A surface lit by the environment in one look-up per round lobe of its material.

#include "round_lobes.glsl"
#if SUN
#include "sun.glsl"
#endif
#if AZIMUTHS == 2 || SUN
#include "tangent.glsl"
#endif

// A visible point whose interpolated normal turns away from the viewer is shaded as if seen at this cosine.
const float COS_O_MIN = 1e-4;

in vec3 world_position;
in vec3 world_normal;

uniform vec3 camera_position;
uniform mat3 world_to_environment;

out vec4 color;

void main() {
    vec3 n = normalize(world_normal);
    vec3 v = normalize(camera_position - world_position);
    float cos_o = clamp(dot(n, v), COS_O_MIN, 1.0);
#if AZIMUTHS == 2
    Viewer viewer = viewer_at(world_to_environment * tangent_frame(n), world_to_environment * v, cos_o);
#else
    Viewer viewer = viewer_at(world_to_environment * n, world_to_environment * v, cos_o);
#endif
    color = vec4(lit_by_lobes(viewer), 1.0);
#if SUN
    color.rgb += lit_by_sun(tangent_frame(n), v, cos_o, narrow_lobes(viewer, sun_in_environment));
#endif
}
