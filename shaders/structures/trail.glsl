// Finds the closest triangle that `ray` hits, walking a tree whose nodes hold the boxes of all their children, near first.
//
// A node has TRAIL_ARITY slots for children, 2, 4 or 8: each has a box, and a word: the number of a node, or a leaf (the top
// bit, the number of its first triangle << 4 | how many), or NONE. Beyond the nodes each has a link: the number of its
// parent << 3 | its slot there.
//
// Children are visited in the order of their keys: the bits of the distance at which the ray enters the box, the last three
// of them replaced by the slot. A key says the same whenever the node is read again, as it does not depend on the best hit.
// So the place (parent, slot) of the child at hand tells all that is due: the children with higher keys of every node above
// it. Of these the walk keeps
//     `due`     one bit a level, bit 0 that of the parent: there are children with higher keys that the ray met
//     a to d    the four that come next, with their keys: what is no nearer than the best hit is dropped without being read
// and where those four are used up, it goes up by links to the lowest level that is due, reads the node again, and goes on
// after the slot it came from. (Unless `earliest`, before which none of the others is entered, is beyond the best hit: then
// it ends.)
//
// Requires  nodes[] and triangles[] as built by host/structures/bvh_trail.cpp for header.walk.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      no stack in memory. A walk that is taken up again reads one node twice, and has the four to find again.
//           Node numbers grow on the way down and fall on the way up. Where links say otherwise, the walk stays and does not
//           end, which whoever makes it notices after mostSteps().
// Source    Hapala et al. 2011, "Efficient Stack-less BVH Traversal for Ray Tracing"; Afra, Szirmay-Kalos 2014, "Stackless
//           Multi-BVH Traversal for CPU, MIC and GPU Ray Tracing" (a bit a level); Vaidyanathan, Woop, Benthin 2019, "Wide
//           BVH Traversal with a Short Stack"; planes of 8 bits: Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray
//           Traversal on GPUs Through Compressed Wide BVHs".

CONSTANT uint LEAF = 0x80000000u;
CONSTANT uint NONE = 0xffffffffu;
CONSTANT uint TRAIL_DONE = 0xffffffffu;
CONSTANT uint MORE = 0x80000000u;
CONSTANT uint SLOT = 7u;

// How at.x is to be understood, in its two upper bits: where nothing has been done, it is 0.
CONSTANT uint AT_CHILD = 0x40000000u;  // the child is to be visited, or is a leaf being tested
CONSTANT uint AT_END = 0x80000000u;    // the child is done
CONSTANT uint PLACE = 0x3fffffffu;

uint trailArity() { return TRAIL_ARITY; }
uint trailPlanes() { return (WALK - WALK_TRAIL) / 3u; }  // 0: of 32 bits, 1: 16, 2: 8

#define HAS_WALK(walk) ((walk) >= WALK_TRAIL && 2u << ((walk) - WALK_TRAIL) % 3u == TRAIL_ARITY)
#define A_WALK (WALK_TRAIL + (TRAIL_ARITY == 2u ? 0u : TRAIL_ARITY / 4u))

#include "structures/trail_nodes.glsl"

// What is due next: a child, by its key, its word, and its parent | MORE if other children of that follow.
struct Due {
    uint key;
    uint word;
    uint parent;
};

struct Trail {
    uint word;      // of the child at hand: a node to be read, a leaf, or NONE if it is done
    uint parent;    // NONE: the child is the root
    uint slot;
    uint tested;    // triangles of the leaf
    bool again;     // the parent is to be read again, and its children from `slot` on are due
    uint from;      // 0, or 1 if only those after it are
    bool up;        // its link is to be read
    bool done;
    uvec2 due;
    Due a;
    Due b;
    Due c;
    Due d;
    uint earliest;
};

void order(INOUT(uint) a, INOUT(uint) b) {
    uint less = min(a, b);
    b = max(a, b);
    a = less;
}

void take(bool does, Due from, INOUT(Due) to) {
    to.key = choose(does, from.key, to.key);
    to.word = choose(does, from.word, to.word);
    to.parent = choose(does, from.parent, to.parent);
}

