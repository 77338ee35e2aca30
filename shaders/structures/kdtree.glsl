// Finds the closest triangle that `ray` hits, walking a kd-tree without a stack.
//
// A cell is visited if the ray meets it, widened by the slack of all boxes (ray.reach), no later than the best hit: so a
// hit, which lies within the slack of some point of its triangle, is found in the leaf that holds this point. The ray
// crosses the plane of a node at t; it is in the cell from `enter` to `leave`, both with slack. Which half comes first is
// the direction's to say, so that t needs no sign. The four cases of the lecture, the direction pointing up:
//     A   below only           leave <  t - reach
//     A'  above only           enter >  t + reach
//     B   below, then above    the others; B', where the direction points down: above, then below
// A ray in the plane or nearly so is no fifth case: t - reach and t + reach are then so far apart that it is B.
//
// Requires  nodes[] and triangles[] as built by host/structures/kdtree.cpp.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      no stack: a trail of one bit a level tells where the second half was taken, and the walk begins again from the
//           last node above which nothing is due. WALK_SHORT_STACK has the last two halves that are due in registers and
//           seldom does. Each beginning sets a bit of the trail and clears lower ones, so it only grows; node numbers grow
//           on the way down, places grow in a list, and there are no more beginnings than nodes. A link that leads backwards
//           or out leads nowhere: such a walk does not end, and whoever makes it notices after mostSteps().
// Source    Laine 2010, "Restart Trail for Stackless BVH Traversal"; Foley, Sugerman 2005, "KD-Tree Acceleration Structures
//           for a GPU Raytracer"; Horn et al. 2007, "Interactive k-D Tree GPU Raytracing" (short stack, push-down).
//           Neighbour links [Popov et al. 2007] would need to follow several cells at once where the slack reaches into
//           them.

#define HAS_WALK(walk) ((walk) <= WALK_SHORT_STACK)  // for host/rays/cpu_walk.cpp.in

CONSTANT uint LEAF = 0x80000000u;
CONSTANT uint EMPTY = 0xffffffffu;
CONSTANT uint LAST = 0x80000000u;
CONSTANT uint DONE = 0xffffffffu;
CONSTANT uint ROOT = 1u;
CONSTANT uint NOWHERE = 0u;  // holds the sizes; as a node, it leads to itself: a walk that gets there does not end
CONSTANT uint MAX_LEVELS = 64u;
CONSTANT float INFINITE = 3.4028234e38f;

// A cell and when the ray is in it. `level` has one bit, that of the trail.
struct Place {
    uint node;
    float enter;
    float leave;
    uvec2 level;
};

struct Descent {
    Place here;
    Place top;       // nothing is due above it
    Place last;      // the short stack: the cells whose second half is due last, and last but one
    Place before;
    uint stacked;    // how many of the two there are
    uvec2 due;       // levels whose second half is due
    float earliest;  // no half that is due begins before
    uint end;        // of the nodes
};

float along(uint axis, vec3 v) { return pick(axis == 0u, v.x, pick(axis == 1u, v.y, v.z)); }

uvec2 below(uvec2 level) { return uvec2(level.x >> 1, (level.y >> 1) | (level.x << 31)); }

void take(bool does, Place from, INOUT(Place) to) {
    to.node = pick(does, from.node, to.node);
    to.enter = pick(does, from.enter, to.enter);
    to.leave = pick(does, from.leave, to.leave);
    to.level.x = pick(does, from.level.x, to.level.x);
    to.level.y = pick(does, from.level.y, to.level.y);
}

