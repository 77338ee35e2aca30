// Nodes of trees that hold the boxes of all their children, as host/structures/bvh_trail.hpp lays them out, read and tested.
//
// Whoever includes this (trail.glsl) declares before it NONE, SLOT, trailArity() and trailPlanes().

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
uint laneOf(uvec4 v, uint i) {
    return choose((i & 2u) != 0u, choose((i & 1u) != 0u, v.w, v.z), choose((i & 1u) != 0u, v.y, v.x));
}

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
uvec4 keysOf(WalkRay ray, vec4 enterX, vec4 enterY, vec4 enterZ, vec4 leaveX, vec4 leaveY, vec4 leaveZ, float tMax,
             uint slot, uvec4 words, INOUT(uvec4) met) {
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
uvec4 byteKeys(WalkRay ray, TrailRay t, uvec4 frame, uvec3 low, uvec3 high, uint slot, uvec4 words, float tMax,
               INOUT(uvec4) met) {
    vec3 scale = vec3(uintBitsToFloat((frame.w & 255u) << 23), uintBitsToFloat(((frame.w >> 8) & 255u) << 23),
                      uintBitsToFloat(((frame.w >> 16) & 255u) << 23));
    precise vec3 step = scale * ray.inverse;
    precise vec3 base =
        (vec3(uintBitsToFloat(frame.x), uintBitsToFloat(frame.y), uintBitsToFloat(frame.z)) - ray.origin) * ray.inverse;
    precise vec3 enterBase = base - t.reach;
    precise vec3 leaveBase = base + t.reach;
    uvec3 near = uvec3(choose(t.down.x != 0u, high.x, low.x), choose(t.down.y != 0u, high.y, low.y),
                       choose(t.down.z != 0u, high.z, low.z));
    uvec3 far = uvec3(choose(t.down.x != 0u, low.x, high.x), choose(t.down.y != 0u, low.y, high.y),
                      choose(t.down.z != 0u, low.z, high.z));
    return gridKeys(ray, step, enterBase, leaveBase, bytesOf(near.x), bytesOf(near.y), bytesOf(near.z), bytesOf(far.x),
                    bytesOf(far.y), bytesOf(far.z), slot, words, tMax, met);
}

// Reads the node at `place`, whose first texel is `head` (of four or eight boxes of floats, that of the near planes along
// x). Returns the keys of all children, whether the ray meets them or not; `met` has those that it meets no later than tMax.
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
            all.keys = halfKeys(ray, t, uvec4(head.x, head.y, 0u, 0u), uvec4(head.z, head.w, 0u, 0u),
                                uvec4(rest.x, rest.y, 0u, 0u), 0u, all.words, tMax, met.keys);
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
            all.moreKeys = floatKeys(ray, t, place + 7u, nodes_at(place + 7u + t.down.x), 4u, all.moreWords, tMax,
                                     met.moreKeys);
        }
    } else if (trailPlanes() == 1u) {
        all.words = nodes_at(place + 3u);
        all.keys = halfKeys(ray, t, head, nodes_at(place + 1u), nodes_at(place + 2u), 0u, all.words, tMax, met.keys);
        if (eight) {
            all.moreWords = nodes_at(place + 7u);
            all.moreKeys = halfKeys(ray, t, nodes_at(place + 4u), nodes_at(place + 5u), nodes_at(place + 6u), 4u,
                                    all.moreWords, tMax, met.moreKeys);
        }
    } else {
        uvec4 xy = nodes_at(place + 1u);  // low, high along x; low, high along y
        uvec4 zz = nodes_at(place + 2u);  // low, high along z, of four children and of the next four
        all.words = nodes_at(place + 3u);
        all.keys = byteKeys(ray, t, head, uvec3(xy.x, xy.z, zz.x), uvec3(xy.y, xy.w, zz.y), 0u, all.words, tMax, met.keys);
        if (eight) {
            uvec4 next = nodes_at(place + 4u);
            all.moreWords = nodes_at(place + 5u);
            all.moreKeys = byteKeys(ray, t, head, uvec3(next.x, next.z, zz.z), uvec3(next.y, next.w, zz.w), 4u,
                                    all.moreWords, tMax, met.moreKeys);
        }
    }
    return all;
}
