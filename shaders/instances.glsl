// The upper of two levels: which instances a ray meets, and the ray in each one's own space.
//
// Only bounds are walked there. A triangle is placed in the world, corner by corner, by the formula that whoever writes out
// instances uses (shared/place.glsl), and tested with the ray as it is: so hits are those of the scene written out, to the
// bit, and watertight where that is.
//
// Whoever includes this declares before it: INSTANCED, header, storedNodes_at(i), nodeBase, triangleBase; and includes
// intersect.glsl and shared/place.glsl.

// Where the walk of a bottom is: what testing its triangles needs.
struct Inside {
    WalkRay ray;        // in the world
    Hit best;           // of all instances, in the world
    Placement placement;
    uint firstId;       // the id of the bottom's triangle 0
    bool mirrored;
    float toLocal;      // a distance along `ray`, times this, is one along the ray in the bottom's space: a power of two
};

Inside inside;

vec3 placedFloats(uvec4 t) { return vec3(uintBitsToFloat(t.x), uintBitsToFloat(t.y), uintBitsToFloat(t.z)); }

vec4 placedRow(uvec4 t) { return vec4(placedFloats(t), uintBitsToFloat(t.w)); }

// The ray `world` in a bottom's space. `n` are the rows of the instance's inverse, with the corner in .w; `at` is where that
// corner is in the world; `spread` the largest sum of a row's magnitudes; `blur` see below.
//
// A point of the ray at distance t goes, in exact arithmetic, from P = o + t d to corner + N (P - at). The walk's ray is off
// from that by what rounds on the way (u = 2^-24; M as in prepareRay, for the world: so much |o - at| and t |d| are at most,
// along each axis, where something is hit; R = spread):
//      5 u M R    of N (o - at): rounding of N, of the difference, of products and sums; and of the last sum,
//                 u (M R + |corner|)
//      4 u M R    of t N d
//     u |corner|  of the corner
// A hit in the world lies within 53 u M of the placed triangle (bsp.glsl counts that), which is 53 u M R here; and the
// placed triangle within 4.01 u A of where it exactly would be (shared/place.glsl), which is 4.01 u |N| A here. In all
//     u (63 M R + 2 |corner| + 4.01 |N| A)
// by which the ray passes the bottom's triangle where it hits. Walks reckon with 53 u m for that, m the distance to the
// bottom's bounds, and with other multiples of u m for their own roundings. So with
//     slack / 64 = u (m + 1.3125 M R + blur),    blur = (2 |corner| + 4.01 |N| A) / 53, rounded up
// in place of u m, all that they count on holds.
//
// Where that is as much as the bottom itself is large (rays from very far away, or out of range), a ray that meets
// everything stands in.
WalkRay placedRay(WalkRay world, vec4 n0, vec4 n1, vec4 n2, vec3 at, float spread, float blur, INOUT(float) toLocal) {
    precise vec3 away = world.origin - at;
    precise vec3 origin = vec3(((n0.x * away.x + n0.y * away.y) + n0.z * away.z) + n0.w,
                               ((n1.x * away.x + n1.y * away.y) + n1.z * away.z) + n1.w,
                               ((n2.x * away.x + n2.y * away.y) + n2.z * away.z) + n2.w);
    vec3 d = world.direction;
    precise vec3 along = vec3((n0.x * d.x + n0.y * d.y) + n0.z * d.z, (n1.x * d.x + n1.y * d.y) + n1.z * d.z,
                              (n2.x * d.x + n2.y * d.y) + n2.z * d.z);
    WalkRay r;
    float m = distanceToBounds(origin, header.lo, header.hi);
    precise float slackUnit =
        m * 5.9604644775390625e-8f + spread * world.tolerance * 0.08203125f + blur * 5.9604644775390625e-8f;
    bool meetsAll = !(slackUnit <= 1.0f);  // of bounds that are 4 wide at most; NaN too
    slackUnit = meetsAll ? 1.0f : slackUnit;
    along = meetsAll ? vec3(1.0f) : along;
    r.origin = meetsAll ? header.lo : origin;
    float largest = findMainAxis(along, r.axisZ);
    uint exponent = floatBitsToUint(largest) >> 23;
    exponent = exponent > 253u ? 253u : (exponent < 1u ? 1u : exponent);
    r.scale = uintBitsToFloat((254u - exponent) << 23);
    precise vec3 direction = along * r.scale;
    r.direction = direction;
    toLocal = meetsAll ? 0.0f : inverseOfPower(r.scale);
    r.tMin = meetsAll ? 0.0f : world.tMin * toLocal;
    r.tMax = meetsAll ? 1.0f : world.tMax * toLocal;
    r.valid = true;
    completeRay(r, largest * r.scale, slackUnit);
    return r;
}

