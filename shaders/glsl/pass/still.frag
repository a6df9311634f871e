// A surface lit by the environment by filtered importance sampling: few directions, all from the material's proposals,
// each of which reads the mean light over the solid angle that it stands for. No fireflies. A level more, so that filters
// overlap, was measured to be further from the truth under a small sun: a coarse cube's texels differ too much in size. All pixels
// share the directions: what they miss varies slowly over a surface instead of as grain, and is as large.
//
// - Krivanek, Colbert 2008, "Real-time Shading with Filtered Importance Sampling".

#include "material"
#include "mixture.glsl"
#include "sequence.glsl"
#include "shading_point.glsl"

// Directions per pixel and frame.
uniform int samples;
// How many frames came before this one, and how many there are.
uniform int first;
uniform int frames;
uniform uint seed;
// The environment in its own axes; a level's texels are means over solid angles.
uniform samplerCube sky_cube;
uniform int sky_cube_side;

out vec4 color;

// The level at which a texel spans a solid angle; those at a face's corners span a fifth of the one in its middle.
float cube_level(float solid_angle, vec3 w) {
    float major = max(abs(w.x), max(abs(w.y), abs(w.z)));
    float texel = 4.0 * major * major * major / (float(sky_cube_side) * float(sky_cube_side));
    return max(0.5 * log2(solid_angle / texel), 0.0);
}

void main() {
    ShadingPoint point = shading_point();
    if (!point.is_of_part) {
        discard;
    }
    mat3 local_to_world = tangent_frame(normalize(point.normal));
    mat3 local_to_environment = world_to_environment * local_to_world;
    vec3 wo = seen_from(point.position, local_to_world);
    Mixture proposals = mixture_seen(wo);
    uvec2 shared_seed = sequence_seed(uvec2(0u), seed);
    float total = float(samples * frames);
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        vec2 u = unit_point(sequence_point(uint(first * samples + i), shared_seed));
        int chosen = chosen_part(proposals, u.x);
        vec3 wi = sample_part(proposals, chosen, u);
        if (wi.z > HORIZON) {
            Geometry g = geometry(wi, wo);
            float pdf = pdf_mixture(proposals, g);
            vec3 w = local_to_environment * wi;
            vec3 light = textureLod(sky_cube, w, cube_level(1.0 / (pdf * total), w)).rgb;
            sum += lobes(g) * light * (g.cos_i / pdf);
        }
        i++;
    } while (i < samples);
    color = vec4(sum / float(samples), 1.0);
}
