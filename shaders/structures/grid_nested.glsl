// Finds the closest triangle that `ray` hits, walking a grid whose crowded cells hold a grid of their own, whose cells, the
// parts, do so too where they are crowded: for small things in a large place.
//
// nodes[] is as in grid.glsl, but for
//   a block      what a crowded cell's word leads to: eight words: what holds the cell's own list; the bits of its reach; 0.
//                Then one word a part, as of a cell: so it may be crowded, too
// The walk is that of grid.glsl; there stands why none is lost in cells, and why it ends. As parts are steps like cells,
// what is left to show is that a hit at t is in the list of the part that the walk meets at t.
//
// Parts    are met only if no point of the crowded cell is farther than the block's reach R from the ray's origin, along an
//          axis; else the cell's own list is tested. Then all that rounds is in proportion to R. The distance to a plane of
//          the cell is right to three roundings and u / 8 (steep), so the point at t lies within 3.2 u R of the part met
//          there. A hit at t of a triangle of extent E (the largest along an axis) lies within 53 u m of it
//          (intersect.glsl), and its corners within E + 53 u m of the point: m <= (R + E) (1 + 57 u), and the triangle comes
//          within 57 u (R + E) of the part. Parts hold those of their cell's own list that come within 64 u (R + E): and so
//          on, part by part, as the triangle is in the own list of every cell around. No distance to anything outside of the
//          cell is in it. Of spheres E is the diameter, and the same holds: their hits are as near (sphere.glsl).
//          In an instance hits are off by what the ray's tolerance says, not by distances there: this is asked to be within
//          R.
//
// Requires  nodes[] and triangles[] as built by host/structures/grid.cpp, nested.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      as grid.glsl's, and where a step leaves a block the way down from the cell again: a word or two a level.
// Source    Jevans, Wyvill 1989, "Adaptive Voxel Subdivision for Ray Tracing"; Amanatides, Woo 1987, "A Fast Voxel Traversal
//           Algorithm for Ray Tracing", without its sums.

#define HAS_WALK(walk) ((walk) == 2u)
#define A_WALK 2u

CONSTANT uint FINE_LOG = 15u;  // planes are numbered in 2^15ths of a cell
uint fineLog() { return FINE_LOG; }

#include "structures/cells.glsl"

// Where a walk stands. Near: at.x, at.y and at.z hold the division's first plane along each axis (25 bits each), at.y what
// cells.glsl says, too; at.w: 0, or 1 + the next reference to test.
CONSTANT uint PLANE_BITS = 0x1ffffffu;

// A cell or a part, and what is to be done there.
struct Division {
    uvec3 first;      // its lower planes, in the finest division
    uvec3 sizeLogs;   // log2 of how many of those it spans
    uint list;        // 0, or 1 + the next reference to test
    bool seen;        // it has been looked at (and, if list == 0, its list has been tested)
    bool done;        // with the walk
    uint block;       // of a part: the word of the innermost crowded cell around it; else 0
    uint wanted;      // sum of the block's and its outer ones' logs of parts along an axis
    uvec3 blockFirst; // the same of that cell as of the division
    uvec3 blockLogs;
    uvec3 next;       // planes of the division that the last step led to,
    uvec3 apart;      // the bits by which those before it differ
    float t;          // and where the ray is then
    uint resumes;     // taken up again, the walk has yet to come back to where it was, whose list is at this; else 0
};

CONSTANT uint RESUMES = 0x80000000u;

