// Directions drawn at random about a normal.
//
// Whoever includes this includes camera.glsl before it.

// `v` turned as the half turn does that takes s = (2, 3, 6) / 7 to unit vector n. No way to turn vectors is continuous in
// all n, nor is this one about -s; but that is a normal of hardly anything, while those of walls lie along the axes, where
// rounding decides about the signs of zeros.
vec3 turned(vec3 v, vec3 n) {
    precise vec3 axis = n + vec3(0.285714286f, 0.428571429f, 0.857142857f);
    precise float square = dot(axis, axis);
    precise float along = 2.0f * dot(v, axis) / square;
    precise vec3 result = along * axis - v;
    return square > 1e-6f ? result : -v;
}

// The unit vector with components x, y and z along three axes that are perpendicular to each other, the last of them n.
vec3 aboutNormal(vec3 n, vec3 v) {
    precise vec3 seventh = vec3(3.0f * v.x + 6.0f * v.y + 2.0f * v.z, 2.0f * v.y - 6.0f * v.x + 3.0f * v.z,
                                2.0f * v.x - 3.0f * v.y + 6.0f * v.z);
    precise vec3 result = seventh * 0.142857143f;
    return unit(turned(result, n));
}

// The other way: the components of v.
vec3 alongNormal(vec3 n, vec3 v) {
    vec3 t = turned(v, n);
    precise vec3 seventh = vec3(3.0f * t.x - 6.0f * t.y + 2.0f * t.z, 6.0f * t.x + 2.0f * t.y - 3.0f * t.z,
                                2.0f * t.x + 3.0f * t.y + 6.0f * t.z);
    precise vec3 result = seventh * 0.142857143f;
    return result;
}

// A unit vector whose density, by solid angle, is its cosine to n over pi, for a point of the unit square: that of the disk,
// raised to the hemisphere [Malley 1988, "A Shading Method for Computer Generated Images"].
vec3 cosineDirection(vec3 n, vec2 square) {
    vec2 disk = diskOf(square);
    precise float height = sqrt(max(0.0f, 1.0f - disk.x * disk.x - disk.y * disk.y));
    return aboutNormal(n, vec3(disk.x, disk.y, height));
}
