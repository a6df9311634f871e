// Adds a frame to the sum of frames; blending does the addition.

uniform sampler2D frame;

out vec4 color;

void main() {
    color = texelFetch(frame, ivec2(gl_FragCoord.xy), 0);
}
