// Finds the closest triangle that `ray` hits, walking a tree of planes in any direction without a stack.
//
// Requires  nodes[] and triangles[] as built by host/structures/bsp.cpp (host/structures/bsp.hpp says how they lie).
// Ensures   as every walk (shaders/trace.glsl).
// Cost      Front to back. Where a ray passes both sides of a plane, the farther side waits: the last four that do are kept
//           in registers, and for those before them the walk goes down from the root again, led by a trail of one bit a
//           level.
// Source    Ize, Wald, Parker 2008, "Ray Tracing with the BSP Tree"; Laine 2010, "Restart Trail for Stackless BVH
//           Traversal"; Vaidyanathan et al. 2019, "Wide BVH Traversal with a Short Stack".
//
// Planes are n . x = d in coordinates relative to gridOrigin = lo, with |n| = |nx| + |ny| + |nz| <= 1. A ray is at signed
// distance s(t) = s0 + t * speed from it. What lies on one side has s <= 0, on the other s >= 0, and the walk asks for the t
// at which s <= SLACK, or s >= -SLACK, instead. SLACK is 128 u M (u = 2^-24, M as in prepareRay), because:
//   - the point of the ray at a hit's t lies within 53 u M, along each axis, of the triangle: so much is s off, as |n| <= 1;
//   - s0 is off by 7 u M: o - gridOrigin by u M an axis, products by u M, sums by 2 u M; |d| <= 2 M, so the last by 3 u M;
//   - t * speed is off by 3 u M at a hit, where t times the largest component of the direction is at most M: products by u,
//     sums by 2 u;
//   - SLACK - s0 is off by 3 u M; 1 / speed and the product after it by 6 u of the quotient, which is 12 u M of s at a hit;
//   - a triangle that sticks out of a side by no more than 14 u E, E the largest extent of the bounds, counts as within it:
//     28 u M, as E <= 2 M. So one that lies in its own splitting plane, rounded, is on one side only.
// In all 106 u M: a ray that hits a triangle gets, at the hit's t, to a leaf that holds it. None of this divides by a small
// number: as speed goes to 0, the quotient is as uncertain as it likes, but not s at the hit. A ray in the plane, or nearly,
// has |s| <= SLACK throughout and visits both sides: the parallel case is no case of its own. Nor is it as a division by
// zero: a speed below 2^-60 counts as that, which changes s at a hit by 2^-60 M. So each of the four cases of a plane (only
// the side the ray comes from, only the other, both, along the plane) is one comparison of intervals, inclusive.

CONSTANT uint BSP_LEAF = 0x80000000u;       // of a node's word w; then:
CONSTANT uint BSP_MORE = 0x40000000u;       //   the leaf goes on in the next node, or
CONSTANT uint BSP_LINKED = 0x20000000u;     //   (with MORE) in node z; bits 0-1: how many references here
CONSTANT uint BSP_NO_BELOW = 0x40000000u;   // if not a leaf: nothing lies on the negative side, or
CONSTANT uint BSP_NO_ABOVE = 0x20000000u;   //   the positive; bits 0-28: the first child
CONSTANT uint BSP_INDEX = 0x1fffffffu;
CONSTANT uint BSP_DONE = 0xffffffffu;       // in at.w

// What a walk needs of its ray for planes, and where in the ray the scene is.
struct BspRay {
    vec3 origin;     // relative to gridOrigin
    float slack;
    float enter;
    float leave;
};

// Where a walk is. A waiting side is (node, enter, leave, 0).
struct BspPlace {
    uint node;
    float enter;     // the stretch of the ray in the cell, slack included
    float leave;
    uint levelHigh;  // the bit of the level in the trail: the root's is the highest of 64
    uint levelLow;
    uint waitsHigh;  // the levels whose farther side waits
    uint waitsLow;
    uint waiting;    // how many of these are kept, from the deepest up
    float waitsFrom; // no triangle on a side that waits is hit nearer than this
    uvec4 first;     // the deepest side that waits, and so on
    uvec4 second;
    uvec4 third;
    uvec4 fourth;
    bool holdsLeaf;
    bool inChain;    // `node` is a part of a leaf after the first
    uint tested;     // references of this part
    uvec4 leaf;
};