// The lower planes of that of `count` divisions from plane `first` on, 2^sizeLogs finest planes long, in which the ray is at
// distance t as the walk has it: none of the planes behind is farther than t. Requires that t lies between the distances to
// the first and the last plane. The point at t is wrong by 9 u M at most, or 9 u R in a block, and its number by less than a
// division (in a block by 2^-6, as R is 2^14 parts), so that one correction is enough.
uvec3 divisionAt(WalkRay ray, GridRay grid, uvec3 first, uvec3 sizeLogs, uvec3 count, float t) {
    precise vec3 corner = header.gridOrigin + floats(first) * grid.fineStep;
    precise vec3 point = (ray.origin - corner) + t * grid.direction;
    precise vec3 fine = point * grid.fineInverse;
    vec3 last = floats(count << sizeLogs);
    fine = vec3(fine.x > 0.0f ? fine.x : 0.0f, fine.y > 0.0f ? fine.y : 0.0f, fine.z > 0.0f ? fine.z : 0.0f);
    fine = vec3(fine.x < last.x ? fine.x : last.x, fine.y < last.y ? fine.y : last.y, fine.z < last.z ? fine.z : last.z);
    uvec3 number = min(uvec3(uint(int(fine.x)), uint(int(fine.y)), uint(int(fine.z))) >> sizeLogs, count - uvec3(1u));
    return first + (stepBack(ray, grid, first, sizeLogs, count, number, t) << sizeLogs);
}

// log2 of the finest planes that a division spans, an axis, if 2^wanted are wanted along a cell.
uvec3 sizeLogsOf(GridRay grid, uint wanted) {
    int x = min(int(wanted) - int(grid.divisions & 15u), int((grid.divisions >> 4) & 15u));
    int y = min(int(wanted) - int((grid.divisions >> 8) & 15u), int((grid.divisions >> 12) & 15u));
    int z = min(int(wanted) - int((grid.divisions >> 16) & 15u), int((grid.divisions >> 20) & 15u));
    return uvec3(FINE_LOG) - min(uvec3(uint(max(x, 0)), uint(max(y, 0)), uint(max(z, 0))), uvec3(FINE_LOG));
}

// The number of the word that tells what is in the cell, or the part of the division's block, with these lower planes.
uint placeOf(GridRay grid, Division d, uvec3 first) {
    uvec3 cell = first >> FINE_LOG;
    uvec3 part = (first - d.blockFirst) >> d.sizeLogs;
    uvec3 counts = (d.blockLogs - d.sizeLogs) & uvec3(31u);  // defined outside of blocks, too, where it is not used
    uint inBlock = part.x + ((part.y + (part.z << counts.y)) << counts.x);
    uint inGrid = cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z);
    uint place = FIRST_CELL + (d.block != 0u ? (d.block & 0x0fffffffu) * 8u + inBlock : inGrid);
    return min(place, (grid.lists << 2) - 1u);
}

// True if nothing in the division is farther from the ray's origin than `reach`, along an axis.
bool isWithinReach(WalkRay ray, GridRay grid, Division d, float reach) {
    precise vec3 lo = header.gridOrigin + floats(d.first) * grid.fineStep;
    precise vec3 hi = header.gridOrigin + floats(d.first + (uvec3(1u) << d.sizeLogs)) * grid.fineStep;
    float distance = distanceToBounds(ray.origin, lo, hi);
#if RAIG_INSTANCED
    if (INSTANCED) distance = ray.tolerance * 1048576.0f;  // SLACK / 64 u
#endif
    return distance <= reach;
}

bool wasIn(uvec3 apart, uvec3 sizeLogs) {
    uvec3 bits = apart >> sizeLogs;
    return (bits.x | bits.y | bits.z) == 0u;
}

// Into the parts of the crowded cell that the division is, if the ray may be; else to its own list. Where the last step did
// not leave the cell, its planes tell the part; where it came into it, the ray does.
void enterBlock(WalkRay ray, GridRay grid, uint word, INOUT(Division) d) {
    uvec4 block = nodes_at(min((word & 0x0fffffffu) * 2u, grid.lists - 1u));
    COUNT_NODE(true)
    uint more = (word >> 28) & 7u;
    bool sound = more > 0u && d.wanted <= 2u * FINE_LOG;  // else the structure is damaged, and the way down might not end
    if (!sound || !isWithinReach(ray, grid, d, uintBitsToFloat(block.y))) {
        d.list = block.x;
        return;
    }
    d.block = word;
    d.wanted += more;
    d.blockFirst = d.first;
    d.blockLogs = d.sizeLogs;
    d.sizeLogs = sizeLogsOf(grid, d.wanted);
    uvec3 met = divisionAt(ray, grid, d.blockFirst, d.sizeLogs, uvec3(1u) << (d.blockLogs - d.sizeLogs), d.t);
    uvec3 known = (d.next >> d.sizeLogs) << d.sizeLogs;
    bool was = wasIn(d.apart, d.blockLogs);
    d.first = uvec3(pick(was, known.x, met.x), pick(was, known.y, met.y), pick(was, known.z, met.z));
    d.list = 0u;
    d.seen = false;
}

