// Elementary functions to float32's accuracy: GLSL promises (3 + 2|x|) units in the last place for exp, 4096 for atan
// and has no erfc (OpenGL Shading Language 4.30, section 4.5.1).
//
// - Cody, Waite 1980, "Software Manual for the Elementary Functions": the reduction of exp by ln 2 in two parts.
// - The polynomials of erfcx and of the arc tangent are minimax fits in float64 (Lawson's reweighted least squares at
//   2000 Chebyshev nodes, against scipy.special.erfcx and numpy.arctan); their errors stand beside them.

// exp(x + x_low) for |x_low| far below |x| and x in [-87, 88]: relative error 1.5e-7.
float exp_accurate(float x, float x_low) {
    float k = round(1.44269504 * x);
    // 355/512 has 9 bits, so that its product with k is exact (Cody and Waite 1980).
    precise float r = (x - k * 0.693359375) - k * -2.12194440e-4;
    r += x_low;
    // Taylor to the 7th degree: |r| <= ln(2)/2 leaves 5e-9.
    float p = 1.0 / 120.0 + r * (1.0 / 720.0 + r * (1.0 / 5040.0));
    p = 0.5 + r * (1.0 / 6.0 + r * (1.0 / 24.0 + r * p));
    p = 1.0 + (r + r * r * p);
    return p * intBitsToFloat((int(k) + 127) << 23);
}

// exp(a^2) erfc(a) for a in [0, 10]: relative error 3e-7, of the polynomial alone 4e-8.
float erfcx(float a) {
    float t = 1.0 / (1.0 + 0.5 * a);
    float s = t - 0.5;
    float p = 0.0953297541 + s * (0.0482991114 + s * -0.059068948);
    p = 0.145740747 + s * (-0.171868622 + s * (-0.1029967 + s * p));
    p = 0.510791361 + s * (0.687160969 + s * (0.558939278 + s * p));
    return t * p;
}

// The angle of (x, y), both >= 0 and not both 0, in [0, pi/2]: relative error 2e-7, of the polynomial alone 7e-10.
float atan_quadrant(float y, float x) {
    float t = min(x, y) / max(x, y);
    // tan(pi/8) halves the range: atan(t) = pi/4 + atan((t - 1) / (t + 1)).
    bool upper = t > 0.414213562;
    float r = upper ? (t - 1.0) / (t + 1.0) : t;
    float s = r * r;
    float p = -0.142438382 + s * (0.105959155 + s * -0.0608322397);
    p = s * (-0.333333164 + s * (0.199984893 + s * p));
    float angle = (upper ? 0.785398163 : 0.0) + (r + r * p);
    return y > x ? 1.57079633 - angle : angle;
}

// log(x) for x > 0: relative error 2e-7, also beside x = 1.
float log_accurate(float x) {
    int bits = floatBitsToInt(x);
    // x = m 2^k with m in [sqrt(1/2), sqrt(2)).
    int k = (bits - 0x3f3504f3) >> 23;
    float m = intBitsToFloat(bits - (k << 23));
    float s = (m - 1.0) / (m + 1.0);
    float z = s * s;
    // 2 artanh(s), its series to the 11th power: |s| <= 0.172 leaves 2e-10.
    float p = 2.0 / 3.0 + z * (2.0 / 5.0 + z * (2.0 / 7.0 + z * (2.0 / 9.0 + z * (2.0 / 11.0))));
    // ln 2 in two parts, the first with 9 bits so that its product with k is exact (Cody and Waite 1980).
    return float(k) * 0.693359375 + (2.0 * s + (s * z * p + float(k) * -2.12194440e-4));
}

// log(1 + x) for x >= 0: relative error 3e-7.
float log1p_accurate(float x) {
    if (x < 0.4) {
        float s = x / (2.0 + x);
        float z = s * s;
        float p = 2.0 / 3.0 + z * (2.0 / 5.0 + z * (2.0 / 7.0 + z * (2.0 / 9.0 + z * (2.0 / 11.0))));
        return 2.0 * s + s * z * p;
    }
    return log_accurate(1.0 + x);
}

// (1 - exp(-x)) / x for x >= -87, 1 at x = 0: relative error 2e-7.
float mean_decay(float x) {
    if (abs(x) < 0.5) {
        float p = 1.0 - x / 6.0 * (1.0 - x / 7.0 * (1.0 - x / 8.0 * (1.0 - x / 9.0)));
        return 1.0 - x / 2.0 * (1.0 - x / 3.0 * (1.0 - x / 4.0 * (1.0 - x / 5.0 * p)));
    }
    return (1.0 - exp_accurate(-min(x, 87.0), 0.0)) / x;
}

// Cosine and sine of a number of whole turns, of any size: absolute error 3e-7 (Taylor to the 8th degree on an eighth
// of a turn leaves 3e-8), where GLSL promises 5e-4 for sin and cos.
vec2 circle_point(float turns) {
    float quarters = 4.0 * (turns - round(turns));
    float nearest = round(quarters);
    float x = 1.57079633 * (quarters - nearest);
    float x2 = x * x;
    float s = x + x * x2 * (-1.0 / 6.0 + x2 * (1.0 / 120.0 + x2 * (-1.0 / 5040.0)));
    float c = 1.0 + x2 * (-0.5 + x2 * (1.0 / 24.0 + x2 * (-1.0 / 720.0 + x2 * (1.0 / 40320.0))));
    int quarter = int(nearest) & 3;
    vec2 turned_once = (quarter & 1) == 0 ? vec2(c, s) : vec2(-s, c);
    return (quarter & 2) == 0 ? turned_once : -turned_once;
}
