// What a model proposes to sample: the cosine and visible GGX normals, weighted by the light that each stands for. The
// twin of this file is brdf/sampling.py.

// At most this many specular lobes per model.
const int PROPOSALS_MAX = 2;

struct SpecularLobe {
    float weight;
    float alpha_x;
    float alpha_y;
    float rotation;
};

struct Proposals {
    float diffuse;
    SpecularLobe specular[PROPOSALS_MAX];
};

Proposals no_proposals() {
    SpecularLobe none = SpecularLobe(0.0, 1.0, 1.0, 0.0);
    return Proposals(0.0, SpecularLobe[PROPOSALS_MAX](none, none));
}

float channel_mean(vec3 color) {
    return (color.r + color.g + color.b) / 3.0;
}
