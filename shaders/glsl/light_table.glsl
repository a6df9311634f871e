// Directions chosen by the light that comes from them. The twin of this file is shaders/light_table.py, which makes the
// table: a texel is chosen as often as it is listed, and about its centre a place by the tent with which the texture is
// interpolated. The density per texel is so the interpolation of the texels' own, which stands in the picture's alpha.

#include "common.glsl"
#include "environment.glsl"
#include "sequence.glsl"

// Below this sine of the polar angle the density, which has the sine below it, is held.
const float SINE_MIN = 1e-7;

uniform ivec2 light_size;
// A list of 2^n entries is indexed by the upper n bits.
uniform int light_shift;
// Texels a side of the blocks that are listed; each texel of a block is as likely.
uniform int light_block;
layout(std430, binding = 0) readonly buffer LightCells { uint light_cells[]; };

// The density in 1/sr of sample_light, from the alpha of the picture and the direction.
float pdf_light(float alpha, vec3 w) {
    return alpha / max(sqrt(w.x * w.x + w.z * w.z), SINE_MIN);
}

// A place in the picture, from a point in units of 2^-32.
vec2 sample_light(uvec2 point) {
    uint cell = light_cells[point.x >> light_shift];
    vec2 part = unit_point(uvec2(point.x << (32 - light_shift), point.y));
    vec2 corner = vec2(cell & 65535u, cell >> 16u);
    vec2 size = vec2(light_size);
    // The last column and row of blocks may be incomplete.
    part *= min(vec2(light_block), size - corner);
    vec2 texel = floor(part);
    part -= texel;
    vec2 tent = mix(sqrt(2.0 * part) - 1.0, 1.0 - sqrt(2.0 - 2.0 * part), greaterThan(part, vec2(0.5)));
    vec2 uv = (corner + texel + 0.5 + tent) / size;
    // Folded at the poles, as the texture's border texels repeat there.
    uv.y = abs(uv.y);
    return vec2(uv.x, 1.0 - abs(1.0 - uv.y));
}
