// Radiance from the environment by direction.
//
// Directions here are in the environment's own axes; shaders/environment.py fixes the orientation.

#include "common.glsl"
#include "elementary.glsl"

uniform sampler2D radiance;

// The direction's place in the picture: u to the right, v downwards, both in [0, 1].
vec2 environment_uv(vec3 w) {
    float across = max(sqrt(w.x * w.x + w.z * w.z), 1e-30);  // at the poles any azimuth does
    float azimuth = atan_quadrant(abs(w.x), max(abs(w.z), 1e-30));
    azimuth = w.z > 0.0 ? PI - azimuth : azimuth;
    azimuth = w.x < 0.0 ? -azimuth : azimuth;
    float polar = atan_quadrant(across, max(abs(w.y), 1e-30));
    polar = w.y < 0.0 ? PI - polar : polar;
    return vec2(0.5 + azimuth / (2.0 * PI), polar / PI);
}

vec3 environment_radiance(vec2 uv) {
    return textureLod(radiance, uv, 0.0).rgb;
}
