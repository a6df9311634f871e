// A peer: the split sum as textbooks have it.
//
// - Karis 2013, "Real Shading in Unreal Engine 4".
// - Lagarde 2012, "Spherical Gaussian approximation for Blinn-Phong, Phong and Fresnel" and its sequels: Fresnel's term
//   with roughness.

// A visible point whose interpolated normal turns away from the viewer is shaded as if seen at this cosine.
const float COS_O_MIN = 1e-4;

in vec3 world_position;
in vec3 world_normal;

uniform vec3 camera_position;
uniform mat3 world_to_environment;
uniform samplerCube irradiance;
uniform samplerCube prefiltered;
uniform sampler2D dfg;
uniform vec3 albedo;
uniform vec3 f0;
uniform float roughness;
uniform float level_max;

out vec4 color;

vec3 fresnel_schlick_roughness(float cos_o) {
    return f0 + (max(vec3(1.0 - roughness), f0) - f0) * pow(1.0 - cos_o, 5.0);
}

void main() {
    vec3 n = normalize(world_normal);
    vec3 v = normalize(camera_position - world_position);
    float cos_o = clamp(dot(n, v), COS_O_MIN, 1.0);
    vec3 mirrored = world_to_environment * (2.0 * cos_o * n - v);
    vec3 diffuse = albedo * texture(irradiance, world_to_environment * n).rgb;
    vec2 scale_bias = texture(dfg, vec2(cos_o, roughness)).rg;
    vec3 blurred = textureLod(prefiltered, mirrored, roughness * level_max).rgb;
    color = vec4(diffuse + blurred * (fresnel_schlick_roughness(cos_o) * scale_bias.x + scale_bias.y), 1.0);
}
