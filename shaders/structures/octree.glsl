// Finds the closest triangle that `ray` hits, walking an octree without a stack.
//
// A cell is visited if the ray meets it, widened by the slack of all boxes (ray.reach), no later than the best hit: so a
// hit, which lies within the slack of some point of its triangle, is found in the leaf that holds this point. Which of a
// cell's eight parts are met is found at once, from where the ray crosses its three middle planes. They are visited in the
// order of octants as seen along the ray (`down` turns the axes that it descends): none is behind one that comes later.
//
// The path is the trail: the position of the cell as three integers, turned like the octants, one bit a level and axis. From
// it planes follow, and so when the ray is in any cell on the way; and the part that comes next is the path's number, plus
// one.
//
// Requires  nodes[] and triangles[] as built by host/structures/octree.cpp.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      no stack: where something is due above, the walk goes back to it through two registers or from the root. Each
//           time the path's number grows: so the walk ends, whatever the links, if after ages where one leads back: whoever
//           makes it notices after mostSteps(). Empty octants are never fetched.
// Source    Laine 2010, "Restart Trail for Stackless BVH Traversal"; Revelles et al. 2000, "An Efficient Parametric
//           Algorithm for Octree Traversal" (the planes' distances; not halved from those above here, which would add up
//           roundings).

CONSTANT uint LEAF = 0x80000000u;
CONSTANT uint EMPTY = 0xffffffffu;
CONSTANT uint LAST = 0x80000000u;
CONSTANT uint DONE = 0xffffffffu;
CONSTANT uint ROOT = 1u;
CONSTANT uint SIDE = 4194304u;  // 2^22 steps
CONSTANT uint MAX_LEVELS = 20u;
CONSTANT float INFINITE = 3.4028234e38f;

struct Cell {
    uint node;       // its record; or a place in a leaf's list | LEAF; or EMPTY
    uint width;      // in steps
    vec3 enter;      // when the ray comes between its planes, an axis each, with slack
    vec3 leave;
};

struct Descent {
    Cell here;
    uvec3 path;
    uint chosen;     // half the width of the cell where the path is not chosen yet, only a lower bound of it
    uint due;        // half widths of the cells on the way that have parts to be visited
    float earliest;  // no part that is due begins before
    uint last;       // the records of the last two such cells
    uint before;
    uint stacked;    // how many of the two are known
    vec3 enter;      // of the whole scene
    vec3 leave;
    bvec3 down;      // the axes along which the ray descends
    uint end;        // of the records
};

vec3 maxima(vec3 a, vec3 b) { return vec3(maxOf(a.x, b.x), maxOf(a.y, b.y), maxOf(a.z, b.z)); }
vec3 minima(vec3 a, vec3 b) { return vec3(minOf(a.x, b.x), minOf(a.y, b.y), minOf(a.z, b.z)); }

// The octants of the mask, or of a path's bit, with the descending axes turned; and back.
uint turnedOctants(uint mask, bvec3 down) {
    uint m = pick(down.x, ((mask & 0x55u) << 1) | ((mask >> 1) & 0x55u), mask);
    m = pick(down.y, ((m & 0x33u) << 2) | ((m >> 2) & 0x33u), m);
    return pick(down.z, ((m & 0x0fu) << 4) | (m >> 4), m);
}

// When the ray crosses the planes at `steps`, turned.
vec3 crossing(WalkRay ray, uvec3 steps, bvec3 down) {
    uvec3 real = mix(steps, SIDE - steps, down);
    precise vec3 offset = vec3(ivec3(real)) * header.gridStep;
    precise vec3 plane = header.gridOrigin + offset;
    precise vec3 t = (plane - ray.origin) * ray.inverse;
    return t;
}

float entering(Cell cell) { return maxOf(maxOf(cell.enter.x, cell.enter.y), cell.enter.z); }

