// A surface lit by the environment, right for any model: multiple importance sampling with the balance heuristic of
// directions that the material proposes and of directions that the light is in. The sum is unbiased whatever they are;
// they only decide how noisy it is.
//
// - Veach, Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering".
//
// Software renderers run both sides of every branch and one iteration too many of every loop that tests first. So both
// directions are drawn before a loop over them whose body is the only copy of the material, and loops test last.

#include "material"
#include "mixture.glsl"
#include "seen_lights.glsl"
#include "sequence.glsl"
#include "shading_point.glsl"

// Points in each frame of each technique, of 1 or 2: the material's proposals, and then the light.
uniform int samples;
uniform int techniques;
// How many frames came before this one in its sequence, and which sequence.
uniform int first;
uniform uint seed;

out vec4 color;

void main() {
    ShadingPoint point = shading_point();
    if (!point.is_of_part) {
        discard;
    }
    mat3 local_to_world = tangent_frame(normalize(point.normal));
    mat3 local_to_environment = world_to_environment * local_to_world;
    vec3 wo = seen_from(point.position, local_to_world);
    Mixture proposals = mixture_seen(wo);
    uvec2 pixel = uvec2(gl_FragCoord.xy);
    uvec2 material_seed = sequence_seed(pixel, 2u * seed);
    uvec2 light_seed = sequence_seed(pixel, 2u * seed + 1u);
    SeenLights lights = lights_seen(proposals, wo, local_to_environment);
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        uint index = uint(first * samples + i);
        uvec2 material_point = sequence_point(index, material_seed);
        vec2 u = unit_point(material_point);
        int chosen = chosen_part(proposals.share, u.x);
        vec3 proposed = sample_part(proposals, chosen, u);
        vec3 proposed_w = local_to_environment * proposed;
        // The lowest bits, which are the direction's own no more.
        vec2 jitter = vec2(material_point & 65535u) * (1.0 / 65536.0);
        ivec2 proposed_texel = texel_beside(environment_uv(proposed_w), jitter);
        vec2 lit_uv;
        ivec2 lit_texel = sample_lights(lights, sequence_point(index, light_seed), lit_uv);
        vec3 lit_w = environment_direction(lit_uv);
        vec3 lit = lit_w * local_to_environment;
        int technique = 0;
        do {
            vec3 wi = technique == 0 ? proposed : lit;
            if (wi.z > HORIZON) {
                Geometry g = geometry(wi, wo);
                vec4 light = texelFetch(radiance, technique == 0 ? proposed_texel : lit_texel, 0);
                float pdf = pdf_mixture(proposals, g);
                if (techniques > 1) {
                    pdf += pdf_lights(lights, light.a, technique == 0 ? proposed_w : lit_w);
                }
                sum += lobes(g) * light.rgb * (g.cos_i / pdf);
            }
            technique++;
        } while (technique < techniques);
        i++;
    } while (i < samples);
    color = vec4(sum / float(samples), 1.0);
}
