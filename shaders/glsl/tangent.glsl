// The tangent frame of a surface without texture coordinates.

// Columns: tangent, bitangent, normal. The tangent runs around the vertical axis, as the parallels of a globe do.
mat3 tangent_frame(vec3 n) {
    vec3 tangent = abs(n.y) < 0.99999 ? normalize(vec3(n.z, 0.0, -n.x)) : vec3(1.0, 0.0, 0.0);
    return mat3(tangent, cross(n, tangent), n);
}
