// Finds the closest triangle that `ray` hits, walking a depth-first BVH of any arity without a stack.
//
// A node's word w is a skip link, the node to go to when the ray misses it; or, with the top bit set, a leaf: the number of
// its first triangle << 4 | how many. A leaf's next node is the one after it, and so is an inner node's first child. The
// walks differ in how many trees there are and what bounds a node (WALK_* in shared/structure.glsl): one for each octant
// of directions has the nearer child first in each, and boxes stored as (near plane, far plane).
//
// Requires  nodes[] and triangles[] as built by host/structures/bvh.cpp for header.walk, less than WALK_TRAIL (trail.glsl
//           has those).
// Ensures   as every walk (shaders/trace.glsl).
// Cost      at.x only grows, so a node is visited at most once; no stack, no shared memory. One step tests up to six nodes
//           (four, of two rays in turn) where no leaf is held, then a primitive where one is: wide devices run both sides
//           of a branch.
// Source    Smits 1998, "Efficiency Issues for Ray Tracing" (skip links); a tree an octant: Torres et al. 2009, "Ray Casting
//           using a Roped BVH with CUDA"; slabs: Kay and Kajiya 1986, "Ray Tracing Complex Scenes".

#define WALKS_IN_PAIRS
#define HAS_WALK(walk) ((walk) < WALK_TRAIL)  // for host/rays/cpu_walk.cpp.in

CONSTANT uint LEAF = 0x80000000u;

// What tests of nodes need of a ray: for 16-bit planes, distance = q * step + base.
struct NodeSpace {
    vec3 step;
    vec3 enterBase;
    vec3 leaveBase;
    uint first;     // of the ray's tree

    // For bounds other than boxes. Places are wrong by less than margin: 256 u M, for the hit's slack along an axis that
    // lies across the coordinates' (64 u M times 1.8), and for the sums of three products here (at most 20 u M, along rays
    // too).
    float margin;
    vec3 from;          // the origin, as seen from the scene's lower corner, as such bounds are
    vec3 along;         // the direction
    float perSquare;    // 1 / its square
    float perLength;    // 1 / its length
    vec3 diagonal;      // of slabs along (1, 1, 1), (-1, 1, 1), (1, -1, 1): dot with the origin; and the inverse of that
    float lastDiagonal; // with the direction; the fourth, along (1, 1, -1)
    vec3 perDiagonal;
    float perLastDiagonal;
};

vec3 diagonalsOf(vec3 v) { return vec3(v.x + v.y + v.z, v.y - v.x + v.z, v.x - v.y + v.z); }
float lastDiagonalOf(vec3 v) { return v.x + v.y - v.z; }

NodeSpace prepareNodes(WalkRay ray) {
    NodeSpace s;
    s.first = header.walk == WALK_SKIP ? 0u : octantOf(ray) * (header.nodeCount + BVH_END_NODES);
    // The slack of quantised planes: as for all boxes, and 11 u M for the roundings of q * step + base.
    vec3 reach = ray.reach * 1.25f;
    s.step = header.gridStep * ray.inverse;
    vec3 base = (header.gridOrigin - ray.origin) * ray.inverse;
    s.enterBase = base - reach;
    s.leaveBase = base + reach;
    if (WALK == WALK_SPHERES || WALK == WALK_OBBS || WALK == WALK_KDOPS) {
        s.margin = ray.tolerance * 16.0f;
        s.from = ray.origin - header.gridOrigin;
        s.along = ray.direction;
        s.perSquare = 1.0f / dot(s.along, s.along);
        s.perLength = sqrt(s.perSquare);
        s.diagonal = diagonalsOf(s.from);
        s.lastDiagonal = lastDiagonalOf(s.from);
        vec3 d = diagonalsOf(s.along);
        s.perDiagonal = vec3(1.0f / steep(d.x, 1.0f), 1.0f / steep(d.y, 1.0f), 1.0f / steep(d.z, 1.0f));
        s.perLastDiagonal = 1.0f / steep(lastDiagonalOf(s.along), 1.0f);
    }
    return s;
}

vec3 floatsOf(uvec4 t) { return vec3(uintBitsToFloat(t.x), uintBitsToFloat(t.y), uintBitsToFloat(t.z)); }

// Distances at which the ray is in slabs [lo, hi] along three directions: `from` and `per` are as for axes, but widened by
// `margin`. `span` is narrowed.
void cutSlabs(vec3 lo, vec3 hi, vec3 from, vec3 per, float margin, INOUT(vec2) span) {
    vec3 first = (lo - margin - from) * per;
    vec3 second = (hi + margin - from) * per;
    span.x = greater(span.x, greater(lesser(first.x, second.x),
                                     greater(lesser(first.y, second.y), lesser(first.z, second.z))));
    span.y = lesser(span.y, lesser(greater(first.x, second.x),
                                   lesser(greater(first.y, second.y), greater(first.z, second.z))));
}

