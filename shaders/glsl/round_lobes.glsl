// A material as a few round lobes, each lit by the environment blurred by its kernel. The host side of this file is
// shaders/round_lobes.py, which says what the numbers are.
//
// Compiled with LOBES, AZIMUTHS (2 for a brushed material, else 1) and COEFFICIENTS, of the amplitudes' polynomials.

layout(std140, binding = 1) uniform RoundLobes {
    // Three coefficients of the tilt, and the lean.
    vec4 lobe_shape[LOBES];
    vec4 lobe_amplitude[LOBES * AZIMUTHS * COEFFICIENTS];
    // Cosine and sine of the azimuth of the wide direction.
    vec4 lobe_wide;
};

uniform samplerCube blurred[LOBES];

vec3 lobe_polynomial(int first, float cos_o) {
    vec3 value = lobe_amplitude[first + COEFFICIENTS - 1].rgb;
    for (int k = COEFFICIENTS - 2; k >= 0; k--) {
        value = value * cos_o + lobe_amplitude[first + k].rgb;
    }
    return max(value, 0.0);
}

#if AZIMUTHS == 2
// The radiance towards the unit vector v from a surface whose frame has the columns tangent, bitangent and normal, all in
// the environment's axes.
vec3 lit_by_lobes(mat3 frame, vec3 v, float cos_o) {
    vec3 n = frame[2];
    vec3 wide = lobe_wide.x * frame[0] + lobe_wide.y * frame[1];
    float along = dot(v, wide);
    // Lobes that lean to the viewer are not those that lean away: the amplitudes are for viewers on the side of `wide`.
    wide = along < 0.0 ? -wide : wide;
    float sin2 = max(1.0 - cos_o * cos_o, 1e-7);
    float cos2_phi = clamp(along * along / sin2, 0.0, 1.0);
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        vec4 shape = lobe_shape[i];
        float tilt = shape.x + cos_o * (shape.y + cos_o * shape.z);
        vec3 h = normalize(n + shape.w * wide);
        vec3 mirrored = 2.0 * dot(v, h) * h - v;
        int first = 2 * i * COEFFICIENTS;
        vec3 amplitude = mix(lobe_polynomial(first + COEFFICIENTS, cos_o), lobe_polynomial(first, cos_o), cos2_phi);
        total += amplitude * textureLod(blurred[i], h + tilt * (mirrored - h), 0.0).rgb;
    }
    return total;
}
#else
// The radiance towards the unit vector v from a surface with the normal n, both in the environment's axes.
vec3 lit_by_lobes(vec3 n, vec3 v, float cos_o) {
    vec3 to_mirrored = (2.0 * cos_o - 1.0) * n - v;
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        vec4 shape = lobe_shape[i];
        float tilt = shape.x + cos_o * (shape.y + cos_o * shape.z);
        vec3 amplitude = lobe_polynomial(i * COEFFICIENTS, cos_o);
        total += amplitude * textureLod(blurred[i], n + tilt * to_mirrored, 0.0).rgb;
    }
    return total;
}
#endif