BspRay prepareBsp(WalkRay ray) {
    BspRay b;
    precise vec3 origin = ray.origin - header.gridOrigin;
    b.origin = origin;
    b.slack = ray.tolerance * 8.0f;
    precise vec3 toLo = (header.lo - ray.origin) * ray.inverse;
    precise vec3 toHi = (header.hi - ray.origin) * ray.inverse;
    vec3 near = vec3(ray.inverse.x < 0.0f ? toHi.x : toLo.x, ray.inverse.y < 0.0f ? toHi.y : toLo.y,
                     ray.inverse.z < 0.0f ? toHi.z : toLo.z);
    vec3 far = vec3(ray.inverse.x < 0.0f ? toLo.x : toHi.x, ray.inverse.y < 0.0f ? toLo.y : toHi.y,
                    ray.inverse.z < 0.0f ? toLo.z : toHi.z);
    precise vec3 enter = near - ray.reach;
    precise vec3 leave = far + ray.reach;
    b.enter = maxOf(maxOf(enter.x, enter.y), maxOf(enter.z, ray.tMin));
    b.leave = minOf(minOf(leave.x, leave.y), minOf(leave.z, ray.tMax));
    return b;
}

// To the root: what is above and before `at`'s trail is left out on the way down.
void restartBsp(BspRay b, INOUT(BspPlace) place) {
    place.node = 0u;
    place.enter = b.enter;
    place.leave = b.leave;
    place.levelHigh = 0x80000000u;
    place.levelLow = 0u;
    place.waitsHigh = 0u;
    place.waitsLow = 0u;
    place.waiting = 0u;
    place.waitsFrom = LARGEST_FLOAT;
    place.holdsLeaf = false;
    place.inChain = false;
    place.tested = 0u;
}

// To the deepest side that waits; or to the end, if there is none or what was hit is nearer. Each call makes the trail
// larger, as a number, and takes one of the tree's sides: so a walk makes no more of them than there are nodes.
void leaveCell(BspRay b, float tMax, INOUT(BspPlace) place, INOUT(uvec4) at) {
    bool low = place.waitsLow != 0u;
    uint waits = pick(low, place.waitsLow, place.waitsHigh);
    uint level = waits & (~waits + 1u);
    at.x = pick(low, at.x, (at.x | level) & ~(level - 1u));
    at.y = pick(low, (at.y | level) & ~(level - 1u), 0u);
    at.z = 0u;
    at.w = pick(waits == 0u || tMax < place.waitsFrom, BSP_DONE, at.w + 1u);
    place.waitsLow = pick(low, waits & ~level, 0u);
    place.waitsHigh = pick(low, place.waitsHigh, waits & ~level);
    place.levelHigh = pick(low, 0u, level >> 1);
    place.levelLow = pick(low, level >> 1, level << 31);
    place.holdsLeaf = false;
    place.inChain = false;
    place.tested = 0u;
    if (place.waiting == 0u) {
        restartBsp(b, place);
    } else {
        place.node = place.first.x;
        place.enter = uintBitsToFloat(place.first.y);
        place.leave = uintBitsToFloat(place.first.z);
        place.first = place.second;
        place.second = place.third;
        place.third = place.fourth;
        --place.waiting;
    }
}

// Goes from an inner node to one of its children, and has the other wait if the ray passes both. False if it passes neither.
bool descend(WalkRay ray, BspRay b, float tMax, uvec4 node, INOUT(BspPlace) place, INOUT(uvec4) at) {
    float least = 9.5367431640625e-7f;  // 2^-20, the step of the components of n
    vec3 n = vec3(float(int(node.x & 0x1fffffu) - 0x100000) * least, float(int(node.y & 0x1fffffu) - 0x100000) * least,
                  float(int((node.x >> 21) | ((node.y >> 21) << 11)) - 0x100000) * least);
    precise float s = n.x * b.origin.x + n.y * b.origin.y + n.z * b.origin.z - uintBitsToFloat(node.z);
    precise float speed = n.x * ray.direction.x + n.y * ray.direction.y + n.z * ray.direction.z;
    bool rises = speed >= 0.0f;
    s = pick(rises, s, -s);
    speed = abs(speed);
    speed = pick(speed < 8.673617379884035e-19f, 8.673617379884035e-19f, speed);  // 2^-60
    precise float inverse = 1.0f / speed;
    precise float leaveNear = (b.slack - s) * inverse;
    precise float enterFar = (-b.slack - s) * inverse;
    leaveNear = lesser(leaveNear, place.leave);
    enterFar = greater(enterFar, place.enter);

    bool noBelow = (node.w & BSP_NO_BELOW) != 0u;
    bool noAbove = (node.w & BSP_NO_ABOVE) != 0u;
    bool entersNear = place.enter <= leaveNear && !(rises ? noBelow : noAbove);
    bool entersFar = enterFar <= place.leave && !(rises ? noAbove : noBelow);
    // Which way the trail leads depends on the ray alone, not on what it has hit: it must lead there again.
    bool takenUp = (at.x & place.levelHigh) != 0u || (at.y & place.levelLow) != 0u;
    bool goesFar = entersFar && (!entersNear || takenUp);
    uint below = node.w & BSP_INDEX;
    uint above = pick(noBelow || noAbove, below, below + 1u);
    // Children come after their parents, so every way down ends. Where they do not, the walk stays here and does not end,
    // which whoever makes it notices after mostSteps().
    bool sound = below > place.node && above < header.nodeCount;
    bool waits = entersNear && entersFar && !takenUp && enterFar <= tMax && sound;
    uint nearChild = rises ? below : above;
    uint farChild = rises ? above : below;

    if (waits) {
        place.fourth = place.third;
        place.third = place.second;
        place.second = place.first;
        place.first = uvec4(farChild, floatBitsToUint(enterFar), floatBitsToUint(place.leave), 0u);
        place.waiting = pick(place.waiting < 4u, place.waiting + 1u, 4u);
        place.waitsHigh = place.waitsHigh | place.levelHigh;
        place.waitsLow = place.waitsLow | place.levelLow;
        place.waitsFrom = lesser(enterFar, place.waitsFrom);
    }
    uint child = goesFar ? farChild : nearChild;
    place.enter = pick(goesFar, enterFar, place.enter);
    place.leave = pick(goesFar, place.leave, leaveNear);
    place.levelLow = (place.levelLow >> 1) | (place.levelHigh << 31);
    place.levelHigh = place.levelHigh >> 1;
    place.node = pick(sound, child, place.node);
    return entersNear || entersFar;
}

