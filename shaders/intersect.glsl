// One ray against one box or triangle, in single precision: what every structure's walk is made of.
//
// Everything that decides a hit is `precise`, so that it is the same sequence of roundings on every device and on the CPU.
// u = 2^-24 below is half an ULP of 1.

// Magnitudes up to which squared distances stay finite.
CONSTANT float LARGEST_COORDINATE = 1.844e18f;
CONSTANT float SMALLEST_NORMAL = 1.17549435e-38f;
CONSTANT float LARGEST_FLOAT = 3.4028234e38f;

// A ray made ready for walking, in the structure's own unit of length. The direction is scaled by a power of two so that its
// largest component has magnitude [1, 2) (below 4 at the top of the range). Both are exact, and so is it for distances.
struct WalkRay {
    vec3 origin;
    float tMin;
    vec3 direction;
    vec3 inverse;   // 1 / direction, where components below 2^-27 of the largest count as that (never infinite)
    float tMax;
    vec3 reach;     // |inverse| times SLACK
    float tolerance;  // SLACK / 4
    vec2 shear;     // direction.(x,y) / direction.z, in the axes below
    float inverseZ;
    uint axisZ;     // the axis of the largest direction component; x and y follow it cyclically
    float scale;    // of the direction
    bool valid;
};

bool isWithin(vec3 v, float limit) {
    // False for NaN.
    return abs(v.x) <= limit && abs(v.y) <= limit && abs(v.z) <= limit;
}

// Both sides evaluated, and no branch: `?:` of other than names branches, and drivers take long over many branches. (That of
// SwiftShader takes twice as long with each one more that follows others in a loop.)
float pick(bool first, float a, float b) { return mix(b, a, first); }
uint pick(bool first, uint a, uint b) { return mix(b, a, first); }
vec3 pick(bool first, vec3 a, vec3 b) { return mix(b, a, bvec3(first, first, first)); }
uvec4 pick(bool first, uvec4 a, uvec4 b) { return mix(b, a, bvec4(first, first, first, first)); }

vec3 turned(vec3 v, uint axisZ) {
    return pick(axisZ == 2u, v, pick(axisZ == 0u, vec3(v.y, v.z, v.x), vec3(v.z, v.x, v.y)));
}

// Components too small to move the ray by u M / 8 across the scene are replaced by one that just does not: the inverse
// stays finite, no 0 * inf arises, and what it changes is far below the slack. Keeps the sign, that of a zero too.
float steep(float component, float largest) {
    float least = largest * 7.450580596923828e-9f;  // 2^-27
    float sign = (floatBitsToUint(component) >> 31) != 0u ? -1.0f : 1.0f;
    return pick(abs(component) < least, sign * least, component);
}

// 1 / p of a power of two, by its exponent: exact where division may not be.
float inverseOfPower(float p) { return uintBitsToFloat((254u << 23) - floatBitsToUint(p)); }

// A distance along the ray as given, as one inside a walk; and back. One factor after the other: their product may be out of
// range where what it is needed for is not.
float distanceInside(WalkRay ray, float unit, float t) {
    precise float scaled = t * inverseOfPower(ray.scale);
    precise float result = scaled * unit;
    return result;
}

float distanceOutside(WalkRay ray, float unit, float t) {
    precise float scaled = t * inverseOfPower(unit);
    precise float result = scaled * ray.scale;
    return result;
}

// The axis of the largest component, and its magnitude.
float findMainAxis(vec3 direction, INOUT(uint) axis) {
    vec3 size = vec3(abs(direction.x), abs(direction.y), abs(direction.z));
    bool zLargest = size.z >= size.x && size.z >= size.y;
    axis = zLargest ? 2u : (size.x >= size.y ? 0u : 1u);
    return zLargest ? size.z : (size.x >= size.y ? size.x : size.y);
}

// M: the largest distance along an axis from `origin` to the bounds.
float distanceToBounds(vec3 origin, vec3 lo, vec3 hi) {
    precise vec3 toLo = lo - origin;
    precise vec3 toHi = hi - origin;
    float m = abs(toLo.x);
    m = abs(toLo.y) > m ? abs(toLo.y) : m;
    m = abs(toLo.z) > m ? abs(toLo.z) : m;
    m = abs(toHi.x) > m ? abs(toHi.x) : m;
    m = abs(toHi.y) > m ? abs(toHi.y) : m;
    m = abs(toHi.z) > m ? abs(toHi.z) : m;
    return m;
}

// What follows from a ray's direction, whose largest component is `largest`, and its slack, 1/64 of which is `slackUnit`.
void completeRay(INOUT(WalkRay) r, float largest, float slackUnit) {
    precise vec3 inverse = vec3(1.0f / steep(r.direction.x, largest), 1.0f / steep(r.direction.y, largest),
                                1.0f / steep(r.direction.z, largest));
    r.inverse = inverse;
    precise vec3 reach = vec3(abs(inverse.x), abs(inverse.y), abs(inverse.z)) * (slackUnit * 64.0f);
    r.reach = reach;
    r.tolerance = slackUnit * 16.0f;

    vec3 d = turned(r.direction, r.axisZ);
    precise vec2 shear = vec2(d.x / d.z, d.y / d.z);
    precise float inverseZ = 1.0f / d.z;
    r.shear = shear;
    r.inverseZ = inverseZ;
}

