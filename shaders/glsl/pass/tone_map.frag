// From the linear picture, with colour premultiplied by coverage, to a display's: tone curve, then sRGB encoding, with
// straight coverage as PNG stores it.

#include "tone_map.glsl"

uniform sampler2D linear;

out vec4 color;

void main() {
    vec4 c = texelFetch(linear, ivec2(gl_FragCoord.xy), 0);
    vec3 straight = c.a > 0.0 ? c.rgb / c.a : vec3(0.0);
    color = vec4(srgb_encode_clipped(khronos_neutral(straight)), c.a);
}
