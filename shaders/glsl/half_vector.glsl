// The slopes of the half vector with their rounding errors: what an exponential multiplies by its exponent must not
// start from rounded numbers.

#include "common.glsl"
#include "compensated.glsl"
#include "elementary.glsl"

// exp(-170) = 1e-74 is zero in float32, times anything that a lobe multiplies it with.
const float DECAY_MAX = 170.0;

// h_x / h_z and h_y / h_z, each with its rounding error.
struct HalfSlopes {
    vec2 x;
    vec2 y;
};

HalfSlopes half_slopes(Geometry g) {
    vec2 h_z = vec2(g.h_z, g.h_low.z);
    vec2 t_x = divide_compensated(vec2(g.h_x, g.h_low.x), h_z);
    vec2 t_y = divide_compensated(vec2(g.h_y, g.h_low.y), h_z);
    return HalfSlopes(t_x, t_y);
}

// exp(-x) as two equal factors: their product may lie below float32's range where a lobe, a large number times it, does
// not.
vec2 exp_halves(vec2 x) {
    if (x.x >= DECAY_MAX) {
        return vec2(0.0);
    }
    return vec2(exp_accurate(-0.5 * x.x, -0.5 * x.y));
}
