// Directions chosen by the light that comes from them, times a kernel about a direction. The twin of this file is
// shaders/light_table.py, which makes the table and says how.
//
// A direction's radiance is that of one texel, chosen among the four beside it with the weights by which they are
// interpolated: its mean is the interpolation, and the density of the texel alone is the direction's, because the tent
// of weights about a texel is that with which directions are drawn about it.

#include "common.glsl"
#include "environment.glsl"

// Below this sine of the polar angle the density, which has the sine below it, is held.
const float SINE_MIN = 1e-7;
const uint SEGMENTS = 64u;
const uint ENTRIES = 16384u;
const uint SLOTS = 512u;
const uvec2 AXES = uvec2(48u, 24u);
const uint KERNELS = 5u;
// Of kernel 1; each one after it has half the width of the one before.
const float WIDEST = 0.4;

uniform ivec2 light_size;
// Texels a side of the blocks that are listed; each texel of a block is as likely.
uniform int light_block;
layout(std430, binding = 0) readonly buffer LightCells { uint light_cells[]; };
layout(std430, binding = 1) readonly buffer LightSlots { uint light_slots[]; };

// The kernel for what has this slope; the cosine, which is kernel 0, for wide ones.
uint kernel_of(float alpha) {
    return uint(clamp(1.5 + log2(WIDEST / alpha), 0.0, float(KERNELS - 1u)));
}

// Where the slots of a kernel about an axis begin.
uint slots_about(uint kernel, vec3 axis) {
    uvec2 cell = min(uvec2(environment_uv(axis) * vec2(AXES)), AXES - 1u);
    return ((kernel * AXES.y + cell.y) * AXES.x + cell.x) * (SLOTS / 4u + SEGMENTS);
}

// How many of these slots the segment of a texel has, from the texel's alpha.
float slots_of(uint slots, float alpha) {
    return float(light_slots[slots + SLOTS / 4u + (floatBitsToUint(alpha) & (SEGMENTS - 1u))] & 65535u);
}

// The density in 1/sr of sample_light, from the alpha of the direction's texel and how many slots its segment has.
float pdf_light(float count, float alpha, vec3 w) {
    return alpha * count / max(sqrt(w.x * w.x + w.z * w.z), SINE_MIN);
}

// A texel, and the direction's place in the picture about it, from a number in units of 2^-32 and one in [0, 1).
ivec2 sample_light(uint slots, uint x, float y, out vec2 uv) {
    uint slot = x >> 23u;
    uint segment = bitfieldExtract(light_slots[slots + (slot >> 2u)], int(8u * (slot & 3u)), 8);
    uint range = light_slots[slots + SLOTS / 4u + segment];
    float place = float(x - ((range >> 16u) << 23u)) / (8388608.0 * float(range & 65535u));
    place = min(place, 0.99999994) * float(ENTRIES);
    float entry = floor(place);
    uint cell = light_cells[segment * ENTRIES + uint(entry)];
    vec2 part = vec2(place - entry, y);
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
