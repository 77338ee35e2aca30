// Finds the closest triangle that `ray` hits, walking a depth-first BVH without a stack.
//
// A node's word w is a skip link, the node to go to when the ray misses it; or, with the top bit set, a leaf: the number of
// its first triangle << 4 | how many. A leaf's next node is the one after it, and so is an inner node's first child. The
// walks differ in how many trees there are and how planes are stored (WALK_* in shared/structure.glsl): one for each octant
// of directions has the nearer child first in each, and its boxes stored as (near plane, far plane).
//
// Requires  nodes[] and triangles[] as built by host/structures/bvh.cpp for header.walk.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      at.x only grows, so a node is visited at most once; no stack, no shared memory. One step tests up to six nodes
//           for the rays that hold no leaf, then one triangle for those that do: wide devices run both sides of a branch.
// Source    Smits 1998, "Efficiency Issues for Ray Tracing" (skip links); a tree an octant: Torres et al. 2009, "Ray Casting
//           using a Roped BVH with CUDA".

#define WALKS_IN_PAIRS

CONSTANT uint LEAF = 0x80000000u;

// What tests of nodes need of a ray: for 16-bit planes, distance = q * step + base.
struct NodeSpace {
    vec3 step;
    vec3 enterBase;
    vec3 leaveBase;
    uint first;     // of the ray's tree
};

NodeSpace prepareNodes(WalkRay ray) {
    NodeSpace s;
    s.first = header.walk == WALK_SKIP ? 0u : octantOf(ray) * (header.nodeCount + BVH_END_NODES);
    // The slack of quantised planes: as for all boxes, and 11 u M for the roundings of q * step + base.
    vec3 reach = ray.reach * 1.25f;
    s.step = header.gridStep * ray.inverse;
    vec3 base = (header.gridOrigin - ray.origin) * ray.inverse;
    s.enterBase = base - reach;
    s.leaveBase = base + reach;
    return s;
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
    uvec4 low = nodes_at((space.first + at) * 2u);
    uvec4 high = nodes_at((space.first + at) * 2u + 1u);
    word = low.w;
    vec3 near = vec3(uintBitsToFloat(low.x), uintBitsToFloat(low.y), uintBitsToFloat(low.z));
    vec3 far = vec3(uintBitsToFloat(high.x), uintBitsToFloat(high.y), uintBitsToFloat(high.z));
    if (WALK == WALK_SKIP) {
        vec3 lo = near;
        vec3 hi = far;
        near = vec3(ray.inverse.x < 0.0f ? hi.x : lo.x, ray.inverse.y < 0.0f ? hi.y : lo.y, ray.inverse.z < 0.0f ? hi.z : lo.z);
        far = vec3(ray.inverse.x < 0.0f ? lo.x : hi.x, ray.inverse.y < 0.0f ? lo.y : hi.y, ray.inverse.z < 0.0f ? lo.z : hi.z);
    }
    return hitsPlanes(ray, near, far, tMax);
}

// Tests node `at` and goes on to the next: but a ray that hits a leaf stays there, until its triangles are tested.
// Where to go in either case is found while the box is tested, so that one choice follows it: a walk waits for the chain of
// its steps. `held` is the leaf that it stays at.
void stepNode(WalkRay ray, NodeSpace space, float tMax, INOUT(uint) at, INOUT(uint) held, INOUT(Step) taken) {
    COUNT_NODE(at != held && at < header.nodeCount)
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

// Two walks from their beginnings, step by step in turn: a software device computes one while it waits for the other.
void walkPair(WalkRay rayA, WalkRay rayB, INOUT(uvec4) atA, INOUT(uvec4) atB, uint maxSteps, INOUT(Hit) bestA, INOUT(Hit) bestB) {
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
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        stepNode(rayA, spaceA, bestA.t, atA.x, heldA, takenA);
        stepNode(rayB, spaceB, bestB.t, atB.x, heldB, takenB);
        atA.x = min(atA.x, end);
        atB.x = min(atB.x, end);
        testLeaf(rayA, takenA, atA, bestA);
        testLeaf(rayB, takenB, atB, bestB);
    }
}

bool isDone(uvec4 at) { return at.x >= header.nodeCount; }
uvec4 endOfWalk() { return uvec4(header.nodeCount, 0u, 0u, 0u); }
