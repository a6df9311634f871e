// Directions drawn from all that a material proposes, each part as often as its weight says. The twin of sample_brdf and
// pdf_brdf is brdf/sampling.py: draw and density.

#include "material"
#include "sampling.glsl"

const int LOBES = max(PROPOSALS, 1);

// How often each part is chosen.
struct Shares {
    float cosine;
    float lobe[LOBES];
};

// What a material proposes to one viewer; the shares sum to 1.
struct Mixture {
    Shares share;
    SeenLobe lobe[LOBES];
};

// The same shares with the sum 1. Where there are none, the cosine has all.
Shares normalized(Shares share) {
    float total = share.cosine;
    for (int i = 0; i < LOBES; i++) {
        total += share.lobe[i];
    }
    share.cosine = total > 0.0 ? share.cosine / total : 1.0;
    for (int i = 0; i < LOBES; i++) {
        share.lobe[i] = total > 0.0 ? share.lobe[i] / total : 0.0;
    }
    return share;
}

Mixture mixture_seen(vec3 wo) {
    Mixture m;
    m.share.cosine = diffuse_proposal(wo.z);
    for (int i = 0; i < LOBES; i++) {
        SpecularLobe lobe = specular_proposal(i, wo.z);
        m.lobe[i] = seen_lobe(lobe, wo);
        m.share.lobe[i] = i < PROPOSALS ? lobe.weight : 0.0;
    }
    m.share = normalized(m.share);
    return m;
}

// The part that a number in [0, 1) stands for, -1 for the cosine, else a lobe; the number becomes its place in there, so
// that evenly spread numbers are evenly spread over each part.
int chosen_part(Shares share, inout float u) {
    int part = -1;
    float start = 0.0;
    float width = share.cosine;
    for (int i = 0; i < PROPOSALS; i++) {
        // Shares may sum to a little less than 1: a part without a share takes nothing of the rest.
        bool beyond = u >= start + width && share.lobe[i] > 0.0;
        start = beyond ? start + width : start;
        width = beyond ? share.lobe[i] : width;
        part = beyond ? i : part;
    }
    u = clamp((u - start) / width, 0.0, 0.99999994);
    return part;
}

// A direction to the light from one part, which may end below the horizon.
vec3 sample_part(Mixture m, int part, vec2 u) {
    // Either way one number is an azimuth: the second of the cosine, the first of a lobe.
    vec2 circle = circle_point(part < 0 ? u.y : u.x);
    SeenLobe lobe = m.lobe[0];
    for (int i = 1; i < PROPOSALS; i++) {
        if (part == i) {
            lobe = m.lobe[i];
        }
    }
    return part < 0 ? vec3(sqrt(u.x) * circle, sqrt(1.0 - u.x)) : sample_lobe(lobe, circle, u.y);
}

// The density of sample_part over all parts in 1/sr, for directions above the horizon.
float pdf_mixture(Mixture m, Geometry g) {
    float pdf = m.share.cosine * (g.cos_i / PI);
    for (int i = 0; i < PROPOSALS; i++) {
        pdf += m.share.lobe[i] * pdf_lobe(m.lobe[i], g);
    }
    return pdf;
}

// A direction to the light: u.x chooses the part, u.yz the direction.
vec3 sample_brdf(vec3 wo, vec3 u) {
    Mixture m = mixture_seen(wo);
    int part = chosen_part(m.share, u.x);
    return sample_part(m, part, u.yz);
}

float pdf_brdf(Geometry g) {
    return pdf_mixture(mixture_seen(g.wo), g);
}