// One node: an inner one is left for a child, and a leaf is held until its references are tested. at.z of them are already
// if the walk was interrupted here: then this goes to the part of the leaf that is next.
void stepBsp(WalkRay ray, BspRay b, float tMax, INOUT(BspPlace) place, INOUT(uvec4) at) {
    if (place.holdsLeaf || at.w == BSP_DONE) return;
    bool leaves = place.enter > tMax;
    if (!leaves) {
        COUNT_NODE(true)
        uvec4 node = nodes_at(place.node);
        if (node.w < BSP_LEAF) {
            leaves = !descend(ray, b, tMax, node, place, at);
        } else {
            bool goesOn = !place.inChain && (node.w & BSP_LINKED) != 0u && at.z >= 2u;
            place.holdsLeaf = !goesOn;
            place.leaf = node;
            place.tested = pick(goesOn, (at.z - 2u) % 3u, pick(place.inChain, place.tested, at.z));
            uint next = node.z + (at.z - 2u) / 3u;
            bool sound = next > place.node && next < header.nodeCount;
            place.inChain = place.inChain || (goesOn && sound);
            place.node = pick(goesOn && sound, next, place.node);
        }
    }
    if (leaves) leaveCell(b, tMax, place, at);
}

// One reference of the leaf that is held, if any.
void testLeaf(WalkRay ray, BspRay b, INOUT(BspPlace) place, INOUT(uvec4) at, INOUT(Hit) best) {
    if (!place.holdsLeaf) return;
    uvec4 leaf = place.leaf;
    uint index = pick(place.tested == 0u, leaf.x, pick(place.tested == 1u, leaf.y, leaf.z));
    bool hit = testTriangle(ray, index, best);
    ++place.tested;
    ++at.z;
    if (place.tested >= (leaf.w & 3u)) {
        uint next = pick((leaf.w & BSP_LINKED) != 0u, leaf.z, place.node + 1u);
        bool goesOn = (leaf.w & BSP_MORE) != 0u;
        bool sound = next > place.node && next < header.nodeCount;
        place.node = pick(goesOn && !sound, place.node, next);
        place.tested = 0u;
        place.inChain = true;
        place.holdsLeaf = false;
        if (!goesOn) leaveCell(b, best.t, place, at);
    }
    at.w = pick(ANY_HIT && hit, BSP_DONE, at.w);
}

// at.x, at.y: the trail, the root's level in the highest bit of at.x: 1 where the farther of two sides was taken up.
// at.z: how many references of the leaf it leads to are tested. at.w: how many sides were taken up, or BSP_DONE.
void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    BspRay b = prepareBsp(ray);
    if (!(b.enter <= b.leave)) at.w = BSP_DONE;
    BspPlace place;
    restartBsp(b, place);
    place.first = uvec4(0u);
    place.second = uvec4(0u);
    place.third = uvec4(0u);
    place.fourth = uvec4(0u);
    place.leaf = uvec4(0u);
    for (uint step = 0u; at.w != BSP_DONE && step < maxSteps; ++step) {
        stepBsp(ray, b, best.t, place, at);
        stepBsp(ray, b, best.t, place, at);
        stepBsp(ray, b, best.t, place, at);
        testLeaf(ray, b, place, at, best);
    }
}

// No more sides than nodes, 64 levels down by three each time, and one step a reference: three a node.
float mostSteps() { return 26.0f * float(int(header.nodeCount)) + 64.0f; }

bool isDone(uvec4 at) { return at.w == BSP_DONE; }
