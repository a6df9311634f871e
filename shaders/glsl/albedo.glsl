// The directional albedo of materials, as pass/albedo.comp has left it: COSINES viewers by the square root of cos_o, for
// each of AZIMUTHS directions around.

#include "common.glsl"

layout(std430, binding = 2) readonly buffer Albedos { vec4 albedos[]; };

// Between four neighbours; `first` is the part's first viewer.
vec3 albedo_between(int first, vec3 wo) {
    float x = sqrt(clamp(wo.z, 0.0, 1.0)) * float(COSINES - 1);
    int column = min(int(x), COSINES - 2);
    x -= float(column);
#if AZIMUTHS == 1
    return mix(albedos[first + column].rgb, albedos[first + column + 1].rgb, x);
#else
    float turns = atan(wo.y, abs(wo.x) + abs(wo.y) > 0.0 ? wo.x : 1.0) / (2.0 * PI);
    float y = fract(turns) * float(AZIMUTHS);
    int row = min(int(y), AZIMUTHS - 1);
    y -= float(row);
    int here = first + row * COSINES + column;
    int next = first + (row + 1 < AZIMUTHS ? row + 1 : 0) * COSINES + column;
    return mix(mix(albedos[here].rgb, albedos[here + 1].rgb, x), mix(albedos[next].rgb, albedos[next + 1].rgb, x), y);
#endif
}
