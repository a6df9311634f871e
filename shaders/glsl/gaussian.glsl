// The Gaussian distribution of facet angles, normalised and with its own masking. The twin of this file is
// brdf/gaussian.py, which holds the references and makes the tables gaussian_norm and gaussian_masking.

#include "common.glsl"
#include "distributions.glsl"
#include "elementary.glsl"
#include "half_vector.glsl"

// Below this tan^2 the series of arctan is exact in float32, and above it the angle has no leading 1 to lose digits to.
const float ARCTAN_SERIES_MAX = 0.03;
// The table reaches 5 alpha above the horizon for small slopes.
const float GAUSSIAN_REACH = 5.0;

// tanh(x) for x >= 0.
float tanh_accurate(float x) {
    if (x < 0.1) {
        return x * (1.0 - x * x * (1.0 / 3.0 - x * x * (2.0 / 15.0 - x * x * (17.0 / 315.0))));
    }
    float e = exp_accurate(-2.0 * min(x, 40.0), 0.0);
    return (1.0 - e) / (1.0 + e);
}

float elevation_max(float alpha) {
    return 0.5 * PI * tanh_accurate(GAUSSIAN_REACH / (0.5 * PI) * alpha);
}

float gaussian_norm_elliptic(float alpha_x, float alpha_y) {
    float total = 0.0;
    for (int i = 0; i < 2 * ELLIPSE_HALF; i++) {
        vec2 point = ellipse_point(i, alpha_x, alpha_y);
        total += point.y * gaussian_norm(point.x);
    }
    return total;
}

// The density of normals in 1/sr as two factors, as d_beckmann; beside the normal the exponent is Beckmann's times
// (theta / tan theta)^2 = (1 - small)^2, carried with its rounding error.
vec2 d_gaussian(Geometry g, float alpha_x, float alpha_y, float norm) {
    HalfSlopes t = half_slopes(g);
    float x = (g.h_x * g.h_x + g.h_y * g.h_y) / (g.h_z * g.h_z);
    vec2 ratio;
    if (x < ARCTAN_SERIES_MAX) {
        ratio = two_sum(1.0, -x * (1.0 / 3.0 - x * (1.0 / 5.0 - x * (1.0 / 7.0 - x * (1.0 / 9.0)))));
    } else {
        float far = sqrt(g.h_x * g.h_x + g.h_y * g.h_y);
        ratio = vec2(atan_quadrant(far, g.h_z) * (g.h_z / far), 0.0);
    }
    vec2 t_x = divide_compensated(multiply_compensated(t.x, ratio), vec2(alpha_x, 0.0));
    vec2 t_y = divide_compensated(multiply_compensated(t.y, ratio), vec2(alpha_y, 0.0));
    vec2 decay = exp_halves(add_compensated(multiply_compensated(t_x, t_x), multiply_compensated(t_y, t_y)));
    return vec2(decay.x / (PI * alpha_x * alpha_y * norm), decay.y);
}

// The slope in the plane of a direction, from alpha_sin2.
float seen_slope(float cos_theta, float alpha_sin2) {
    float sin2 = (1.0 - cos_theta) * (1.0 + cos_theta);
    return sin2 > 1e-30 ? min(sqrt(alpha_sin2 / sin2), 1.0) : 1.0;
}

// cos(theta) Lambda(theta): exact for equal slopes, for unequal ones with the seen_slope of the direction.
float cos_lambda_gaussian(float cos_theta, float alpha) {
    float sin2 = (1.0 - cos_theta) * (1.0 + cos_theta);
    float elevation = atan_quadrant(cos_theta, sqrt(max(sin2, 0.0)));
    float ratio = elevation / alpha;
    if (sin2 <= 1e-30 || ratio * ratio >= 87.0) {
        return 0.0;
    }
    float u = min(elevation / elevation_max(alpha), 1.0);
    return alpha * exp_accurate(-ratio * ratio, 0.0) * gaussian_masking(u, alpha);
}
