// Finds the closest triangle that `ray` hits, walking a tree whose nodes hold the boxes of all their children, near first.
//
// A node has TRAIL_ARITY slots for children, 2, 4 or 8: each has a box, and a word: the number of a node, or a leaf (the top bit,
// the number of its first triangle << 4 | how many), or NONE. Beyond the nodes each has a link: the number of its parent << 3 | its slot there.
//
// Children are visited in the order of their keys: the bits of the distance at which the ray enters the box, the last three of
// them replaced by the slot. A key says the same whenever the node is read again, as it does not depend on the best hit. So the
// place (parent, slot) of the child at hand tells all that is due: the children with higher keys of every node above it. Of
// these the walk keeps
//     `due`     one bit a level, bit 0 that of the parent: there are children with higher keys that the ray met
//     a to d    the four that come next, with their keys: what is no nearer than the best hit is dropped without being read
// and where those four are used up, it goes up by links to the lowest level that is due, reads the node again, and goes on after
// the slot it came from. (Unless `earliest`, before which none of the others is entered, is beyond the best hit: then it ends.)
//
// Requires  nodes[] and triangles[] as built by host/structures/bvh_trail.cpp for header.walk.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      no stack in memory. A walk that is taken up again reads one node twice, and has the four to find again.
//           Node numbers grow on the way down and fall on the way up. Where links say otherwise, the walk stays and does not end,
//           which whoever makes it notices after mostSteps().
// Source    Hapala et al. 2011, "Efficient Stack-less BVH Traversal for Ray Tracing"; Afra, Szirmay-Kalos 2014, "Stackless
//           Multi-BVH Traversal for CPU, MIC and GPU Ray Tracing" (a bit a level); Vaidyanathan, Woop, Benthin 2019, "Wide BVH
//           Traversal with a Short Stack"; planes of 8 bits: Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on
//           GPUs Through Compressed Wide BVHs".

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

// What tests of boxes need of a ray, for planes of 16 bits also the grid's.
struct TrailRay {
    uvec3 down;     // 1 where the direction is negative
    vec3 reach;
    vec3 step;
    vec3 enterBase;
    vec3 leaveBase;
    uint links;     // where they begin
    uint texels;    // of a node
};

// At most eight children: keys, NONE where the ray does not meet them or there is none, and words.
struct Children {
    uvec4 keys;
    uvec4 moreKeys;
    uvec4 words;
    uvec4 moreWords;
};

uint choose(bool first, uint a, uint b) { return mix(b, a, first); }
vec4 maxOf(vec4 a, vec4 b) { return intBitsToFloat(max(floatBitsToInt(a), floatBitsToInt(b))); }
vec4 minOf(vec4 a, vec4 b) { return intBitsToFloat(min(floatBitsToInt(a), floatBitsToInt(b))); }
uint laneOf(uvec4 v, uint i) { return choose((i & 2u) != 0u, choose((i & 1u) != 0u, v.w, v.z), choose((i & 1u) != 0u, v.y, v.x)); }

TrailRay prepareTrail(WalkRay ray) {
    TrailRay t;
    uint octant = octantOf(ray);
    t.down = uvec3(octant & 1u, (octant >> 1) & 1u, octant >> 2);
    // As for other quantised planes: 11 u M for the roundings of q * step + base. 8-bit planes lie at most 4 M beyond the
    // node's corner, and so 5 u M more.
    t.reach = trailPlanes() == 0u ? ray.reach : ray.reach * 1.25f;
    t.step = header.gridStep * ray.inverse;
    precise vec3 base = (header.gridOrigin - ray.origin) * ray.inverse;
    precise vec3 enterBase = base - t.reach;
    precise vec3 leaveBase = base + t.reach;
    t.enterBase = enterBase;
    t.leaveBase = leaveBase;
    uint arity = trailArity();
    t.texels = trailPlanes() == 0u ? (arity == 2u ? 4u : arity / 4u * 7u) : (trailPlanes() == 1u ? arity : arity / 2u + 2u);
    t.links = header.nodeCount * t.texels;
    return t;
}