// Goes from an inner node to the half that comes first, or to the second where the trail says so.
void stepDown(WalkRay ray, uvec2 trail, INOUT(Descent) s) {
    bool inner = s.here.node < LEAF;
    uvec4 node = nodes_at(pick(inner, s.here.node, 0u));
    COUNT_NODE(inner)
    float inverse = along(node.y, ray.inverse);
    float reach = along(node.y, ray.reach);
    precise float t = (uintBitsToFloat(node.x) - along(node.y, ray.origin)) * inverse;
    precise float from = t - reach;
    precise float to = t + reach;
    bool up = inverse >= 0.0f;
    uint first = pick(up, node.z, node.w);
    uint second = pick(up, node.w, node.z);

    // Whether the ray is in the first half does not depend on the best hit, and in the second it can only cease to be: so
    // the trail means the same however far the search has come.
    bool beforePlane = s.here.enter <= to;
    bool beyondPlane = from <= s.here.leave;
    bool isFirst = first != EMPTY;
    bool isSecond = second != EMPTY;
    bool inFirst = beforePlane && isFirst;
    bool inSecond = beyondPlane && isSecond;
    bool again = ((trail.x & s.here.level.x) | (trail.y & s.here.level.y)) != 0u;
    bool goSecond = again || !inFirst;
    bool twice = inSecond && !goSecond;
    bool both = inner && twice;
    uint next = pick(goSecond, pick(inSecond, second, EMPTY), first);
    // What no link of a sound tree is: it leads backwards, or out (seen from the node, also what is before it is far away).
    bool isNode = next < LEAF;
    bool isUnsound = next - s.here.node - 1u >= s.end - s.here.node - 1u;
    bool isBroken = isNode && isUnsound;
    next = pick(isBroken, NOWHERE, next);
    float enter = maxOf(s.here.enter, from);

    if (WALK == WALK_SHORT_STACK) {
        take(both, s.last, s.before);
        take(both, Place(second, enter, s.here.leave, s.here.level), s.last);
        s.stacked = pick(both, min(s.stacked + 1u, 2u), s.stacked);
    }
    s.due.x |= pick(both, s.here.level.x, 0u);
    s.due.y |= pick(both, s.here.level.y, 0u);
    s.earliest = pick(both, minOf(s.earliest, enter), s.earliest);
    float leave = pick(goSecond, s.here.leave, minOf(s.here.leave, to));
    take(inner, Place(next, pick(goSecond, enter, s.here.enter), leave, below(s.here.level)), s.here);
    bool nothingDue = (s.due.x | s.due.y) == 0u;
    bool isInner = s.here.node < LEAF;
    take(nothingDue && isInner, s.here, s.top);
}

// Where the walk begins: the whole scene. Its two planes an axis are treated as those of the nodes.
Descent beginning(WalkRay ray, uint end) {
    bvec3 down = bvec3(ray.inverse.x < 0.0f, ray.inverse.y < 0.0f, ray.inverse.z < 0.0f);
    vec3 near = mix(header.lo, header.hi, down);
    vec3 far = mix(header.hi, header.lo, down);
    precise vec3 enter = (near - ray.origin) * ray.inverse - ray.reach;
    precise vec3 leave = (far - ray.origin) * ray.inverse + ray.reach;
    Descent s;
    s.top.node = ROOT;
    s.top.enter = maxOf(maxOf(enter.x, enter.y), maxOf(enter.z, ray.tMin));
    s.top.leave = minOf(minOf(leave.x, leave.y), minOf(leave.z, ray.tMax));
    s.top.level = uvec2(0x80000000u, 0u);
    s.last = s.top;
    s.before = s.top;
    s.stacked = 0u;
    s.due = uvec2(0u, 0u);
    s.earliest = INFINITE;
    s.end = end;
    return s;
}