// Makes room for `count` places, at most four, on the stack; what falls off is remembered by the least of its keys.
void makeRoom(uint count, INOUT(Trail) s) {
    Due none = Due(NONE, NONE, 0u);
    bool one = (count & 1u) != 0u;
    s.earliest = choose(one, min(s.earliest, s.d.key), s.earliest);
    take(one, s.c, s.d);
    take(one, s.b, s.c);
    take(one, s.a, s.b);
    if (trailArity() == 2u) return;
    take(one, none, s.a);
    bool two = (count & 2u) != 0u;
    s.earliest = choose(two, min(s.earliest, min(s.c.key, s.d.key)), s.earliest);
    take(two, s.b, s.d);
    take(two, s.a, s.c);
    if (trailArity() == 4u) return;
    take(two, none, s.b);
    bool four = count >= 4u;
    s.earliest = choose(four, min(min(s.earliest, s.a.key), min(s.b.key, min(s.c.key, s.d.key))), s.earliest);
}

void sortFour(INOUT(uvec4) k) {
    order(k.x, k.y);
    order(k.z, k.w);
    order(k.x, k.z);
    order(k.y, k.w);
    order(k.y, k.z);
}

// The least of the keys. `later` becomes the second to the fifth, NONE where there are no more; of eight `sixth` the sixth.
uint sortKeys(Children met, INOUT(uvec4) later, INOUT(uint) sixth) {
    uvec4 k = met.keys;
    uvec4 m = uvec4(NONE);
    if (trailArity() == 2u) {
        order(k.x, k.y);
        later = uvec4(k.y, NONE, NONE, NONE);
        return k.x;
    }
    sortFour(k);
    if (trailArity() == 8u) {
        m = met.moreKeys;
        sortFour(m);
        // Batcher's merge of two sorted fours.
        order(k.x, m.x);
        order(k.y, m.y);
        order(k.z, m.z);
        order(k.w, m.w);
        order(k.z, m.x);
        order(k.w, m.y);
        order(k.y, k.z);
        order(k.w, m.x);
        order(m.y, m.z);
        sixth = m.y;
    }
    later = uvec4(k.y, k.z, k.w, m.x);
    return k.x;
}

// Which of the children comes next, and those that follow it onto the stack. `node` is their parent.
void visitNearest(uint node, Children met, Children all, INOUT(Trail) s) {
    uint sixth = NONE;
    uvec4 later = uvec4(NONE);
    uint next = sortKeys(met, later, sixth);
    uint count = choose(later.x != NONE, 1u, 0u);
    if (trailArity() > 2u)
        count += choose(later.y != NONE, 1u, 0u) + choose(later.z != NONE, 1u, 0u) + choose(later.w != NONE, 1u, 0u);
    makeRoom(count, s);
    s.earliest = min(s.earliest, sixth);
    bool wide = trailArity() == 8u;
    uint word = laneOf(all.words, next);
    uvec4 words = uvec4(laneOf(all.words, later.x), laneOf(all.words, later.y), laneOf(all.words, later.z), NONE);
    if (wide) {
        words.w = laneOf(all.words, later.w);
        word = choose((next & 4u) != 0u, laneOf(all.moreWords, next), word);
        words.x = choose((later.x & 4u) != 0u, laneOf(all.moreWords, later.x), words.x);
        words.y = choose((later.y & 4u) != 0u, laneOf(all.moreWords, later.y), words.y);
        words.z = choose((later.z & 4u) != 0u, laneOf(all.moreWords, later.z), words.z);
        words.w = choose((later.w & 4u) != 0u, laneOf(all.moreWords, later.w), words.w);
    }
    take(count > 0u, Due(later.x, words.x, node | choose(later.y != NONE, MORE, 0u)), s.a);
    if (trailArity() > 2u) {
        take(count > 1u, Due(later.y, words.y, node | choose(later.z != NONE, MORE, 0u)), s.b);
        take(count > 2u, Due(later.z, words.z, node | choose(later.w != NONE, MORE, 0u)), s.c);
    }
    if (wide) take(count > 3u, Due(later.w, words.w, node | choose(sixth != NONE, MORE, 0u)), s.d);

    bool found = next != NONE;
    uint more = choose(count > 0u, 1u, 0u);
    bool below = found && !s.again;
    s.due.y = choose(below, (s.due.y << 1) | (s.due.x >> 31), s.due.y);
    s.due.x = choose(below, s.due.x << 1, choose(s.again, s.due.x & ~1u, s.due.x)) | more;
    s.tested = choose(s.again && (next & SLOT) == s.slot, s.tested, 0u);
    s.parent = choose(found, node, s.parent);
    s.slot = choose(found, next & SLOT, s.slot);
    s.word = choose(found, word, NONE);
    s.again = false;
}

