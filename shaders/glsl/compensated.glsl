// Compensated arithmetic: a value is carried as a vec2 of a float and its rounding error, about 48 bits together.
//
// - Dekker 1971, "A floating-point technique for extending the available precision".
// - Knuth 1969, "The Art of Computer Programming", volume 2, section 4.2.2.
//
// `precise` forbids the compiler to fuse or reorder, which would cancel the very terms that are computed here.

// 2^12 + 1 splits the 24 bits of a float into two halves (Dekker 1971).
const float SPLITTER = 4097.0;

vec2 two_sum(float a, float b) {
    precise float sum = a + b;
    precise float b_virtual = sum - a;
    precise float a_virtual = sum - b_virtual;
    precise float error = (a - a_virtual) + (b - b_virtual);
    return vec2(sum, error);
}

// two_sum for |a| >= |b|.
vec2 fast_two_sum(float a, float b) {
    precise float sum = a + b;
    precise float error = b - (sum - a);
    return vec2(sum, error);
}

vec2 two_product(float a, float b) {
    precise float product = a * b;
    precise float a_big = SPLITTER * a;
    precise float a_high = a_big - (a_big - a);
    precise float a_low = a - a_high;
    precise float b_big = SPLITTER * b;
    precise float b_high = b_big - (b_big - b);
    precise float b_low = b - b_high;
    precise float error = ((a_high * b_high - product) + a_high * b_low + a_low * b_high) + a_low * b_low;
    return vec2(product, error);
}

vec2 add_compensated(vec2 a, vec2 b) {
    vec2 sum = two_sum(a.x, b.x);
    precise float error = sum.y + (a.y + b.y);
    return fast_two_sum(sum.x, error);
}

vec2 multiply_compensated(vec2 a, vec2 b) {
    vec2 product = two_product(a.x, b.x);
    precise float error = product.y + (a.x * b.y + a.y * b.x);
    return fast_two_sum(product.x, error);
}

vec2 scale_compensated(vec2 a, float b) {
    return multiply_compensated(a, vec2(b, 0.0));
}

vec2 divide_compensated(vec2 a, vec2 b) {
    precise float quotient = a.x / b.x;
    vec2 product = two_product(quotient, b.x);
    precise float remainder = ((a.x - product.x) - product.y) + (a.y - quotient * b.y);
    precise float error = remainder / b.x;
    return fast_two_sum(quotient, error);
}

// a b - c d to nearly full precision, where the difference of the rounded products would have lost it.
float difference_of_products(float a, float b, float c, float d) {
    vec2 ab = two_product(a, b);
    vec2 cd = two_product(c, d);
    precise float difference = (ab.x - cd.x) + (ab.y - cd.y);
    return difference;
}

// sin(x) with its rounding error for |x| <= pi/2: absolute error 1e-9.
vec2 sin_compensated(float x) {
    // Taylor to the 13th degree; 1/6 and 1/120 in two parts.
    vec2 z = two_product(x, x);
    float p = 1.0 / 5040.0 - z.x * (1.0 / 362880.0 - z.x * (1.0 / 39916800.0 - z.x * (1.0 / 6227020800.0)));
    vec2 q = add_compensated(vec2(0.008333334, -4.346172e-10), vec2(-z.x * p, 0.0));
    q = add_compensated(vec2(0.16666667, -4.967054e-09), -multiply_compensated(z, q));
    return add_compensated(vec2(x, 0.0), -multiply_compensated(vec2(x, 0.0), multiply_compensated(z, q)));
}
