// Directions chosen by the light that comes from them and by how much of it a material reflects to one viewer: each part
// of what the material proposes chooses from the light table by a kernel of its own, the cosine by a cosine, a lobe by one
// of about its width.
//
// - Lagarde, de Rousiers 2014, "Moving Frostbite to Physically Based Rendering": the dominant direction of GGX.

#include "light_table.glsl"
#include "mixture.glsl"
#include "sequence.glsl"

// A lobe of this slope has half of its share: the narrower it is, the better its own directions find its lights, for which
// the table's segments are too wide.
const float NARROW = 0.05;

// How often each part chooses, and where the slots begin by which it does.
struct SeenLights {
    Shares share;
    uint cosine_slots;
    uint lobe_slots[LOBES];
};

// The columns of local_to_environment are tangent, bitangent and normal.
SeenLights lights_seen(Mixture m, vec3 wo, mat3 local_to_environment) {
    SeenLights lights;
    vec3 normal = local_to_environment[2];
    vec3 mirrored = local_to_environment * vec3(-wo.xy, wo.z);
    lights.share.cosine = m.share.cosine;
    lights.cosine_slots = slots_about(0u, normal);
    for (int i = 0; i < LOBES; i++) {
        float alpha = max(m.lobe[i].alpha.x, m.lobe[i].alpha.y);
        lights.share.lobe[i] = m.share.lobe[i] * alpha / (alpha + NARROW);
        // Lagarde and de Rousiers 2014, getSpecularDominantDir
        float tilt = (1.0 - alpha) * (sqrt(1.0 - alpha) + alpha);
        uint kernel = kernel_of(alpha);
        lights.lobe_slots[i] = slots_about(kernel, kernel == 0u ? normal : normalize(mix(normal, mirrored, tilt)));
    }
    lights.share = normalized(lights.share);
    return lights;
}

// A texel, from a point in units of 2^-32, and the direction's place in the picture about it.
ivec2 sample_lights(SeenLights lights, uvec2 point, out vec2 uv) {
    // The first number chooses the segment and the place in it, for which a float has too few bits once it is split.
    float y = unit_point(point).y;
    int part = chosen_part(lights.share, y);
    uint slots = lights.cosine_slots;
    for (int i = 0; i < PROPOSALS; i++) {
        slots = part == i ? lights.lobe_slots[i] : slots;
    }
    return sample_light(slots, point.x, y, uv);
}

// The density in 1/sr of sample_lights, from the alpha of the direction's texel.
float pdf_lights(SeenLights lights, float alpha, vec3 w) {
    // Where a mirror has no cosine, it is not looked up.
    float count = lights.share.cosine > 0.0 ? lights.share.cosine * slots_of(lights.cosine_slots, alpha) : 0.0;
    for (int i = 0; i < PROPOSALS; i++) {
        count += lights.share.lobe[i] * slots_of(lights.lobe_slots[i], alpha);
    }
    return pdf_light(count, alpha, w);
}