// Makes a ray ready. `lo` and `hi` bound the scene in its unit.
//
// SLACK is 64 u M, M the largest distance along an axis from the ray's origin to the scene's bounds. The shear of a
// triangle's corners misplaces them against the ray by 11 u M along each axis (three roundings a corner of magnitudes up to
// 2 M, three of the slope), the place in the triangle by 18 u M and what is let pass by 17 u M more, the distance by 4 u M:
// 53 u M is what walks count on. (All with the distance m of the triangle itself in place of M, which is not less:
// differences round alike.) A slab takes 6 u M (three roundings). So boxes are widened by it: a ray that meets a triangle,
// as rounded, meets its box, as rounded, where it does.
// And so with spheres, whose hits lie within 53 u M of their surfaces (sphere.glsl).
WalkRay prepareRay(Ray ray, vec3 lo, vec3 hi, float unit) {
    WalkRay r;
    float largest = findMainAxis(ray.direction, r.axisZ);
    precise vec3 origin = ray.origin * unit;
    r.valid = isWithin(ray.origin, LARGEST_COORDINATE) && isWithin(origin, LARGEST_COORDINATE) &&
              isWithin(ray.direction, LARGEST_FLOAT) && largest >= SMALLEST_NORMAL && ray.tMax >= 0.0f &&
              ray.tMin <= ray.tMax;

    uint exponent = r.valid ? floatBitsToUint(largest) >> 23 : 127u;
    exponent = exponent > 253u ? 253u : exponent;
    r.scale = uintBitsToFloat((254u - exponent) << 23);
    precise vec3 direction = r.valid ? ray.direction * r.scale : vec3(1.0f);
    largest = r.valid ? largest * r.scale : 1.0f;
    r.origin = r.valid ? origin : vec3(0.0f);
    r.tMin = ray.tMin > 0.0f ? distanceInside(r, unit, ray.tMin) : 0.0f;
    r.tMax = distanceInside(r, unit, ray.tMax);

    r.direction = direction;
    precise float slackUnit = distanceToBounds(r.origin, lo, hi) * 5.9604644775390625e-8f;  // M u
    completeRay(r, largest, slackUnit);
    return r;
}

// Which octant a prepared ray's direction lies in: bit a is set if it is negative along axis a (-0 is).
uint octantOf(WalkRay ray) {
    return (floatBitsToUint(ray.inverse.x) >> 31) | ((floatBitsToUint(ray.inverse.y) >> 31) << 1) |
           ((floatBitsToUint(ray.inverse.z) >> 31) << 2);
}

// The larger and the smaller of two floats by their bits: right if at least one is not negative (else: one of the two), and
// one instruction where float min and max are several.
float maxOf(float a, float b) { return intBitsToFloat(max(floatBitsToInt(a), floatBitsToInt(b))); }

float minOf(float a, float b) { return intBitsToFloat(min(floatBitsToInt(a), floatBitsToInt(b))); }

// The same for floats of any sign, none of them NaN.
float greater(float a, float b) { return pick(a > b, a, b); }
float lesser(float a, float b) { return pick(a < b, a, b); }

// True if the ray meets the box between its near and its far planes (each already chosen by the direction's signs) at some
// distance in [tMin, tMax]. Requires tMin >= 0. Monotonic: whatever meets a box meets every box around it.
// Source: Williams et al. 2005, "An Efficient and Robust Ray-Box Intersection Algorithm"; the slack replaces Ize 2013.
bool hitsPlanes(WalkRay ray, vec3 near, vec3 far, float tMax) {
    precise vec3 enter = (near - ray.origin) * ray.inverse - ray.reach;
    precise vec3 leave = (far - ray.origin) * ray.inverse + ray.reach;
    float first = maxOf(maxOf(enter.x, enter.y), maxOf(enter.z, ray.tMin));
    float last = minOf(minOf(leave.x, leave.y), minOf(leave.z, tMax));
    return first <= last;
}

