// Directions chosen by the light that comes from them. The twin of this file is shaders/light_table.py, which makes the
// table: cells of a latitude-longitude grid, the density constant over each in solid angle.
//
// - Chen, Asau 1974, "On Generating Random Variates from an Empirical Distribution": the guide.

#include "common.glsl"

uniform ivec2 light_size;
// A guide of 2^g entries is indexed by the upper g bits.
uniform int light_guide_shift;
layout(std430, binding = 0) readonly buffer LightPdf { float light_pdf[]; };
layout(std430, binding = 1) readonly buffer LightCells { uint light_cells[]; };
layout(std430, binding = 2) readonly buffer LightCumulative { uint light_cumulative[]; };
layout(std430, binding = 3) readonly buffer LightGuide { uvec2 light_guide[]; };

// The density in 1/sr with which sample_light chooses the direction at uv.
float pdf_light(vec2 uv) {
    ivec2 cell = clamp(ivec2(uv * vec2(light_size)), ivec2(0), light_size - 1);
    return light_pdf[cell.y * light_size.x + cell.x];
}

// The place on the curve of the cell in which the part u / 2^32 of the light lies, by bisection between two places.
uint find_cell(uint u) {
    uvec2 bounds = light_guide[u >> light_guide_shift];
    uint low = bounds.x;
    uint high = bounds.y + 1u;
    while (high - low > 1u) {
        uint middle = (low + high) >> 1u;
        if (light_cumulative[middle] <= u) {
            low = middle;
        } else {
            high = middle;
        }
    }
    return low;
}

// A direction with the density pdf_light, from a point of two integers: the first picks a cell, the second places the
// direction in it with 16 bits each way.
vec3 sample_light(uvec2 point) {
    uint cell = light_cells[find_cell(point.x)];
    float row = float(cell >> 16u);
    float column = float(cell & 65535u);
    vec2 part = vec2(point.y >> 16u, point.y & 65535u) * (1.0 / 65536.0);
    float azimuth = 2.0 * PI * ((column + part.x) / float(light_size.x) - 0.5);
    // Uniform in solid angle between the row's edges, 1 - cos(polar) = 2 sin^2(polar / 2).
    float sine_top = sin(0.5 * PI * row / float(light_size.y));
    float sine_bottom = sin(0.5 * PI * (row + 1.0) / float(light_size.y));
    float sine2_half = mix(sine_top * sine_top, sine_bottom * sine_bottom, part.y);
    float sine = 2.0 * sqrt(sine2_half * max(1.0 - sine2_half, 0.0));
    return vec3(sine * sin(azimuth), 1.0 - 2.0 * sine2_half, -sine * cos(azimuth));
}