// The keys of four children, from when the ray is between their planes along each axis.
uvec4 keysOf(WalkRay ray, vec4 enterX, vec4 enterY, vec4 enterZ, vec4 leaveX, vec4 leaveY, vec4 leaveZ, float tMax, uint slot,
             uvec4 words, INOUT(uvec4) met) {
    vec4 first = maxOf(maxOf(enterX, enterY), maxOf(enterZ, vec4(ray.tMin)));
    vec4 last = minOf(minOf(leaveX, leaveY), minOf(leaveZ, vec4(tMax)));
    uvec4 keys = (floatBitsToUint(first) & uvec4(~SLOT)) | uvec4(slot, slot + 1u, slot + 2u, slot + 3u);
    met.x = choose(first.x <= last.x && words.x != NONE, keys.x, NONE);
    met.y = choose(first.y <= last.y && words.y != NONE, keys.y, NONE);
    met.z = choose(first.z <= last.z && words.z != NONE, keys.z, NONE);
    met.w = choose(first.w <= last.w && words.w != NONE, keys.w, NONE);
    return keys;
}

// Boxes of floats: of four children, a texel an axis and side; of two, a texel an axis.
uvec4 floatKeys(WalkRay ray, TrailRay t, uint place, uvec4 x, uint slot, uvec4 words, float tMax, INOUT(uvec4) met) {
    uvec4 nearX, nearY, nearZ, farX, farY, farZ;
    if (trailArity() == 2u) {
        uvec4 y = nodes_at(place + 1u);
        uvec4 z = nodes_at(place + 2u);
        uvec4 turnedX = uvec4(x.z, x.w, x.x, x.y);
        uvec4 turnedY = uvec4(y.z, y.w, y.x, y.y);
        uvec4 turnedZ = uvec4(z.z, z.w, z.x, z.y);
        nearX = t.down.x != 0u ? turnedX : x;
        nearY = t.down.y != 0u ? turnedY : y;
        nearZ = t.down.z != 0u ? turnedZ : z;
        farX = t.down.x != 0u ? x : turnedX;
        farY = t.down.y != 0u ? y : turnedY;
        farZ = t.down.z != 0u ? z : turnedZ;
    } else {
        nearX = x;
        farX = nodes_at(place + 1u - t.down.x);
        nearY = nodes_at(place + 2u + t.down.y);
        farY = nodes_at(place + 3u - t.down.y);
        nearZ = nodes_at(place + 4u + t.down.z);
        farZ = nodes_at(place + 5u - t.down.z);
    }
    precise vec4 enterX = (uintBitsToFloat(nearX) - ray.origin.x) * ray.inverse.x - t.reach.x;
    precise vec4 enterY = (uintBitsToFloat(nearY) - ray.origin.y) * ray.inverse.y - t.reach.y;
    precise vec4 enterZ = (uintBitsToFloat(nearZ) - ray.origin.z) * ray.inverse.z - t.reach.z;
    precise vec4 leaveX = (uintBitsToFloat(farX) - ray.origin.x) * ray.inverse.x + t.reach.x;
    precise vec4 leaveY = (uintBitsToFloat(farY) - ray.origin.y) * ray.inverse.y + t.reach.y;
    precise vec4 leaveZ = (uintBitsToFloat(farZ) - ray.origin.z) * ray.inverse.z + t.reach.z;
    return keysOf(ray, enterX, enterY, enterZ, leaveX, leaveY, leaveZ, tMax, slot, words, met);
}

// Planes of numbers on a grid.
uvec4 gridKeys(WalkRay ray, vec3 step, vec3 enterBase, vec3 leaveBase, ivec4 nearX, ivec4 nearY, ivec4 nearZ, ivec4 farX,
               ivec4 farY, ivec4 farZ, uint slot, uvec4 words, float tMax, INOUT(uvec4) met) {
    precise vec4 enterX = vec4(nearX) * step.x + enterBase.x;
    precise vec4 enterY = vec4(nearY) * step.y + enterBase.y;
    precise vec4 enterZ = vec4(nearZ) * step.z + enterBase.z;
    precise vec4 leaveX = vec4(farX) * step.x + leaveBase.x;
    precise vec4 leaveY = vec4(farY) * step.y + leaveBase.y;
    precise vec4 leaveZ = vec4(farZ) * step.z + leaveBase.z;
    return keysOf(ray, enterX, enterY, enterZ, leaveX, leaveY, leaveZ, tMax, slot, words, met);
}