// How far the walk of a bottom needs to look: the best hit's distance there.
float localDistance(float t) { return inside.toLocal > 0.0f ? t * inside.toLocal : 1.0f; }

// Makes the bottom whose record lies at `at` the one that is walked: its header, nodes and references.
void enterBottom(uint at) {
    uvec4 h0 = storedNodes_at(at);
    uvec4 h1 = storedNodes_at(at + 1u);
    uvec4 h2 = storedNodes_at(at + 2u);
    uvec4 h3 = storedNodes_at(at + 3u);
    uvec4 bases = storedNodes_at(at + 4u);
    header.lo = placedFloats(h0);
    header.nodeCount = h0.w;
    header.hi = placedFloats(h1);
    header.triangleCount = h1.w;
    header.gridOrigin = placedFloats(h2);
    header.walk = h2.w;
    header.gridStep = placedFloats(h3);
    header.unit = uintBitsToFloat(h3.w);
    nodeBase = bases.x;
    triangleBase = bases.y;
}

// Goes into instance `index`, and its bottom. Returns the ray in its space.
WalkRay enterInstance(uint index, uint instancesAt) {
    uint at = instancesAt + index * INSTANCE_STRIDE;
    inside.placement = Placement(placedRow(storedNodes_at(at)), placedRow(storedNodes_at(at + 1u)),
                                 placedRow(storedNodes_at(at + 2u)));
    uvec4 n0 = storedNodes_at(at + 3u);
    uvec4 n1 = storedNodes_at(at + 4u);
    uvec4 n2 = storedNodes_at(at + 5u);
    uvec4 corner = storedNodes_at(at + 6u);
    uvec4 words = storedNodes_at(at + 7u);
    inside.firstId = corner.w;
    inside.mirrored = (words.y & INSTANCE_MIRRORS) != 0u;
    enterBottom(words.x);
    return placedRay(inside.ray, placedRow(n0), placedRow(n1), placedRow(n2), placedFloats(corner), uintBitsToFloat(words.z),
                     uintBitsToFloat(words.w), inside.toLocal);
}

// The world's ray against the bottom's triangle (a, b, c), where the instance puts it. True if it became the best hit of
// all.
bool intersectPlaced(vec3 a, vec3 b, vec3 c, uint id, bool obstacle) {
    vec3 A = placePoint(inside.placement, a);
    vec3 B = placePoint(inside.placement, b);
    vec3 C = placePoint(inside.placement, c);
    vec3 second = pick(inside.mirrored, C, B);
    vec3 third = pick(inside.mirrored, B, C);
    return intersectTriangle(inside.ray, A, second, third, id, obstacle, inside.best);
}

// A step of the top tree, from node `top` of the ray's copy: to the next node, or into an instance whose box the ray meets.
// Then the result is its number | TOP_LEAF, and `top` stays.
uint stepTop(WalkRay ray, uint firstNode, INOUT(uint) top) {
    uvec4 low = storedNodes_at((firstNode + top) * 2u);
    uvec4 high = storedNodes_at((firstNode + top) * 2u + 1u);
    vec3 lo = placedFloats(low);
    vec3 hi = placedFloats(high);
    bvec3 down = bvec3(ray.inverse.x < 0.0f, ray.inverse.y < 0.0f, ray.inverse.z < 0.0f);
    bool hit = hitsPlanes(ray, mix(lo, hi, down), mix(hi, lo, down), inside.best.t);
    bool leaf = low.w >= TOP_LEAF;
    uint onMiss = leaf ? top + 1u : low.w;
    uint onHit = leaf ? top : top + 1u;
    top = hit ? onHit : onMiss;
    return hit && leaf ? low.w : 0u;
}