// A sphere about `centre`: where the ray passes it no farther off than `radius` and the margin, within that of its nearest
// point.
bool hitsSphere(WalkRay ray, NodeSpace space, vec3 centre, float radius, float tMax) {
    vec3 toCentre = centre - space.from;
    float nearest = dot(toCentre, space.along) * space.perSquare;
    vec3 off = toCentre - nearest * space.along;
    float wide = radius + space.margin;
    float rest = wide * wide - dot(off, off);
    // In a square root's steep end, rounding is made up for by what it can at most be.
    float half_ = sqrt(abs(rest) + wide * wide * 4.76837158e-7f) * space.perLength + space.margin * space.perLength;
    return radius >= 0.0f && rest >= 0.0f && nearest - half_ <= tMax && nearest + half_ >= ray.tMin;
}

bool hitsOrientedBox(WalkRay ray, NodeSpace space, uvec4 n0, uvec4 n1, uvec4 n2, uvec4 n3, float tMax) {
    vec3 x = floatsOf(n0);
    vec3 y = floatsOf(n1);
    vec3 z = floatsOf(n2);
    vec3 hi = vec3(uintBitsToFloat(n1.w), uintBitsToFloat(n2.w), uintBitsToFloat(n3.w));
    vec3 from = vec3(dot(x, space.from), dot(y, space.from), dot(z, space.from));
    vec3 per = vec3(1.0f / steep(dot(x, space.along), 1.0f), 1.0f / steep(dot(y, space.along), 1.0f),
                    1.0f / steep(dot(z, space.along), 1.0f));
    vec2 span = vec2(ray.tMin, tMax);
    cutSlabs(floatsOf(n3), hi, from, per, space.margin, span);
    return span.x <= span.y;
}

bool hitsKdop(WalkRay ray, NodeSpace space, uvec4 n0, uvec4 n1, uvec4 n2, uvec4 n3, float tMax) {
    vec2 span = vec2(ray.tMin, tMax);
    cutSlabs(floatsOf(n0), floatsOf(n1), space.from, ray.inverse, space.margin, span);
    cutSlabs(floatsOf(n2), floatsOf(n3), space.diagonal, space.perDiagonal, space.margin, span);
    float first = (uintBitsToFloat(n2.w) - space.margin - space.lastDiagonal) * space.perLastDiagonal;
    float second = (uintBitsToFloat(n3.w) + space.margin - space.lastDiagonal) * space.perLastDiagonal;
    return greater(span.x, lesser(first, second)) <= lesser(span.y, greater(first, second));
}

// What the last test of a node came to.
struct Step {
    uint word;
    bool holdsLeaf;
};

// Reads node `at` into `word` and says whether the ray meets its box no later than tMax.
bool hitsNode(WalkRay ray, NodeSpace space, uint at, float tMax, INOUT(uint) word) {
    if (WALK == WALK_OCTANTS16) {
        uvec4 node = nodes_at(space.first + at);
        word = node.w;
        vec3 near = vec3(float(int(node.x & 0xffffu)), float(int(node.y & 0xffffu)), float(int(node.z & 0xffffu)));
        vec3 far = vec3(float(int(node.x >> 16)), float(int(node.y >> 16)), float(int(node.z >> 16)));
        vec3 enter = near * space.step + space.enterBase;
        vec3 leave = far * space.step + space.leaveBase;
        float first = maxOf(maxOf(enter.x, enter.y), maxOf(enter.z, ray.tMin));
        float last = minOf(minOf(leave.x, leave.y), minOf(leave.z, tMax));
        return first <= last;
    }
    if (WALK == WALK_OBBS || WALK == WALK_KDOPS) {
        uint place = (space.first + at) * 4u;
        uvec4 n0 = nodes_at(place);
        uvec4 n1 = nodes_at(place + 1u);
        uvec4 n2 = nodes_at(place + 2u);
        uvec4 n3 = nodes_at(place + 3u);
        word = n0.w;
        if (WALK == WALK_OBBS) return hitsOrientedBox(ray, space, n0, n1, n2, n3, tMax);
        return hitsKdop(ray, space, n0, n1, n2, n3, tMax);
    }
    uvec4 low = nodes_at((space.first + at) * 2u);
    uvec4 high = nodes_at((space.first + at) * 2u + 1u);
    word = low.w;
    vec3 near = floatsOf(low);
    vec3 far = floatsOf(high);
    if (WALK == WALK_SPHERES) return hitsSphere(ray, space, near, far.x, tMax);
    if (WALK == WALK_SKIP) {
        vec3 lo = near;
        vec3 hi = far;
        near = vec3(ray.inverse.x < 0.0f ? hi.x : lo.x, ray.inverse.y < 0.0f ? hi.y : lo.y,
                    ray.inverse.z < 0.0f ? hi.z : lo.z);
        far = vec3(ray.inverse.x < 0.0f ? lo.x : hi.x, ray.inverse.y < 0.0f ? lo.y : hi.y,
                   ray.inverse.z < 0.0f ? lo.z : hi.z);
    }
    return hitsPlanes(ray, near, far, tMax);
}

