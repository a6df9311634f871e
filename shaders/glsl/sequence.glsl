// An endless sequence of points in the square, scrambled anew for every pixel: any first part of it is evenly spread.
//
// - Sobol 1967, "On the Distribution of Points in a Cube and the Approximate Evaluation of Integrals": a (0, 2)-sequence.
// - Owen 1995, "Randomly Permuted (t, m, s)-Nets and (t, s)-Sequences".
// - Burley 2020, "Practical Hash-based Owen Scrambling", JCGT 9(4): the permutation, after Laine and Karras 2011.
// - Jarzynski, Olano 2020, "Hash Functions for GPU Rendering", JCGT 9(3): pcg3d.

// A hash of three integers (Jarzynski and Olano 2020, listing of pcg3d).
uvec3 pcg3d(uvec3 v) {
    v = v * 1664525u + 1013904223u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    v ^= v >> 16u;
    v.x += v.y * v.z;
    v.y += v.z * v.x;
    v.z += v.x * v.y;
    return v;
}

// The seeds of one of a pixel's sequences. The lowest bits decide most of a permutation, and pcg3d's own are alike in 60 %
// of neighbours: the upper ones are added to them.
uvec2 sequence_seed(uvec2 pixel, uint stream) {
    uvec2 v = pcg3d(uvec3(pixel, stream)).xy;
    return v ^ (v >> 16u);
}

// A permutation in which every bit depends on the seed and on the lower bits alone (Burley 2020).
uvec2 permuted_upwards(uvec2 v, uvec2 seed) {
    v += seed;
    v ^= v * 0x6c50b47cu;
    v ^= v * 0xb82f1e52u;
    v ^= v * 0xc7afe638u;
    v ^= v * 0x8d22f6e6u;
    return v;
}

// The second coordinate of a point of Sobol's sequence, its bits in reversed order; the first one's are the index
// itself. Bit r is the sum of the index's bits j for which the binomial coefficient (j over r) is odd, which are those
// where r's own bits are all in j.
uint sobol_reversed(uint index) {
    index ^= index >> 16u;
    index ^= (index >> 8u) & 0x00ff00ffu;
    index ^= (index >> 4u) & 0x0f0f0f0fu;
    index ^= (index >> 2u) & 0x33333333u;
    index ^= (index >> 1u) & 0x55555555u;
    return index;
}

// Point `index` in units of 2^-32, scrambled by two seeds.
uvec2 sequence_point(uint index, uvec2 seed) {
    return bitfieldReverse(permuted_upwards(uvec2(index, sobol_reversed(index)), seed));
}

// A point in units of 2^-32 as one in [0, 1)^2.
vec2 unit_point(uvec2 point) {
    return vec2(point >> 8u) * (1.0 / 16777216.0);
}
