// Leaves nothing but the depth.

void main() {}
