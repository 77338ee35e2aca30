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
    s.first = header.walk == WALK_SKIP ? 0u : octantOf(ray) * (header.nodeCount + 1u);
    // The slack of quantised planes: as for all boxes, and 11 u M for the roundings of q * step + base.
    vec3 reach = ray.reach * 1.25f;
    s.step = header.gridStep * ray.inverse;
    vec3 base = (header.gridOrigin - ray.origin) * ray.inverse;
    s.enterBase = base - reach;
    s.leaveBase = base + reach;
    return s;
}

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

// at.x: the next node. at.y: 0, or the word of the leaf whose triangles are to be tested, those already tested taken off.
// A node beyond the last one, which no ray should hit, spares the walk a test for the end.
void stepNode(WalkRay ray, NodeSpace space, uint end, Hit best, INOUT(uvec4) at) {
    bool going = at.y == 0u;
    uint word = 0u;
    bool hit = hitsNode(ray, space, at.x, best.t, word);
    COUNT_NODE(going && at.x < end)
    bool leaf = word >= LEAF;
    uint next = hit || leaf ? at.x + 1u : word;
    at.y = going && hit && leaf ? word : at.y;
    at.x = going ? min(next, end) : at.x;
}

void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    NodeSpace space = prepareNodes(ray);
    uint end = header.nodeCount;
    for (uint step = 0u; (at.x < end || at.y != 0u) && step < maxSteps; ++step) {
        stepNode(ray, space, end, best, at);
        stepNode(ray, space, end, best, at);
        stepNode(ray, space, end, best, at);
        stepNode(ray, space, end, best, at);
        stepNode(ray, space, end, best, at);
        stepNode(ray, space, end, best, at);
        if (at.y != 0u) {
            bool hit = testTriangle(ray, (at.y & ~LEAF) >> 4, best);
            at.y += 15u;  // first + 1, count - 1
            at.y = (at.y & 15u) == 0u ? 0u : at.y;
            if (ANY_HIT && hit) at = uvec4(end, 0u, 0u, 0u);
        }
    }
}

bool isDone(uvec4 at) { return at.x >= header.nodeCount && at.y == 0u; }