ivec4 halfOf(uvec4 pairs, uint upper) { return ivec4((pairs >> (upper * 16u)) & uvec4(0xffffu)); }

ivec4 bytesOf(uint word) { return ivec4(uvec4(word & 255u, (word >> 8) & 255u, (word >> 16) & 255u, word >> 24)); }

// Planes of 16 bits on the scene's grid: of each child and axis the lower one, and the upper one << 16.
uvec4 halfKeys(WalkRay ray, TrailRay t, uvec4 x, uvec4 y, uvec4 z, uint slot, uvec4 words, float tMax, INOUT(uvec4) met) {
    return gridKeys(ray, t.step, t.enterBase, t.leaveBase, halfOf(x, t.down.x), halfOf(y, t.down.y), halfOf(z, t.down.z),
                    halfOf(x, 1u - t.down.x), halfOf(y, 1u - t.down.y), halfOf(z, 1u - t.down.z), slot, words, tMax, met);
}

// Planes of 8 bits on the node's own grid: a word holds those of four children, along one axis and on one side.
uvec4 byteKeys(WalkRay ray, TrailRay t, uvec4 frame, uvec3 low, uvec3 high, uint slot, uvec4 words, float tMax, INOUT(uvec4) met) {
    vec3 scale = vec3(uintBitsToFloat((frame.w & 255u) << 23), uintBitsToFloat(((frame.w >> 8) & 255u) << 23),
                      uintBitsToFloat(((frame.w >> 16) & 255u) << 23));
    precise vec3 step = scale * ray.inverse;
    precise vec3 base = (vec3(uintBitsToFloat(frame.x), uintBitsToFloat(frame.y), uintBitsToFloat(frame.z)) - ray.origin) * ray.inverse;
    precise vec3 enterBase = base - t.reach;
    precise vec3 leaveBase = base + t.reach;
    uvec3 near = uvec3(choose(t.down.x != 0u, high.x, low.x), choose(t.down.y != 0u, high.y, low.y), choose(t.down.z != 0u, high.z, low.z));
    uvec3 far = uvec3(choose(t.down.x != 0u, low.x, high.x), choose(t.down.y != 0u, low.y, high.y), choose(t.down.z != 0u, low.z, high.z));
    return gridKeys(ray, step, enterBase, leaveBase, bytesOf(near.x), bytesOf(near.y), bytesOf(near.z), bytesOf(far.x),
                    bytesOf(far.y), bytesOf(far.z), slot, words, tMax, met);
}