// Goes to the deepest level whose second half is due, if that may hold a nearer hit: from the short stack, or by beginning
// again from the top. Returns false if nothing is left.
bool stepBack(bool does, float tMax, INOUT(uvec4) at, INOUT(Descent) s) {
    bool isDue = (s.due.x | s.due.y) != 0u;
    bool isInTime = s.earliest <= tMax;
    bool left = isDue && isInTime;
    bool deep = s.due.y != 0u;
    uint word = pick(deep, s.due.y, s.due.x);
    uint level = word & (~word + 1u);
    uint taken = (pick(deep, at.y, at.x) & ~(level - 1u)) | level;
    at.x = pick(does && !deep, taken, at.x);
    at.y = pick(does, pick(deep, taken, 0u), at.y);
    at.w = pick(does, at.w + 1u, at.w);

    Place next = s.top;
    bool stacked = false;
    if (WALK == WALK_SHORT_STACK) {
        stacked = s.stacked > 0u;
        bool pops = does && stacked;
        take(stacked, Place(s.last.node, s.last.enter, s.last.leave, below(s.last.level)), next);
        take(pops, s.before, s.last);
        s.stacked = pick(pops, s.stacked - 1u, s.stacked);
    }
    next.leave = minOf(next.leave, tMax);
    bool isIn = next.enter <= next.leave;
    bool isSoundToo = next.node < s.end || next.node >= LEAF;
    next.node = pick(isIn && isSoundToo, next.node, EMPTY);
    take(does, next, s.here);
    bool keepsAbove = stacked && deep;
    s.due.x = pick(does, pick(stacked, pick(deep, s.due.x, s.due.x & ~level), 0u), s.due.x);
    s.due.y = pick(does, pick(keepsAbove, s.due.y & ~level, 0u), s.due.y);
    s.earliest = pick(does && !stacked, INFINITE, s.earliest);
    return left;
}

// at.xy: the trail, one bit a level from the top: set where the second half was taken after the first. at.z: the node, or
// the place in a leaf's list | LEAF. at.w: how often the walk stepped back, or DONE.
void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    uvec4 sizes = nodes_at(0u);
    Descent s = beginning(ray, sizes.x);
    s.here = s.top;
    s.here.leave = minOf(s.top.leave, best.t);
    s.here.node = pick(s.here.enter <= s.here.leave, ROOT, EMPTY);

    // A walk that is taken up again: down to where it stood.
    for (uint i = 0u; at.z != 0u && s.here.node < LEAF && s.here.node != at.z && i < MAX_LEVELS; ++i)
        stepDown(ray, uvec2(at.x, at.y), s);
    bool isInList = at.z >= LEAF;
    bool isThere = s.here.node != EMPTY;
    s.here.node = pick(isInList && isThere, at.z, s.here.node);

    for (uint step = 0u; at.w != DONE && step < maxSteps; ++step) {
        uvec2 trail = uvec2(at.x, at.y);
        stepDown(ray, trail, s);
        stepDown(ray, trail, s);
        stepDown(ray, trail, s);
        stepDown(ray, trail, s);
        bool inLeaf = s.here.node - LEAF < EMPTY - LEAF;
        if (inLeaf) {
            uint place = min(s.here.node - LEAF, sizes.y - 1u);
            uvec4 four = nodes_at(place >> 2);
            uint even = pick((place & 2u) == 0u, four.x, four.z);
            uint odd = pick((place & 2u) == 0u, four.y, four.w);
            uint word = pick((place & 1u) == 0u, even, odd);
            bool hit = testTriangle(ray, min(word & ~LAST, header.triangleCount - 1u), best);
            bool isMarked = (word & LAST) != 0u;
            bool isEnd = place + 1u >= sizes.y;
            s.here.node = pick(isMarked || isEnd, EMPTY, LEAF + place + 1u);
            if (ANY_HIT && hit) at.w = DONE;
        }
        bool isAtEnd = s.here.node == EMPTY;
        bool goesOn = at.w != DONE;
        bool back = isAtEnd && goesOn;
        bool left = stepBack(back, best.t, at, s);
        at.w = pick(back && !left, DONE, at.w);
    }
    at.z = s.here.node;
}

// No more beginnings than nodes, 64 levels down by four each time, and one step a word of the lists.
float mostSteps() {
    uvec4 sizes = nodes_at(0u);
    return 20.0f * float(int(header.nodeCount)) + float(int(sizes.y)) + 64.0f;
}

bool isDone(uvec4 at) { return at.w == DONE; }
