// A surface lit by the environment, right for any model: multiple importance sampling with the balance heuristic over
// a fixed number of samples from each of these densities: cosine, environment, and every specular lobe that the material
// proposes. The sum is unbiased whatever the proposals are; they only decide how noisy it is.
//
// - Veach, Guibas 1995, "Optimally Combining Sampling Techniques for Monte Carlo Rendering".

#include "material"
#include "environment.glsl"
#include "light_table.glsl"
#include "sampling.glsl"
#include "tangent.glsl"

// A visible point whose interpolated normal turns away from the viewer is shaded as if seen at this cosine.
const float COS_O_MIN = 1e-4;
const int TECHNIQUES = 2 + PROPOSALS;

in vec3 world_position;
in vec3 world_normal;

uniform vec3 camera_position;
uniform mat3 world_to_environment;
// Samples in this frame from the cosine, from the environment and from each lobe; how many frames came before it in its
// sum, and which of the two sums that is.
uniform ivec3 samples;
uniform int first;
uniform uint seed;

out vec4 color;

vec3 sample_technique(int technique, vec3 wo, mat3 local_to_environment, uvec2 point) {
    if (technique == 0) {
        return sample_cosine(unit_point(point));
    }
    if (technique == 1) {
        return sample_light(point) * local_to_environment;
    }
    return sample_lobe(specular_proposal(technique - 2, wo.z), wo, unit_point(point));
}

// The density of all samples together: each technique's, times its number of samples.
float pdf_samples(Geometry g, vec2 uv) {
    float pdf = float(samples.x) * (g.cos_i / PI) + float(samples.y) * pdf_light(uv);
    for (int proposal = 0; proposal < PROPOSALS; proposal++) {
        pdf += float(samples.z) * pdf_lobe(specular_proposal(proposal, g.cos_o), g);
    }
    return pdf;
}

void main() {
    mat3 local_to_world = tangent_frame(normalize(world_normal));
    mat3 local_to_environment = world_to_environment * local_to_world;
    vec3 wo = normalize(camera_position - world_position) * local_to_world;
    wo = normalize(vec3(wo.xy, max(wo.z, COS_O_MIN)));
    vec3 sum = vec3(0.0);
    for (int technique = 0; technique < TECHNIQUES; technique++) {
        uvec2 shift = pixel_shift(uvec2(gl_FragCoord.xy), uint(technique) + seed * uint(TECHNIQUES));
        int count = samples[min(technique, 2)];
        for (int i = 0; i < count; i++) {
            uvec2 point = sequence_point(uint(first * count + i), shift);
            vec3 wi = sample_technique(technique, wo, local_to_environment, point);
            if (wi.z > HORIZON) {
                Geometry g = geometry(wi, wo);
                vec2 uv = environment_uv(local_to_environment * wi);
                sum += lobes(g) * environment_radiance(uv) * (g.cos_i / pdf_samples(g, uv));
            }
        }
    }
    color = vec4(sum, 1.0);
}
