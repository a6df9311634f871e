// Texels of a cube map in compute shaders.

// The direction of a place on a face, both coordinates from -1 to 1 (OpenGL 4.3, table 8.18).
vec3 cube_direction(int face, vec2 at) {
    if (face == 0) { return vec3(1.0, -at.y, -at.x); }
    if (face == 1) { return vec3(-1.0, -at.y, at.x); }
    if (face == 2) { return vec3(at.x, 1.0, at.y); }
    if (face == 3) { return vec3(at.x, -1.0, -at.y); }
    if (face == 4) { return vec3(at.x, -at.y, 1.0); }
    return vec3(-at.x, -at.y, -1.0);
}
