// From linear light to a display: tone curve and encoding.
//
// - Khronos 2024, "Khronos PBR Neutral Tone Mapper" specification.
// - IEC 61966-2-1:1999, the sRGB encoding.

const float START_COMPRESSION = 0.8 - 0.04;
const float DESATURATION = 0.15;

// Keeps base colours below START_COMPRESSION and compresses brighter ones towards white (Khronos 2024).
vec3 khronos_neutral(vec3 c) {
    float least = min(c.r, min(c.g, c.b));
    c -= least < 0.08 ? least - 6.25 * least * least : 0.04;
    float peak = max(c.r, max(c.g, c.b));
    if (peak < START_COMPRESSION) {
        return c;
    }
    float d = 1.0 - START_COMPRESSION;
    float new_peak = 1.0 - d * d / (peak + d - START_COMPRESSION);
    c *= new_peak / peak;
    float g = 1.0 - 1.0 / (DESATURATION * (peak - new_peak) + 1.0);
    return mix(c, vec3(new_peak), g);
}

float srgb_encode(float x) {
    return x <= 0.0031308 ? 12.92 * x : 1.055 * pow(x, 1.0 / 2.4) - 0.055;
}

// Linear values, clipped to [0, 1], as a display takes them.
vec3 srgb_encode_clipped(vec3 c) {
    vec3 clipped = clamp(c, 0.0, 1.0);
    return vec3(srgb_encode(clipped.r), srgb_encode(clipped.g), srgb_encode(clipped.b));
}
