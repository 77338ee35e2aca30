// Points on triangles with a bound on their rounding error, and rays that leave them from just outside that bound.

// A point of a surface. The exact point of the triangle's plane lies within `error` of `position` in each component.
struct BoundedPoint {
    vec3 position;
    vec3 error;
};

// v / |v|. Requires v != 0 with a square that neither overflows nor vanishes.
vec3 unit(vec3 v) {
    precise vec3 result = v / sqrt(dot(v, v));
    return result;
}

float largestOf(vec3 v) { return max(v.x, max(v.y, v.z)); }

// The power of two that brings the greatest component of v into [1, 2): multiplying by it rounds nothing.
float unitScale(vec3 v) {
    uint exponent = floatBitsToUint(largestOf(abs(v))) & 0x7f800000u;
    return uintBitsToFloat(0x7f000000u - exponent);
}

// The unit normal of triangle (a, b, c) on the side from which a, b, c run counterclockwise, whatever its size: the edges
// are brought to unit scale first. `fallback` for a sliver whose edges are parallel in floats.
vec3 faceNormal(vec3 a, vec3 b, vec3 c, vec3 fallback) {
    precise vec3 ab = b - a;
    precise vec3 ac = c - a;
    precise vec3 e = ab * unitScale(ab);
    precise vec3 f = ac * unitScale(ac);
    precise vec3 normal = vec3(e.y * f.z - e.z * f.y, e.z * f.x - e.x * f.z, e.x * f.y - e.y * f.x);
    precise vec3 scaled = normal * unitScale(normal);
    bool flat_ = normal.x == 0.0f && normal.y == 0.0f && normal.z == 0.0f;
    return flat_ ? fallback : unit(scaled);
}

// b0 a + b1 b + b2 c and its error bound, gamma(7) (|b0 a| + |b1 b| + |b2 c|) with gamma(n) = n u / (1 - n u), u = 2^-24
// [Pharr, Jakob and Humphreys 2023, "Physically Based Rendering", section 6.8].
BoundedPoint pointOf(vec3 a, vec3 b, vec3 c, float b0, float b1, float b2) {
    precise vec3 position = b0 * a + b1 * b + b2 * c;
    precise vec3 error = 4.1723272e-7f * (abs(b0 * a) + abs(b1 * b) + abs(b2 * c));
    return BoundedPoint(position, error);
}

// The next float after x in the direction of the sign of `towards`; x itself where that is 0. From zero it goes to the
// smallest normal number, as some devices take lesser ones for zero.
float nextFloat(float x, float towards) {
    uint bits = floatBitsToUint(x);
    bool grows = (x > 0.0f) == (towards > 0.0f);
    uint next = x == 0.0f ? (towards > 0.0f ? 0x00800000u : 0x80800000u) : (grows ? bits + 1u : bits - 1u);
    return towards == 0.0f ? x : uintBitsToFloat(next);
}

// Where a ray starts that leaves `point` on the side of unit vector n: outside the error box, whatever the rounding.
//
// Ensures   the plane of the triangle lies behind it; no ray that stays on n's side meets that triangle again.
//           It is within some 8 ULP of the point's largest coordinate, so that no gap wider than that is jumped.
// Source    Pharr, Jakob and Humphreys 2023, section 6.8.6; there is no epsilon that depends on the scene.
vec3 spawnOrigin(BoundedPoint point, vec3 n) {
    precise float distance_ = dot(abs(n), point.error);
    precise vec3 offset = distance_ * n;
    precise vec3 moved = point.position + offset;
    return vec3(nextFloat(moved.x, offset.x), nextFloat(moved.y, offset.y), nextFloat(moved.z, offset.z));
}