uint countChildren(Children all) {
    uint count = 0u;
    for (uint i = 0u; i < 4u; ++i)
        count += choose(laneOf(all.words, i) != NONE, 1u, 0u) + choose(laneOf(all.moreWords, i) != NONE, 1u, 0u);
    return count;
}

// If the child at hand is done: goes to the next that is due, or finds that it is to be looked for above.
void stepBack(float tMax, INOUT(Trail) s) {
    bool idle = s.word == NONE && !s.again && !s.done;
    bool stacked = s.a.key != NONE;
    bool pops = idle && stacked;
    bool dry = idle && !stacked;

    // The level of what is on top of the stack is the lowest that is due.
    bool high = s.due.x == 0u;
    uint low = choose(high, s.due.y, s.due.x);
    uint rest = choose(high, 0u, s.due.y);
    uint levels = uint(findLSB(low | 0x80000000u));
    uint dueX = (low >> levels) | ((rest << 1) << (31u - levels));
    s.due.x = choose(pops, (dueX & ~1u) | (s.a.parent >> 31), s.due.x);
    s.due.y = choose(pops, rest >> levels, s.due.y);
    bool inTime = uintBitsToFloat(s.a.key & ~SLOT) <= tMax;
    s.word = choose(pops && inTime, s.a.word, s.word);
    s.parent = choose(pops, s.a.parent & ~MORE, s.parent);
    s.slot = choose(pops, s.a.key & SLOT, s.slot);
    take(pops, s.b, s.a);
    take(pops, s.c, s.b);
    take(pops, s.d, s.c);
    s.d.key = choose(pops, NONE, s.d.key);

    bool nothing = (s.due.x | s.due.y) == 0u || uintBitsToFloat(s.earliest & ~SLOT) > tMax;
    bool here = (s.due.x & 1u) != 0u;
    bool climbs = dry && !nothing && here;
    s.done = s.done || (dry && nothing);
    s.up = dry && !nothing && !here;
    s.again = s.again || climbs;
    s.from = choose(climbs, 1u, s.from);
}

