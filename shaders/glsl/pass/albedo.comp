// The directional albedo of a material for one viewer in each group: half of the directions from what it proposes, the
// other half from the cosine, so that no direction weighs more than 2 pi times the material's value.
//
// Compiled with ROUNDS, of 64 directions each.

#include "material"
#include "mixture.glsl"
#include "sequence.glsl"

layout(local_size_x = 64) in;

layout(std430, binding = 2) writeonly buffer Albedos { vec4 albedos[]; };

// Of the part's first viewer in the list.
uniform int offset;

shared vec3 sums[64];

void main() {
    vec2 place = vec2(gl_WorkGroupID.xy) / vec2(gl_NumWorkGroups.x - 1u, gl_NumWorkGroups.y);
    float cos_o = max(place.x * place.x, 1e-4);
    vec3 wo = vec3(sqrt((1.0 - cos_o) * (1.0 + cos_o)) * circle_point(place.y), cos_o);
    Mixture proposals = mixture_seen(wo);
    uvec2 seed = sequence_seed(uvec2(0u), 0u);
    int lane = int(gl_LocalInvocationID.x);
    vec3 sum = vec3(0.0);
    int i = 0;
    do {
        vec2 u = unit_point(sequence_point(uint(i * 64 + lane), seed));
        bool is_proposed = u.x < 0.5;
        u.x = is_proposed ? 2.0 * u.x : 2.0 * u.x - 1.0;
        vec2 v = u;
        int chosen = chosen_part(proposals.share, v.x);
        vec3 wi = sample_part(proposals, is_proposed ? chosen : -1, is_proposed ? v : u);
        if (wi.z > HORIZON) {
            Geometry g = geometry(wi, wo);
            sum += lobes(g) * (g.cos_i / (0.5 * pdf_mixture(proposals, g) + 0.5 * (g.cos_i / PI)));
        }
        i++;
    } while (i < ROUNDS);
    sums[lane] = sum;
    barrier();
    if (lane == 0) {
        for (int other = 1; other < 64; other++) {
            sum += sums[other];
        }
        uint viewer = gl_WorkGroupID.y * gl_NumWorkGroups.x + gl_WorkGroupID.x;
        albedos[offset + int(viewer)] = vec4(sum / float(64 * ROUNDS), 1.0);
    }
}
