// Directions drawn from all that a material proposes, each part as often as its weight says. The twin of these two
// functions is brdf/sampling.py: draw and density.

#include "material"
#include "sampling.glsl"

float total_weight(float cos_o) {
    float total = diffuse_proposal(cos_o);
    for (int i = 0; i < PROPOSALS; i++) {
        total += specular_proposal(i, cos_o).weight;
    }
    return total;
}

// A direction to the light, which may end below the horizon: u.x chooses the part, u.yz the direction.
vec3 sample_brdf(vec3 wo, vec3 u) {
    float total = total_weight(wo.z);
    float chosen = u.x * total - diffuse_proposal(wo.z);
    if (total <= 0.0 || chosen < 0.0 || PROPOSALS == 0) {
        return sample_cosine(u.yz);
    }
    for (int i = 0; i < PROPOSALS - 1; i++) {
        SpecularLobe lobe = specular_proposal(i, wo.z);
        chosen -= lobe.weight;
        if (chosen < 0.0) {
            return sample_lobe(lobe, wo, u.yz);
        }
    }
    return sample_lobe(specular_proposal(PROPOSALS - 1, wo.z), wo, u.yz);
}

// The density of sample_brdf in 1/sr, for directions above the horizon.
float pdf_brdf(Geometry g) {
    float total = total_weight(g.cos_o);
    if (total <= 0.0) {
        return g.cos_i / PI;
    }
    float pdf = diffuse_proposal(g.cos_o) * (g.cos_i / PI);
    for (int i = 0; i < PROPOSALS; i++) {
        SpecularLobe lobe = specular_proposal(i, g.cos_o);
        if (lobe.weight > 0.0) {
            pdf += lobe.weight * pdf_lobe(lobe, g);
        }
    }
    return pdf / total;
}