// Reads a node, if the child at hand is one, or its parent again, or that one's link.
void stepInto(WalkRay ray, TrailRay t, float tMax, INOUT(Trail) s) {
    // What no word of a sound tree is: it leads backwards, or out. The root's parent, NONE, is before it.
    bool enters = s.word < LEAF && !s.done;
    bool sound = s.word - s.parent - 1u < header.nodeCount - s.parent - 1u;
    bool reads = s.again || (enters && sound);
    if (reads || s.up) {
        uint node = choose(s.again, s.parent, choose(reads, s.word, 0u));
        uint place = node * t.texels;
        bool nearFirst = trailPlanes() == 0u && trailArity() > 2u;
        uvec4 head = nodes_at(choose(s.up, t.links + (s.parent >> 2), nearFirst ? place + t.down.x : place));
        Children met;
        Children all = readNode(ray, t, place, head, tMax, met);
        COUNT_NODE(reads)
        COUNT_LINK(s.up)
        COUNT_BOXES(choose(reads, countChildren(all), 0u))
        uint at = laneOf(all.keys, s.slot);
        if (trailArity() == 8u) at = choose((s.slot & 4u) != 0u, laneOf(all.moreKeys, s.slot), at);
        uint least = choose(s.again, at + s.from, 0u);
        met.keys.x = choose(met.keys.x >= least && reads, met.keys.x, NONE);
        met.keys.y = choose(met.keys.y >= least && reads, met.keys.y, NONE);
        if (trailArity() > 2u) {
            met.keys.z = choose(met.keys.z >= least && reads, met.keys.z, NONE);
            met.keys.w = choose(met.keys.w >= least && reads, met.keys.w, NONE);
        }
        if (trailArity() > 4u) {
            met.moreKeys.x = choose(met.moreKeys.x >= least && reads, met.moreKeys.x, NONE);
            met.moreKeys.y = choose(met.moreKeys.y >= least && reads, met.moreKeys.y, NONE);
            met.moreKeys.z = choose(met.moreKeys.z >= least && reads, met.moreKeys.z, NONE);
            met.moreKeys.w = choose(met.moreKeys.w >= least && reads, met.moreKeys.w, NONE);
        }
        if (reads) visitNearest(node, met, all, s);
        uint link = laneOf(head, s.parent);
        bool rises = s.up && (link >> 3) < s.parent;
        s.due.x = choose(rises, (s.due.x >> 1) | (s.due.y << 31), s.due.x);
        s.due.y = choose(rises, s.due.y >> 1, s.due.y);
        s.slot = choose(rises, link & SLOT, s.slot);
        s.parent = choose(rises, link >> 3, s.parent);
        s.up = false;
    }
}

// at.x: the place of the child at hand, parent << 3 | slot, and what is to be done there (AT_*). at.y: how many triangles of
// the leaf are tested. at.zw: `due`.
Trail takeUpTrail(uvec4 at) {
    Due none = Due(NONE, NONE, 0u);
    Trail s;
    bool fresh = at.x == 0u;
    s.again = (at.x & AT_CHILD) != 0u && at.x != TRAIL_DONE;
    s.word = choose(fresh, 0u, NONE);
    s.parent = choose(fresh, NONE, (at.x & PLACE) >> 3);
    s.slot = at.x & SLOT;
    s.tested = at.y;
    s.from = 0u;
    s.up = false;
    s.done = at.x == TRAIL_DONE;
    s.due = uvec2(at.z, at.w);
    s.a = none;
    s.b = none;
    s.c = none;
    s.d = none;
    s.earliest = choose(fresh, NONE, 0u);
    return s;
}

void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    TrailRay t = prepareTrail(ray);
    Trail s = takeUpTrail(at);
    uint most = maxSteps + choose(s.again, 1u, 0u);  // what is read again is no step forward
    for (uint step = 0u; !s.done && step < most; ++step) {
        stepBack(best.t, s);
        stepInto(ray, t, best.t, s);
        if (s.word >= LEAF && s.word != NONE) {
            uint triangle = ((s.word & ~LEAF) >> 4) + s.tested;
            bool hit = testTriangle(ray, min(triangle, header.triangleCount - 1u), best);
            s.tested += 1u;
            bool all = s.tested >= (s.word & 15u);
            s.word = choose(all, NONE, s.word);
            s.tested = choose(all, 0u, s.tested);
            if (ANY_HIT && hit) s.done = true;
        }
    }
    bool untouched = s.word == 0u && s.parent == NONE;
    bool left = s.word != NONE || (s.due.x | s.due.y) != 0u;
    uint what = choose(s.word == NONE, AT_END, AT_CHILD);
    at.x = choose(s.done || !left, TRAIL_DONE, choose(untouched, 0u, what | (s.parent << 3) | s.slot));
    at.y = s.tested;
    at.z = s.due.x;
    at.w = s.due.y;
}

// Each node is entered once and left upwards once, each child comes off the stack or is gone back to once, and each triangle
// is tested once.
float mostSteps() {
    return float(int(2u * TRAIL_ARITY + 4u)) * float(int(header.nodeCount)) + float(int(header.triangleCount)) + 64.0f;
}

bool isDone(uvec4 at) { return at.x == TRAIL_DONE; }
