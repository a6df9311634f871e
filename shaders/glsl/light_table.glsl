// Directions chosen by the light that comes from them and its cosine to a normal. The twin of this file is shaders/
// light_table.py, which makes the table and says how.
//
// A direction's radiance is that of one texel, chosen among the four beside it with the weights by which they are
// interpolated: its mean is the interpolation, and the density of the texel alone is the direction's, because the tent
// of weights about a texel is that with which directions are drawn about it.

#include "common.glsl"
#include "environment.glsl"
#include "sequence.glsl"

// Below this sine of the polar angle the density, which has the sine below it, is held.
const float SINE_MIN = 1e-7;
const uint SEGMENTS = 64u;
const uint ENTRIES = 16384u;
const uint SLOTS = 512u;
const uvec2 NORMALS = uvec2(48u, 24u);

uniform ivec2 light_size;
// Texels a side of the blocks that are listed; each texel of a block is as likely.
uniform int light_block;
layout(std430, binding = 0) readonly buffer LightCells { uint light_cells[]; };
layout(std430, binding = 1) readonly buffer LightSlots { uint light_slots[]; };

// Where the slots of a normal begin.
uint slots_seen(vec3 normal) {
    uvec2 cell = min(uvec2(environment_uv(normal) * vec2(NORMALS)), NORMALS - 1u);
    return (cell.y * NORMALS.x + cell.x) * (SLOTS + SEGMENTS);
}

// The density in 1/sr of sample_light, from the alpha of the direction's texel.
float pdf_light(uint slots, float alpha, vec3 w) {
    uint count = light_slots[slots + SLOTS + (floatBitsToUint(alpha) & (SEGMENTS - 1u))];
    return alpha * float(count) / max(sqrt(w.x * w.x + w.z * w.z), SINE_MIN);
}

// A texel, from a point in units of 2^-32, and the direction's place in the picture about it.
ivec2 sample_light(uint slots, uvec2 point, out vec2 uv) {
    uint slot = light_slots[slots + (point.x >> 23u)];
    float count = float((slot >> 10u) & 1023u);
    float place = float(point.x - ((slot & 1023u) << 23u)) / (8388608.0 * count);
    place = min(place, 0.99999994) * float(ENTRIES);
    float entry = floor(place);
    uint cell = light_cells[(slot >> 20u) * ENTRIES + uint(entry)];
    vec2 part = vec2(place - entry, unit_point(point).y);
    vec2 corner = vec2(cell & 65535u, cell >> 16u);
    vec2 size = vec2(light_size);
    // The last column and row of blocks may be incomplete.
    part *= min(vec2(light_block), size - corner);
    vec2 texel = corner + floor(part);
    part = fract(part);
    vec2 tent = mix(sqrt(2.0 * part) - 1.0, 1.0 - sqrt(2.0 - 2.0 * part), greaterThan(part, vec2(0.5)));
    uv = (texel + 0.5 + tent) / size;
    // Folded at the poles, as the texture's border texels repeat there.
    uv.y = 1.0 - abs(1.0 - abs(uv.y));
    return ivec2(texel);
}

// One of the four texels beside a place, from a point in the square.
ivec2 texel_beside(vec2 uv, vec2 u) {
    ivec2 texel = ivec2(floor(uv * vec2(light_size) - 0.5 + u));
    texel.x += texel.x < 0 ? light_size.x : texel.x >= light_size.x ? -light_size.x : 0;
    return ivec2(texel.x, clamp(texel.y, 0, light_size.y - 1));
}
