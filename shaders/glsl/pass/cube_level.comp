// A level of a cube map from the finer one below it: means weighted by solid angle. A plain mean makes a small sun beside
// a corner, where texels are a fifth of those in a face's middle, too bright.

layout(local_size_x = 8, local_size_y = 8) in;

layout(rgba32f, binding = 0) writeonly uniform imageCube coarse;
layout(rgba32f, binding = 1) readonly uniform imageCube fine;

void main() {
    ivec3 texel = ivec3(gl_GlobalInvocationID);
    if (texel.x >= imageSize(coarse).x || texel.y >= imageSize(coarse).y) {
        return;
    }
    vec4 sum = vec4(0.0);
    for (int i = 0; i < 4; i++) {
        ivec2 part = 2 * texel.xy + ivec2(i & 1, i >> 1);
        vec2 at = (2.0 * vec2(part) + 1.0) / vec2(imageSize(fine)) - 1.0;
        float distance2 = 1.0 + dot(at, at);
        float solid_angle = 1.0 / (distance2 * sqrt(distance2));
        sum += solid_angle * vec4(imageLoad(fine, ivec3(part, texel.z)).rgb, 1.0);
    }
    imageStore(coarse, texel, vec4(sum.rgb / sum.a, 1.0));
}
