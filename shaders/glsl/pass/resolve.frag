// From the sums of frames to the linear picture: the mean, exposed. Without sums, that of the only frame's samples.
//
// Compiled with SUMS, 0 to 2, SAMPLES per pixel of the frame, 0 or more, and SKY, 1 if the sky fills what the meshes leave.

#if SUMS == 0 && SAMPLES > 1
uniform sampler2DMS frame;
#elif SUMS == 0
uniform sampler2D frame;
#else
uniform sampler2D sum_even;
#endif
#if SUMS == 2
uniform sampler2D sum_odd;
#endif
// 1 / frames for coverage, times the exposure for colour.
uniform float mean;
uniform float exposure;

out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
#if SUMS == 0 && SAMPLES > 1
    vec4 sum = vec4(0.0);
    for (int i = 0; i < SAMPLES; i++) {
        sum += texelFetch(frame, pixel, i);
    }
#elif SUMS == 0
    vec4 sum = texelFetch(frame, pixel, 0);
#else
    vec4 sum = texelFetch(sum_even, pixel, 0);
#endif
#if SUMS == 2
    sum += texelFetch(sum_odd, pixel, 0);
#endif
#if SKY
    color = vec4(sum.rgb * (mean * exposure), 1.0);
#else
    color = vec4(sum.rgb * (mean * exposure), sum.a * mean);
#endif
}
