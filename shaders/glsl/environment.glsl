// Radiance from the environment by direction, and the density with which light_table.glsl chooses it.
//
// Directions here are in the environment's own axes; shaders/environment.py fixes the orientation.

#include "common.glsl"
#include "elementary.glsl"

// Radiance, and where directions are chosen by their light its density in alpha, for light_table.glsl.
uniform sampler2D radiance;

// The angle of (x, y), both >= 0 and not both 0, in [0, 0.25] turns: absolute error 3e-7 turns, far below a texel (the
// polynomial is a minimax fit in float64, as those of elementary.glsl).
float quarter_turn(float y, float x) {
    float t = min(x, y) / max(x, y);
    float s = t * t;
    float p = -0.0185298491 + s * (0.00837908592 + s * -0.00186515832);
    p = 0.159151316 + s * (-0.0529385656 + s * (0.0308029074 + s * p));
    float turns = t * p;
    return y > x ? 0.25 - turns : turns;
}

// The direction's place in the picture: u to the right, v downwards, both in [0, 1].
vec2 environment_uv(vec3 w) {
    float across = max(sqrt(w.x * w.x + w.z * w.z), 1e-30);  // at the poles any azimuth does
    float azimuth = quarter_turn(abs(w.x), max(abs(w.z), 1e-30));
    azimuth = w.z > 0.0 ? 0.5 - azimuth : azimuth;
    azimuth = w.x < 0.0 ? -azimuth : azimuth;
    float polar = 2.0 * quarter_turn(across, max(abs(w.y), 1e-30));
    polar = w.y < 0.0 ? 1.0 - polar : polar;
    return vec2(0.5 + azimuth, polar);
}

// The direction at a place in the picture, which may lie beyond its left and right edges.
vec3 environment_direction(vec2 uv) {
    vec2 around = circle_point(uv.x);
    vec2 down = circle_point(0.5 * uv.y);
    return vec3(-down.y * around.y, down.x, down.y * around.x);
}

vec3 environment_radiance(vec2 uv) {
    return textureLod(radiance, uv, 0.0).rgb;
}
