// A surface lit by the environment by filtered importance sampling: few directions, all from the material's proposals,
// each of which reads the mean light over the solid angle that it stands for. No fireflies. All pixels share the
// directions: what they miss varies slowly over a surface instead of as grain, and is as large.
//
// What the weights of the directions miss of the material's albedo is known, and is lit by the mean of the light around.
// Hot lights are weighed one by one. A direction that stands for less than such a light, as a mirror's does, sees it
// better: the density there decides how much either counts, so that together they count once.
//
// - Krivanek, Colbert 2008, "Real-time Shading with Filtered Importance Sampling".
// - Veach, Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering": the power heuristic.
//
// Compiled with LIGHTS, in each frame.

#include "material"
#include "albedo.glsl"
#include "mixture.glsl"
#include "sequence.glsl"
#include "shading_point.glsl"

// Of the light of which the albedo's missing part is lit, in sr.
const float AROUND = 1.0;

// Directions per pixel and frame.
uniform int samples;
// How many frames came before this one, and how many there are.
uniform int first;
uniform int frames;
uniform uint seed;
// The environment in its own axes; a level's texels are means over solid angles.
uniform samplerCube sky_cube;
uniform int sky_cube_side;
#if LIGHTS > 0
// The same without hot lights.
uniform samplerCube cool_cube;
// Over which one of them is spread.
uniform float light_solid_angle;
// Pairs of a direction and a flux.
layout(std430, binding = 1) readonly buffer Lights { vec4 lights[]; };
#define COOL_CUBE cool_cube
#else
#define COOL_CUBE sky_cube
#endif

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
    vec3 weights = vec3(0.0);
    vec3 from_lights = vec3(0.0);
    int i = 0;
    do {
        vec2 u = unit_point(sequence_point(uint(first * samples + i), shared_seed));
        int chosen = chosen_part(proposals.share, u.x);
        vec3 wi = sample_part(proposals, chosen, u);
        vec3 w = local_to_environment * wi;
#if LIGHTS > 0
        int light = 2 * (first + max(i - samples, 0) * frames);
        bool is_light = i >= samples;
        w = is_light ? lights[light].xyz : w;
        wi = is_light ? w * local_to_environment : wi;
#endif
        if (wi.z > HORIZON) {
            Geometry g = geometry(wi, wo);
            vec3 value = lobes(g) * g.cos_i;
            float pdf = pdf_mixture(proposals, g);
            float level = cube_level(1.0 / (pdf * total), w);
            vec3 radiance = textureLod(COOL_CUBE, w, level).rgb;
#if LIGHTS > 0
            float covered = total * pdf * light_solid_angle;
            float by_light = 1.0 / (1.0 + covered * covered);
            radiance += (1.0 - by_light) * max(textureLod(sky_cube, w, level).rgb - radiance, 0.0);
            from_lights += is_light ? value * lights[light + 1].rgb * by_light : vec3(0.0);
            value *= is_light ? 0.0 : 1.0 / pdf;
#else
            value /= pdf;
#endif
            weights += value;
            sum += value * radiance;
        }
        i++;
    } while (i < samples + LIGHTS);
    vec3 around = local_to_environment * mix(vec3(-wo.xy, wo.z), vec3(0.0, 0.0, 1.0), proposals.share.cosine);
    vec3 mean = textureLod(COOL_CUBE, around, cube_level(AROUND, around)).rgb;
    float each = 1.0 / float(samples);
    vec3 missing = albedo_between((int(part) - 1) * AZIMUTHS * COSINES, wo) - each * weights;
    color = vec4(max(each * sum + missing * mean, 0.0) + float(frames) * from_lights, 1.0);
}
