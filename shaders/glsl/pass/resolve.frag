// From the sum of frames to the linear picture: the mean, exposed.

uniform sampler2D accumulation;
// 1 / frames for coverage, times the exposure for colour.
uniform float mean;
uniform float exposure;

out vec4 color;

void main() {
    vec4 sum = texelFetch(accumulation, ivec2(gl_FragCoord.xy), 0);
    color = vec4(sum.rgb * (mean * exposure), sum.a * mean);
}