// The ray against triangle (a, b, c), both sides. If it meets it at a distance t in [ray.tMin, best.t], nearer than best or
// as near with a lower id, and the triangle counts as an obstacle, then best becomes that hit, and the result is true.
//
// Ensures   Watertight: the edge functions of two triangles that share an edge are exact negatives of each other, and a sign
//           is right or the value is zero, which counts as inside. So a ray meets at least one of the triangles around any
//           edge or vertex. A ray in the triangle's plane does not meet it.
//           The point at distance t lies within 53 u m of the triangle itself along each axis, m <= M the largest distance
//           along an axis from the ray's origin to its corners, however edge-on it is seen: barycentric coordinates out of
//           the edge functions would be noise there. So a walk finds the triangle in any box, cell or half-space, widened by
//           the slack, that holds the part of it where it is hit.
// How       With the ray as the origin and z along it, the line x = 0 cuts two edges that meet in a corner p, at (y1, z1)
//           and (y2, z2); the hit lies between the two, at y = 0. Each quotient is of differences of like sign, so it is
//           right to two roundings, and its product to four: 4 u |dy|, dy the extent of the edge along y. Where the edge
//           functions' signs are those of exact arithmetic, y = 0 lies between y1 and y2 but for that: this much, and no
//           more, is let pass (and what products below the range of normal floats may lose). As |dy| <= 4 m it is 16.25 u m,
//           and what roundings misplace y1 or y2 by is 18 u m.
// Source    Woop, Benthin, Wald 2013, "Watertight Ray/Triangle Intersection", for the edge functions, without its fallback
//           to double precision.
bool intersectTriangle(WalkRay ray, vec3 a, vec3 b, vec3 c, uint id, bool obstacle, INOUT(Hit) best) {
    precise vec3 toA = a - ray.origin;
    precise vec3 toB = b - ray.origin;
    precise vec3 toC = c - ray.origin;
    vec3 A = turned(toA, ray.axisZ);
    vec3 B = turned(toB, ray.axisZ);
    vec3 C = turned(toC, ray.axisZ);
    precise float aX = A.x - ray.shear.x * A.z;
    precise float aY = A.y - ray.shear.y * A.z;
    precise float bX = B.x - ray.shear.x * B.z;
    precise float bY = B.y - ray.shear.y * B.z;
    precise float cX = C.x - ray.shear.x * C.z;
    precise float cY = C.y - ray.shear.y * C.z;
    precise float edgeA = cX * bY - cY * bX;
    precise float edgeB = aX * cY - aY * cX;
    precise float edgeC = bX * aY - bY * aX;
    precise float area = edgeA + edgeB + edgeC;
    bool positive = edgeA >= 0.0f && edgeB >= 0.0f && edgeC >= 0.0f;
    bool negative = edgeA <= 0.0f && edgeB <= 0.0f && edgeC <= 0.0f;

    // Which corners lie on the left of x = 0; those on it do, where no other does. p is alone on its side.
    bool none = aX >= 0.0f && bX >= 0.0f && cX >= 0.0f;
    bool leftA = aX < 0.0f || (none && aX == 0.0f);
    bool leftB = bX < 0.0f || (none && bX == 0.0f);
    bool leftC = cX < 0.0f || (none && cX == 0.0f);
    bool cut = leftA != leftB || leftA != leftC;
    bool pIsC = leftA == leftB;
    bool pIsB = leftA == leftC && !pIsC;
    A = vec3(aX, aY, A.z);
    B = vec3(bX, bY, B.z);
    C = vec3(cX, cY, C.z);
    vec3 p = pick(pIsC, C, pick(pIsB, B, A));
    vec3 q = pick(pIsC, A, pick(pIsB, C, B));
    vec3 r = pick(pIsC, B, pick(pIsB, A, C));
    precise float toQ = p.x / (p.x - q.x);
    precise float toR = p.x / (p.x - r.x);
    precise float dyQ = q.y - p.y;
    precise float dyR = r.y - p.y;
    precise float y1 = p.y + toQ * dyQ;
    precise float y2 = p.y + toR * dyR;
    precise float z1 = p.z + toQ * (q.z - p.z);
    precise float z2 = p.z + toR * (r.z - p.z);
    precise float apart = y1 - y2;
    precise float across = y1 / (apart == 0.0f ? 1.0f : apart);
    across = apart == 0.0f || across < 0.0f ? 0.0f : across;
    across = across > 1.0f ? 1.0f : across;
    precise float tolerance = maxOf(abs(dyQ), abs(dyR)) * 2.421438694000244e-7f + SMALLEST_NORMAL;  // 4.0625 u
    bool spans = (y1 <= tolerance || y2 <= tolerance) && (y1 >= -tolerance || y2 >= -tolerance);
    bool inside = (positive || negative) && abs(area) >= SMALLEST_NORMAL && cut && spans;

    precise float z = z1 + across * (z2 - z1);
    precise float t = z * ray.inverseZ;
    precise float ofQ = toQ - across * toQ;
    precise float ofR = across * toR;
    precise float rest = 1.0f - ofQ - ofR;
    float ofP = rest < 0.0f ? 0.0f : rest;
    float u = pick(pIsC, ofR, pick(pIsB, ofP, ofQ));
    float v = pick(pIsC, ofP, pick(pIsB, ofQ, ofR));
    bool nearer = t < best.t || (t == best.t && id < best.primitive);
    bool better = inside && obstacle && t >= ray.tMin && nearer;
    best.t = better ? t : best.t;
    best.u = better ? u : best.u;
    best.v = better ? v : best.v;
    best.primitive = better ? id : best.primitive;
    return better;
}
