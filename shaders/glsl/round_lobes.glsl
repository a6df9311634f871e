// A material as a few round lobes, each lit by the environment blurred by its kernel. The host side of this file is
// shaders/round_lobes.py, which says what the numbers are.
//
// Compiled with LOBES, AZIMUTHS (2 for a brushed material, else 1), CUBES, the number of blurred environments,
// CUBE_OF_LOBE, which of them each lobe looks up, and IS_NARROW, whether a sun is seen in its blur.

// A row for each lobe and azimuth: along it, by the viewer's cosine, the amplitude and the tilt. One look-up
// costs a fifth of the polynomials that it was made of, and the steps are too fine to be seen. A nearest texel that is
// sampled costs software renderers half of one that is fetched.
uniform sampler2D lobe_table;

uniform samplerCube blurred[CUBES];
const int cube_of_lobe[LOBES] = CUBE_OF_LOBE;
const bool is_narrow[LOBES] = IS_NARROW;
// Of each lobe's kernel: 1 / width^2, the power or 0 for a Gaussian one, and the height in 1/sr.
uniform vec3 kernel[LOBES];

vec4 lobe_row(int row, float cos_o) {
    return textureLod(lobe_table, vec2(cos_o, (float(row) + 0.5) / float(LOBES * AZIMUTHS)), 0.0);
}

// What a lobe reflects of its blurred environment, and where that is looked up, not normalised.
struct SeenLobeAt {
    vec3 amplitude;
    vec3 towards;
};

#if AZIMUTHS == 2
// The slope by which each lobe leans along the wide direction, and the cosine and sine of that direction's azimuth.
uniform float lean[LOBES];
uniform vec2 wide_azimuth;

struct Viewer {
    vec3 n;
    vec3 v;
    float cos_o;
    vec3 wide;
    float cos2_phi;
};

// The viewer in the direction of the unit vector v of a surface whose frame has the columns tangent, bitangent and
// normal, all in the environment's axes.
Viewer viewer_at(mat3 frame, vec3 v, float cos_o) {
    vec3 wide = wide_azimuth.x * frame[0] + wide_azimuth.y * frame[1];
    float along = dot(v, wide);
    // Lobes that lean to the viewer are not those that lean away: the amplitudes are for viewers on the side of `wide`.
    wide = along < 0.0 ? -wide : wide;
    float sin2 = max(1.0 - cos_o * cos_o, 1e-7);
    return Viewer(frame[2], v, cos_o, wide, clamp(along * along / sin2, 0.0, 1.0));
}

SeenLobeAt lobe_at(Viewer viewer, int i) {
    vec4 lobe = mix(lobe_row(2 * i + 1, viewer.cos_o), lobe_row(2 * i, viewer.cos_o), viewer.cos2_phi);
    vec3 h = normalize(viewer.n + lean[i] * viewer.wide);
    vec3 mirrored = 2.0 * dot(viewer.v, h) * h - viewer.v;
    return SeenLobeAt(lobe.rgb, h + lobe.a * (mirrored - h));
}
#else
struct Viewer {
    vec3 n;
    vec3 to_mirrored;
    float cos_o;
};

// The viewer in the direction of the unit vector v of a surface with the normal n, both in the environment's axes.
Viewer viewer_at(vec3 n, vec3 v, float cos_o) {
    return Viewer(n, (2.0 * cos_o - 1.0) * n - v, cos_o);
}

SeenLobeAt lobe_at(Viewer viewer, int i) {
    vec4 lobe = lobe_row(i, viewer.cos_o);
    return SeenLobeAt(lobe.rgb, viewer.n + lobe.a * viewer.to_mirrored);
}
#endif

// The radiance towards the viewer.
vec3 lit_by_lobes(Viewer viewer) {
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        SeenLobeAt lobe = lobe_at(viewer, i);
        total += lobe.amplitude * textureLod(blurred[cube_of_lobe[i]], lobe.towards, 0.0).rgb;
    }
    return total;
}

// What the narrow lobes reflect of an irradiance of 1 from the unit vector w.
vec3 narrow_lobes(Viewer viewer, vec3 w) {
    vec3 total = vec3(0.0);
    for (int i = 0; i < LOBES; i++) {
        if (is_narrow[i]) {
            SeenLobeAt lobe = lobe_at(viewer, i);
            vec3 d = normalize(lobe.towards);
            // tan^2 of half the angle between them
            float q = dot(d - w, d - w) / max(dot(d + w, d + w), 1e-6) * kernel[i].x;
            float value = kernel[i].y == 0.0 ? exp(-q) : pow(1.0 + q, -kernel[i].y);
            total += lobe.amplitude * (kernel[i].z * value);
        }
    }
    return total;
}