// Goes on to the next division, if the present one has been seen, and looks up what is in it. Requires d.list == 0 and not
// d.done.
void stepDivision(WalkRay ray, GridRay grid, float tMax, INOUT(Division) d) {
    float t = 0.0f;
    uvec3 ahead = stepAhead(ray, grid, d.first, d.sizeLogs, t);
    if (d.seen) {
        d.next = ahead;
        uvec3 cell = d.next >> FINE_LOG;
        bool outside = cell.x >= grid.cells.x || cell.y >= grid.cells.y || cell.z >= grid.cells.z;
        if (outside || tMax <= t) {
            d.done = true;
            return;
        }
        d.apart = d.first ^ d.next;
        d.t = t;
        bool stays = d.block != 0u && wasIn(d.apart, d.blockLogs);
        d.block = pick(stays, d.block, 0u);
        d.wanted = pick(stays, d.wanted, 0u);
        d.sizeLogs = uvec3(pick(stays, d.sizeLogs.x, FINE_LOG), pick(stays, d.sizeLogs.y, FINE_LOG),
                           pick(stays, d.sizeLogs.z, FINE_LOG));
        d.first = (d.next >> d.sizeLogs) << d.sizeLogs;
    }
    uint word = wordAt(placeOf(grid, d, d.first));
    COUNT_NODE(true)
    d.list = word;
    d.seen = true;
    if ((word & CROWDED) != 0u) enterBlock(ray, grid, word, d);
    if (d.resumes != 0u && d.seen) {
        d.list = d.resumes & ~RESUMES;
        d.resumes = 0u;
    }
}

void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    GridRay grid = prepareGrid(ray);
    Division d;
    bool begins = at.y == 0u;
    d.first = uvec3(at.x, at.y & PLANE_BITS, at.z);
    d.sizeLogs = uvec3(FINE_LOG);
    d.done = grid.isFar || (begins && !grid.meets);
    if (begins && !d.done) d.first = divisionAt(ray, grid, uvec3(0u), d.sizeLogs, grid.cells, grid.begin);
    d.next = d.first;
    d.apart = begins ? ~uvec3(0u) : uvec3(0u);
    d.first = (d.first >> d.sizeLogs) << d.sizeLogs;
    d.t = grid.begin;
    d.list = 0u;
    d.seen = false;
    d.block = 0u;
    d.wanted = 0u;
    d.blockFirst = uvec3(0u);
    d.blockLogs = uvec3(0u);
    d.resumes = begins ? 0u : at.w | RESUMES;
    // A walk that is in between is taken on to the next division: so it stands where it can be taken up again. The way back
    // to there does not count: so it comes on, however few steps it may make.
    uint counts = 1u;
    for (uint step = 0u; !d.done && (step < maxSteps || !d.seen); step += counts) {
        counts = d.resumes != 0u ? 0u : 1u;
        if (d.list == 0u) stepDivision(ray, grid, best.t, d);
        if (d.list == 0u && !d.done) stepDivision(ray, grid, best.t, d);
        if (d.list != 0u) {
            bool hit = stepList(ray, grid, d.list, best);
            d.done = ANY_HIT && hit;
        }
    }
    uint state = d.first.y | STARTED;
    if (!grid.isFar) at = d.done ? uvec4(0u, DONE, 0u, 0u) : uvec4(d.first.x, state, d.first.z, d.list);

    for (uint step = 0u; grid.isFar && at.y < DONE && step < maxSteps; ++step) stepFar(ray, grid, at, best);
}