// Tests node `at` and goes on to the next: but a ray that hits a leaf stays there, until its triangles are tested.
// Where to go in either case is found while the box is tested, so that one choice follows it: a walk waits for the chain of
// its steps. `held` is the leaf that it stays at.
void stepNode(WalkRay ray, NodeSpace space, float tMax, INOUT(uint) at, INOUT(uint) held, INOUT(Step) taken) {
    COUNT_NODE(at != held && at < header.nodeCount)
    COUNT_BOXES(at != held && at < header.nodeCount ? 1u : 0u)
    uint word = 0u;
    bool hit = hitsNode(ray, space, at, tMax, word);
    uint after = at + 1u;
    bool leaf = word >= LEAF;
    uint onHit = leaf ? at : after;
    uint onMiss = leaf ? after : word;
    taken.holdsLeaf = hit && leaf;
    taken.word = word;
    at = hit ? onHit : onMiss;
    if (COUNTING) held = taken.holdsLeaf ? at : NO_HIT;
}

// Tests a triangle of the leaf at at.x, if the last step found that the ray hits one.
void testLeaf(WalkRay ray, Step taken, INOUT(uvec4) at, INOUT(Hit) best) {
    if (taken.holdsLeaf) {
        uint here = at.x;
        uint tested = at.y == here ? at.z : 0u;
        bool hit = testTriangle(ray, ((taken.word & ~LEAF) >> 4) + tested, best);
        at.y = here;
        at.z = tested + 1u;
        at.x = at.z == (taken.word & 15u) ? here + 1u : here;
        if (ANY_HIT && hit) at.x = header.nodeCount;
    }
}

// at.x: the next node. at.y: a leaf of which at.z triangles are tested already.
// The nodes beyond the last one lead to themselves: so a walk that has come to its end stays there, or goes from one to the
// next of them, if the ray comes from so far away that it hits everything.
void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    NodeSpace space = prepareNodes(ray);
    uint end = header.nodeCount;
    uint held = at.z > 0u ? at.y : NO_HIT;
    for (uint step = 0u; at.x < end && step < maxSteps; ++step) {
        Step taken = Step(0u, false);
        stepNode(ray, space, best.t, at.x, held, taken);
        stepNode(ray, space, best.t, at.x, held, taken);
        stepNode(ray, space, best.t, at.x, held, taken);
        stepNode(ray, space, best.t, at.x, held, taken);
        stepNode(ray, space, best.t, at.x, held, taken);
        stepNode(ray, space, best.t, at.x, held, taken);
        testLeaf(ray, taken, at, best);
    }
}

Hit pick(bool first, Hit a, Hit b) {
    return Hit(pick(first, a.t, b.t), pick(first, a.u, b.u), pick(first, a.v, b.v), pick(first, a.primitive, b.primitive));
}

// Only what tests of primitives need; the rest is of b.
WalkRay pick(bool first, WalkRay a, WalkRay b) {
    WalkRay ray = b;
    ray.origin = pick(first, a.origin, b.origin);
    ray.direction = pick(first, a.direction, b.direction);
    ray.tMin = pick(first, a.tMin, b.tMin);
    ray.tolerance = pick(first, a.tolerance, b.tolerance);
    ray.shear = vec2(pick(first, a.shear.x, b.shear.x), pick(first, a.shear.y, b.shear.y));
    ray.inverseZ = pick(first, a.inverseZ, b.inverseZ);
    ray.axisZ = pick(first, a.axisZ, b.axisZ);
    return ray;
}

// Two walks from their beginnings, step by step in turn: a software device computes one while it waits for the other. A
// primitive is tested for one of the two only: seldom does either hold a leaf, and such devices compute the test even where
// no lane needs it. Where both do, the second waits.
void walkPair(WalkRay rayA, WalkRay rayB, INOUT(uvec4) atA, INOUT(uvec4) atB, uint maxSteps, INOUT(Hit) bestA,
              INOUT(Hit) bestB) {
    NodeSpace spaceA = prepareNodes(rayA);
    NodeSpace spaceB = prepareNodes(rayB);
    uint end = header.nodeCount;
    uint heldA = NO_HIT;
    uint heldB = NO_HIT;
    for (uint step = 0u; (atA.x < end || atB.x < end) && step < maxSteps; ++step) {
        Step takenA = Step(0u, false);
        Step takenB = Step(0u, false);
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        atA.x = min(atA.x, end);
        atB.x = min(atB.x, end);
        bool isB = takenB.holdsLeaf && !takenA.holdsLeaf;
        WalkRay ray = pick(isB, rayB, rayA);
        Step taken = Step(pick(isB, takenB.word, takenA.word), takenA.holdsLeaf || takenB.holdsLeaf);
        uvec4 at = pick(isB, atB, atA);
        Hit best = pick(isB, bestB, bestA);
        testLeaf(ray, taken, at, best);
        atA = pick(isB, atA, at);
        atB = pick(isB, at, atB);
        bestA = pick(isB, bestA, best);
        bestB = pick(isB, best, bestB);
    }
}

// A step passes a node or tests a triangle; 24 times as many, for walks that come to a node again.
float mostSteps() { return 24.0f * float(int(header.nodeCount)) + float(int(header.triangleCount)) + 64.0f; }

bool isDone(uvec4 at) { return at.x >= header.nodeCount; }
uvec4 endOfWalk() { return uvec4(header.nodeCount, 0u, 0u, 0u); }