// Which of the parts of a cell the ray meets, if along each axis it is in the lower half from `enter` to `middleLeave` and
// in the upper one from `middleEnter` to `leave`.
uint partsMet(vec3 enter, vec3 middleEnter, vec3 middleLeave, vec3 leave) {
    float e0 = maxOf(enter.x, enter.y);
    float e1 = maxOf(middleEnter.x, enter.y);
    float e2 = maxOf(enter.x, middleEnter.y);
    float e3 = maxOf(middleEnter.x, middleEnter.y);
    float l0 = minOf(middleLeave.x, middleLeave.y);
    float l1 = minOf(leave.x, middleLeave.y);
    float l2 = minOf(middleLeave.x, leave.y);
    float l3 = minOf(leave.x, leave.y);
    uint met = pick(maxOf(e0, enter.z) <= minOf(l0, middleLeave.z), 1u, 0u);
    met |= pick(maxOf(e1, enter.z) <= minOf(l1, middleLeave.z), 2u, 0u);
    met |= pick(maxOf(e2, enter.z) <= minOf(l2, middleLeave.z), 4u, 0u);
    met |= pick(maxOf(e3, enter.z) <= minOf(l3, middleLeave.z), 8u, 0u);
    met |= pick(maxOf(e0, middleEnter.z) <= minOf(l0, leave.z), 16u, 0u);
    met |= pick(maxOf(e1, middleEnter.z) <= minOf(l1, leave.z), 32u, 0u);
    met |= pick(maxOf(e2, middleEnter.z) <= minOf(l2, leave.z), 64u, 0u);
    met |= pick(maxOf(e3, middleEnter.z) <= minOf(l3, leave.z), 128u, 0u);
    return met;
}

// Goes from an inner cell to the part that the path names, or to the first one met from there on where it is not chosen yet.
void stepDown(WalkRay ray, INOUT(Descent) s) {
    bool reads = s.here.node < LEAF;
    uvec4 record = nodes_at(pick(reads, s.here.node, 0u));
    COUNT_NODE(reads)
    bool isInner = record.x < LEAF;
    bool inner = reads && isInner;
    uint middle = s.here.width >> 1;
    vec3 t = crossing(ray, (s.path & ~(s.here.width - 1u)) + middle, s.down);
    precise vec3 from = t - ray.reach;
    precise vec3 to = t + ray.reach;
    vec3 middleEnter = maxima(s.here.enter, from);
    vec3 middleLeave = minima(s.here.leave, to);
    uint met = partsMet(s.here.enter, middleEnter, middleLeave, s.here.leave) & turnedOctants(record.y & 255u, s.down);

    uint octant = pick((s.path.x & middle) != 0u, 1u, 0u) | pick((s.path.y & middle) != 0u, 2u, 0u) |
                  pick((s.path.z & middle) != 0u, 4u, 0u);
    bool isChosen = middle > s.chosen;
    uint wanted = met & (pick(isChosen, 1u, 255u) << octant);
    uint part = wanted & (~wanted + 1u);
    uint rest = met & ~((part << 1) - 1u);
    bool found = part != 0u;
    bool goes = inner && found;
    bool isRest = rest != 0u;
    bool leavesRest = goes && isRest;
    bvec3 upper = bvec3((part & 0xaau) != 0u, (part & 0xccu) != 0u, (part & 0xf0u) != 0u);
    uvec3 path = (s.path & ~middle) | mix(uvec3(0u), uvec3(middle), upper);
    s.path = mix(s.path, path, bvec3(goes));
    s.chosen = pick(goes && !isChosen, middle >> 1, s.chosen);

    // What is due lies in the upper half along an axis along which this part does not.
    vec3 due = mix(from, vec3(INFINITE), upper);
    s.earliest = pick(leavesRest, minOf(s.earliest, minOf(due.x, minOf(due.y, due.z))), s.earliest);
    s.due |= pick(leavesRest, middle, 0u);
    s.before = pick(leavesRest, s.last, s.before);
    s.last = pick(leavesRest, s.here.node, s.last);
    s.stacked = pick(leavesRest, min(s.stacked + 1u, 2u), s.stacked);

    uint next = record.x + uint(bitCount(record.y & 255u & (turnedOctants(part, s.down) - 1u)));
    bool isInside = next < s.end;
    bool isDeep = middle <= 2u;  // no cell of a sound tree is
    uint node = pick(isInner, pick(found && isInside && !isDeep, next, EMPTY), record.x);
    s.here.node = pick(reads, node, s.here.node);
    s.here.enter = mix(s.here.enter, mix(s.here.enter, middleEnter, upper), bvec3(goes));
    s.here.leave = mix(s.here.leave, mix(middleLeave, s.here.leave, upper), bvec3(goes));
    s.here.width = pick(goes, middle, s.here.width);
}

