// Where an instance puts what is in its mesh: one formula in single precision for whoever writes instances out and for
// whoever places them while tracing. So both have the same vertices, to the bit.
#ifndef RAIG_SHARED_PLACE
#define RAIG_SHARED_PLACE

// A transform, row by row: a point's new x is dot(x.xyz, point) + x.w. Rounded once from double precision.
struct Placement {
    vec4 x;
    vec4 y;
    vec4 z;
};

// What normals are multiplied by, row by row: the transform's cofactors, turned so that outside stays outside, and scaled so
// that the largest has magnitude [1, 2). Only the direction matters, and cofactors have it even where no inverse exists.
struct NormalPlacement {
    vec3 x;
    vec3 y;
    vec3 z;
};

// The place of a point. The identity returns the point itself (but +0 for -0). With A = |x.x p.x| + |x.y p.y| + |x.z p.z| +
// |x.w|, a component is off by less than 4.01 u A, u = 2^-24: each product is rounded at most four times, with the sums it
// is part of.
SHARED_FUNCTION vec3 placePoint(Placement m, vec3 p) {
    precise float x = ((m.x.x * p.x + m.x.y * p.y) + m.x.z * p.z) + m.x.w;
    precise float y = ((m.y.x * p.x + m.y.y * p.y) + m.y.z * p.z) + m.y.w;
    precise float z = ((m.z.x * p.x + m.z.y * p.y) + m.z.z * p.z) + m.z.w;
    return vec3(x, y, z);
}

// (x, y, z) made unit length, wherever its largest component lies between 2^-100 and `most`; else zero.
SHARED_FUNCTION vec3 placedDirection(float x, float y, float z, float most) {
    float largest = abs(x) > abs(y) ? abs(x) : abs(y);
    largest = abs(z) > largest ? abs(z) : largest;
    bool sound = largest >= 7.8886091e-31f && largest <= most;  // false for NaN
    // Brought to [1, 2) by a power of two, so that no square vanishes.
    uint exponent = floatBitsToUint(sound ? largest : 1.0f) & 0x7f800000u;
    float scale = uintBitsToFloat(0x7f000000u - exponent);
    precise vec3 scaled = vec3(x, y, z) * scale;
    precise float square = (scaled.x * scaled.x + scaled.y * scaled.y) + scaled.z * scaled.z;
    precise vec3 unit_ = scaled / sqrt(sound ? square : 1.0f);
    return sound ? unit_ : vec3(0.0f);
}

// The unit direction that `tangent`'s first three (unit, or zero) become; zero if that is none.
SHARED_FUNCTION vec3 placeTangent(Placement m, vec4 tangent) {
    precise float x = (m.x.x * tangent.x + m.x.y * tangent.y) + m.x.z * tangent.z;
    precise float y = (m.y.x * tangent.x + m.y.y * tangent.y) + m.y.z * tangent.z;
    precise float z = (m.z.x * tangent.x + m.z.y * tangent.y) + m.z.z * tangent.z;
    return placedDirection(x, y, z, 1.2676506e30f);
}

// The unit normal that `normal` (unit, or zero) becomes; zero if that is none, or if the transform leaves it no direction.
SHARED_FUNCTION vec3 placeNormal(NormalPlacement m, vec3 normal) {
    precise float x = (m.x.x * normal.x + m.x.y * normal.y) + m.x.z * normal.z;
    precise float y = (m.y.x * normal.x + m.y.y * normal.y) + m.y.z * normal.z;
    precise float z = (m.z.x * normal.x + m.z.y * normal.y) + m.z.z * normal.z;
    return placedDirection(x, y, z, 16.0f);
}

#endif
