// A material as a few round lobes, each lit by the environment blurred by its kernel. The host side of this file is
// shaders/round_lobes.py, which says what the numbers are.
//
// Compiled with LOBES, AZIMUTHS (2 for a brushed material, else 1), CUBES, the number of blurred environments, and
// CUBE_OF_LOBE, which of them each lobe looks up.

// A row for each lobe and azimuth: along it, by the viewer's cosine, the amplitude and the tilt. One look-up
// costs a fifth of the polynomials that it was made of, and the steps are too fine to be seen. A nearest texel that is
// sampled costs software renderers half of one that is fetched.
uniform sampler2D lobe_table;

uniform samplerCube blurred[CUBES];
const int cube_of_lobe[LOBES] = CUBE_OF_LOBE;

vec4 lobe_row(int row, float cos_o) {
    return textureLod(lobe_table, vec2(cos_o, (float(row) + 0.5) / float(LOBES * AZIMUTHS)), 0.0);
}

#if AZIMUTHS == 2
// The slope by which each lobe leans along the wide direction, and the cosine and sine of that direction's azimuth.
uniform float lean[LOBES];
uniform vec2 wide_azimuth;

// The radiance towards the unit vector v from a surface whose frame has the columns tangent, bitangent and normal, all in
// the environment's axes.
vec3 lit_by_lobes(mat3 frame, vec3 v, float cos_o) {
    vec3 n = frame[2];
    vec3 wide = wide_azimuth.x * frame[0] + wide_azimuth.y * frame[1];
    float along = dot(v, wide);
    // Lobes that lean to the viewer are not those that lean away: the amplitudes are for viewers on the side of `wide`.
    wide = along < 0.0 ? -wide : wide;
    float sin2 = max(1.0 - cos_o * cos_o, 1e-7);
    float cos2_phi = clamp(along * along / sin2, 0.0, 1.0);
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        vec4 lobe = mix(lobe_row(2 * i + 1, cos_o), lobe_row(2 * i, cos_o), cos2_phi);
        vec3 h = normalize(n + lean[i] * wide);
        vec3 mirrored = 2.0 * dot(v, h) * h - v;
        total += lobe.rgb * textureLod(blurred[cube_of_lobe[i]], h + lobe.a * (mirrored - h), 0.0).rgb;
    }
    return total;
}
#else
// The radiance towards the unit vector v from a surface with the normal n, both in the environment's axes.
vec3 lit_by_lobes(vec3 n, vec3 v, float cos_o) {
    vec3 to_mirrored = (2.0 * cos_o - 1.0) * n - v;
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        vec4 lobe = lobe_row(i, cos_o);
        total += lobe.rgb * textureLod(blurred[cube_of_lobe[i]], n + lobe.a * to_mirrored, 0.0).rgb;
    }
    return total;
}
#endif
