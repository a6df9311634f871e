// From the sums of frames to the linear picture: the mean, exposed.
//
// Compiled with SUMS, 1 or 2, and SKY, 1 if the sky fills what the meshes leave.

uniform sampler2D sum_even;
#if SUMS == 2
uniform sampler2D sum_odd;
#endif
// 1 / frames for coverage, times the exposure for colour.
uniform float mean;
uniform float exposure;

out vec4 color;

void main() {
    ivec2 pixel = ivec2(gl_FragCoord.xy);
    vec4 sum = texelFetch(sum_even, pixel, 0);
#if SUMS == 2
    sum += texelFetch(sum_odd, pixel, 0);
#endif
#if SKY
    color = vec4(sum.rgb * (mean * exposure), 1.0);
#else
    color = vec4(sum.rgb * (mean * exposure), sum.a * mean);
#endif
}