// Puts the walk into record `node`, of a cell that is `width` wide on the path.
void enterCell(WalkRay ray, bool does, uint node, uint width, float tMax, INOUT(Descent) s) {
    uvec3 low = s.path & ~(width - 1u);
    precise vec3 from = crossing(ray, low, s.down) - ray.reach;
    precise vec3 to = crossing(ray, low + width, s.down) + ray.reach;
    vec3 enter = maxima(s.enter, from);
    vec3 leave = minima(s.leave, to);
    leave.x = minOf(leave.x, tMax);
    bool isMet = maxOf(maxOf(enter.x, enter.y), enter.z) <= minOf(minOf(leave.x, leave.y), leave.z);
    s.here.node = pick(does, pick(isMet, node, EMPTY), s.here.node);
    s.here.width = pick(does, width, s.here.width);
    s.here.enter = mix(s.here.enter, enter, bvec3(does));
    s.here.leave = mix(s.here.leave, leave, bvec3(does));
}

// Goes to the deepest cell on the way that has a part due, if that may hold a nearer hit. Returns false if nothing is left.
bool stepBack(WalkRay ray, bool does, float tMax, INOUT(Descent) s) {
    bool isDue = s.due != 0u;
    bool isInTime = s.earliest <= tMax;
    uint middle = s.due & (~s.due + 1u);
    uvec3 path = s.path & ~(middle - 1u);
    uint carryX = path.x & middle;
    uint carryY = path.y & carryX;
    path = uvec3(path.x ^ middle, path.y ^ carryX, path.z ^ carryY);
    s.path = mix(s.path, path, bvec3(does));
    s.chosen = pick(does, middle, s.chosen);
    bool stacked = s.stacked > 0u;
    bool restarts = does && !stacked;
    enterCell(ray, does, pick(stacked, s.last, ROOT), pick(stacked, middle << 1, SIDE), tMax, s);
    s.due = pick(does, pick(stacked, s.due & ~middle, 0u), s.due);
    s.earliest = pick(restarts, INFINITE, s.earliest);
    s.last = pick(does, s.before, s.last);
    s.stacked = pick(does && stacked, s.stacked - 1u, s.stacked);
    return isDue && isInTime;
}

// at.xyz: the path, doubled; in x also, as the lowest bit set, half the width of the cell where it is to be chosen. at.w: 0,
// or the place in a leaf's list, or DONE.
void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    uvec4 sizes = nodes_at(0u);
    Descent s;
    s.down = bvec3(ray.inverse.x < 0.0f, ray.inverse.y < 0.0f, ray.inverse.z < 0.0f);
    precise vec3 enter = (mix(header.lo, header.hi, s.down) - ray.origin) * ray.inverse - ray.reach;
    precise vec3 leave = (mix(header.hi, header.lo, s.down) - ray.origin) * ray.inverse + ray.reach;
    s.enter = maxima(enter, vec3(ray.tMin));
    s.leave = minima(leave, vec3(ray.tMax));
    uint marker = at.x & (~at.x + 1u);
    s.path = uvec3(at.x ^ marker, at.y, at.z) >> 1u;
    s.chosen = pick(at.x == 0u, SIDE >> 1, marker);
    s.due = 0u;
    s.earliest = INFINITE;
    s.last = ROOT;
    s.before = ROOT;
    s.stacked = 0u;
    s.end = sizes.x;
    s.here.node = ROOT;
    s.here.width = SIDE;
    s.here.enter = s.enter;
    s.here.leave = s.leave;
    enterCell(ray, true, ROOT, SIDE, best.t, s);

    // A walk that is taken up again: down to where the path ends.
    for (uint i = 0u; s.here.node < LEAF && (s.here.width >> 1) > s.chosen && i < MAX_LEVELS; ++i) stepDown(ray, s);
    bool isThere = s.here.node != EMPTY;
    bool isInList = at.w != 0u;
    s.here.node = pick(isThere && isInList, LEAF | at.w, s.here.node);

    for (uint step = 0u; at.w != DONE && step < maxSteps; ++step) {
        stepDown(ray, s);
        stepDown(ray, s);
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
        bool left = stepBack(ray, back, best.t, s);
        at.w = pick(back && !left, DONE, at.w);
    }
    bool stands = at.w != DONE;
    bool isListed = s.here.node - LEAF < EMPTY - LEAF;
    at.x = (s.path.x << 1) | s.chosen;
    at.y = s.path.y << 1;
    at.z = s.path.z << 1;
    at.w = pick(stands, pick(isListed, s.here.node - LEAF, 0u), at.w);
}

// Each record is left once for each of its octants at most, 20 levels down by two each time, and one step a word of the
// lists.
float mostSteps() {
    uvec4 sizes = nodes_at(0u);
    return 24.0f * float(int(header.nodeCount)) + float(int(sizes.y)) + 64.0f;
}

bool isDone(uvec4 at) { return at.w == DONE; }
