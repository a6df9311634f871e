// The point of a surface that a pixel shows, as pass/points.frag has left it.

#include "tangent.glsl"

// A visible point whose interpolated normal turns away from the viewer is shaded as if seen at this cosine.
const float COS_O_MIN = 1e-4;

uniform sampler2D points_position;
uniform sampler2D points_normal;
// The number of the part that is shaded.
uniform float part;
uniform vec3 camera_position;
uniform mat3 world_to_environment;

// World space; the normal as interpolated, not unit.
struct ShadingPoint {
    vec3 position;
    vec3 normal;
    bool is_of_part;
};

ShadingPoint shading_point() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 position_part = texelFetch(points_position, pixel, 0);
    return ShadingPoint(position_part.xyz, texelFetch(points_normal, pixel, 0).xyz, position_part.w == part);
}

// The direction to the viewer in a local frame, above the horizon.
vec3 seen_from(vec3 position, mat3 local_to_world) {
    vec3 wo = normalize(camera_position - position) * local_to_world;
    return normalize(vec3(wo.xy, max(wo.z, COS_O_MIN)));
}