// Reads the node at `place`, whose first texel is `head` (of four or eight boxes of floats, that of the near planes along x).
// Returns the keys of all children, whether the ray meets them or not; `met` has those that it meets no later than tMax.
Children readNode(WalkRay ray, TrailRay t, uint place, uvec4 head, float tMax, INOUT(Children) met) {
    Children all;
    all.moreKeys = uvec4(NONE);
    all.moreWords = uvec4(NONE);
    met.moreKeys = uvec4(NONE);
    if (trailArity() == 2u) {
        if (trailPlanes() == 0u) {
            uvec4 words = nodes_at(place + 3u);
            all.words = uvec4(words.x, words.y, NONE, NONE);
            all.keys = floatKeys(ray, t, place, head, 0u, all.words, tMax, met.keys);
        } else if (trailPlanes() == 1u) {
            uvec4 rest = nodes_at(place + 1u);
            all.words = uvec4(rest.z, rest.w, NONE, NONE);
            all.keys = halfKeys(ray, t, uvec4(head.x, head.y, 0u, 0u), uvec4(head.z, head.w, 0u, 0u), uvec4(rest.x, rest.y, 0u, 0u),
                                0u, all.words, tMax, met.keys);
        } else {
            uvec4 planes = nodes_at(place + 1u);  // an axis a word: low planes, then high ones
            uvec4 rest = nodes_at(place + 2u);
            all.words = uvec4(planes.w, rest.x, NONE, NONE);
            uvec3 low = uvec3(planes.x, planes.y, planes.z);
            all.keys = byteKeys(ray, t, head, low, low >> 16u, 0u, all.words, tMax, met.keys);
        }
        return all;
    }
    bool eight = trailArity() == 8u;
    if (trailPlanes() == 0u) {
        all.words = nodes_at(place + 6u);
        all.keys = floatKeys(ray, t, place, head, 0u, all.words, tMax, met.keys);
        if (eight) {
            all.moreWords = nodes_at(place + 13u);
            all.moreKeys = floatKeys(ray, t, place + 7u, nodes_at(place + 7u + t.down.x), 4u, all.moreWords, tMax, met.moreKeys);
        }
    } else if (trailPlanes() == 1u) {
        all.words = nodes_at(place + 3u);
        all.keys = halfKeys(ray, t, head, nodes_at(place + 1u), nodes_at(place + 2u), 0u, all.words, tMax, met.keys);
        if (eight) {
            all.moreWords = nodes_at(place + 7u);
            all.moreKeys = halfKeys(ray, t, nodes_at(place + 4u), nodes_at(place + 5u), nodes_at(place + 6u), 4u, all.moreWords,
                                    tMax, met.moreKeys);
        }
    } else {
        uvec4 xy = nodes_at(place + 1u);  // low, high along x; low, high along y
        uvec4 zz = nodes_at(place + 2u);  // low, high along z, of four children and of the next four
        all.words = nodes_at(place + 3u);
        all.keys = byteKeys(ray, t, head, uvec3(xy.x, xy.z, zz.x), uvec3(xy.y, xy.w, zz.y), 0u, all.words, tMax, met.keys);
        if (eight) {
            uvec4 next = nodes_at(place + 4u);
            all.moreWords = nodes_at(place + 5u);
            all.moreKeys = byteKeys(ray, t, head, uvec3(next.x, next.z, zz.z), uvec3(next.y, next.w, zz.w), 4u, all.moreWords,
                                    tMax, met.moreKeys);
        }
    }
    return all;
}

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

// Which of the children comes next, and those that follow it onto the stack. `node` is their parent.
void visitNearest(uint node, Children met, Children all, INOUT(Trail) s) {
    uvec4 k = met.keys;
    uint next = k.x;
    uvec4 later = uvec4(NONE);  // the second to the fifth
    uint sixth = NONE;
    uint count = 0u;
    order(k.x, k.y);
    if (trailArity() == 2u) {
        next = k.x;
        later.x = k.y;
        count = choose(k.y != NONE, 1u, 0u);
    } else {
        order(k.z, k.w);
        order(k.x, k.z);
        order(k.y, k.w);
        order(k.y, k.z);
        if (trailArity() == 8u) {
            uvec4 m = met.moreKeys;
            order(m.x, m.y);
            order(m.z, m.w);
            order(m.x, m.z);
            order(m.y, m.w);
            order(m.y, m.z);
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
            later.w = m.x;
            sixth = m.y;
        }
        next = k.x;
        later.x = k.y;
        later.y = k.z;
        later.z = k.w;
        count = choose(later.x != NONE, 1u, 0u) + choose(later.y != NONE, 1u, 0u) + choose(later.z != NONE, 1u, 0u) +
                choose(later.w != NONE, 1u, 0u);
    }
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

// at.x: the place of the child at hand, parent << 3 | slot, and what is to be done there (AT_*). at.y: how many triangles of the leaf
// are tested. at.zw: `due`.
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

// Each node is entered once and left upwards once, each child comes off the stack or is gone back to once, and each triangle is
// tested once.
float mostSteps() {
    return float(int(2u * TRAIL_ARITY + 4u)) * float(int(header.nodeCount)) + float(int(header.triangleCount)) + 64.0f;
}

bool isDone(uvec4 at) { return at.x == TRAIL_DONE; }
