// Finds the closest triangle that `ray` hits, walking a uniform grid from cell to cell; at two levels, crowded cells hold a
// grid of their own (and with very many, see grid_nested.glsl).
//
// nodes[0]: cells along x, y, z, and the margin's bits. nodes[1]: where reference lists begin (which uvec4), how many words
// they are, how finely each axis divides (shift | most << 4, eight bits an axis), 0. Then words, four to a uvec4:
//   a cell       0: nothing in it; or 1 + the first word of its list; or CROWDED | log2 of the parts along an axis << 28 |
//                its parts: 1/8 of the number of the word that holds its own list as above, eight words before its first
//                part
//   a reference  the number of a triangle; LAST with the last one of a list
//
// Plane k of the grid lies at gridOrigin + k * gridStep, and so do those between (k is a fraction then): exactly, as the
// builder has chosen them. A cell holds all triangles that come within `margin` of it.
//
// A step   goes to the neighbour behind the nearest of the three planes ahead, along exactly one axis; distances to planes
//          come from their numbers, not from each other. Rounded, they still never decrease from plane to plane. So for
//          every distance t from the grid's near side to its far side the walk meets a cell, neither skipped nor repeated,
//          of which (as rounded) no plane ahead is nearer than t and none behind is farther. The point at t then lies within
//          3 u M of that cell, and a triangle hit at t within SLACK of the point, so within 67 u M of the cell: it is in the
//          cell's list if 67 u M <= margin. And it is in the list of a cell met so far if t <= the distance to the nearest
//          plane ahead: this ends the walk, at equality, too.
// Far off  a ray with 80 u M > margin walks slice by slice instead, along its main axis: it visits all cells of a slice
//          within 80 u M of where it passes the slice. Where that is the whole grid, it tries every triangle.
//
// Requires  nodes[] and triangles[] as built by host/structures/grid.cpp for header.walk: how many levels, less one.
// Ensures   as every walk (shaders/trace.glsl).
// Cost      Near: a walk meets at most one cell more than it passes planes. Links of a damaged structure cannot make it
//           loop, as indices of cells only move on; a list that runs on beyond the last does not end, which whoever makes
//           the walk notices after mostSteps().
// Source    Amanatides, Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing", without its sums; two levels:
//           Kalojanov, Billeter, Slusallek 2011, "Two-Level Grids for Ray Tracing on GPUs".

#define HAS_WALK(walk) ((walk) < 2u)  // for host/rays/cpu_walk.cpp.in

CONSTANT uint FINE_LOG = 5u;  // planes are numbered in 32nds of a cell, where cells may have parts
uint fineLog() { return WALK == 0u ? 0u : FINE_LOG; }

#include "structures/cells.glsl"

// Where a walk stands. Near: at.x and at.y hold the division's first plane along each axis (15 bits each) and what follows;
// at.z: 0, or 1 + the next reference to test; at.w: 0, or the word of the crowded cell that the division is a part of.
CONSTANT uint SEEN = 0x20000000u;  // the division has been looked at (and, if at.z == 0, its list has been tested)

// A cell, or a part of one, and what is to be done there.
struct Division {
    uvec3 first;     // its lower planes, in the finest division
    uvec3 sizeLogs;  // log2 of how many of those it spans
    uint crowd;      // at.w
    uint list;       // at.z
    bool seen;
    bool done;
};

// The lower planes of that of `count` divisions from plane `first` on, 2^sizeLogs finest planes long, in which the ray is at
// distance t as the walk has it: none of the planes behind is farther than t. Requires that t lies between the distances to
// the first and the last plane. The point at t is wrong by 9 u M at most, and its number by 2^-8: less than a division, so
// that one correction is enough.
uvec3 divisionAt(WalkRay ray, GridRay grid, uvec3 first, uvec3 sizeLogs, uvec3 count, float t) {
    precise vec3 point = grid.toOrigin + t * grid.direction;
    precise vec3 fine = point * grid.fineInverse - floats(first);
    vec3 last = floats((count << sizeLogs) - uvec3(1u));
    fine = vec3(fine.x > 0.0f ? fine.x : 0.0f, fine.y > 0.0f ? fine.y : 0.0f, fine.z > 0.0f ? fine.z : 0.0f);
    fine = vec3(fine.x < last.x ? fine.x : last.x, fine.y < last.y ? fine.y : last.y, fine.z < last.z ? fine.z : last.z);
    uvec3 number = uvec3(uint(int(fine.x)), uint(int(fine.y)), uint(int(fine.z))) >> sizeLogs;
    return first + (stepBack(ray, grid, first, sizeLogs, count, number, t) << sizeLogs);
}

// log2 of the finest planes that a part of a crowded cell spans, an axis.
uvec3 partSizeLogs(GridRay grid, uint word) {
    int wanted = int((word >> 28) & 7u);
    int x = min(wanted - int(grid.divisions & 15u), int((grid.divisions >> 4) & 15u));
    int y = min(wanted - int((grid.divisions >> 8) & 15u), int((grid.divisions >> 12) & 15u));
    int z = min(wanted - int((grid.divisions >> 16) & 15u), int((grid.divisions >> 20) & 15u));
    return uvec3(FINE_LOG - uint(max(x, 0)), FINE_LOG - uint(max(y, 0)), FINE_LOG - uint(max(z, 0)));
}

// The number of the word that tells what is in the division.
uint placeOf(GridRay grid, Division d) {
    if (WALK == 0u) return FIRST_CELL + d.first.x + grid.cells.x * (d.first.y + grid.cells.y * d.first.z);
    uvec3 cell = d.first >> FINE_LOG;
    uvec3 part = (d.first & uvec3((1u << FINE_LOG) - 1u)) >> d.sizeLogs;
    uint inCell = part.x + ((part.y + (part.z << (FINE_LOG - d.sizeLogs.y))) << (FINE_LOG - d.sizeLogs.x));
    uint inGrid = cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z);
    uint place = FIRST_CELL + (d.crowd != 0u ? (d.crowd & 0x0fffffffu) * 8u + inCell : inGrid);
    return min(place, (grid.lists << 2) - 1u);
}

// Goes on to the next division, if the present one has been seen, and looks up what is in it. Requires d.list == 0 and not
// d.done.
void stepDivision(WalkRay ray, GridRay grid, float tMax, INOUT(Division) d) {
    float t = 0.0f;
    uvec3 ahead = stepAhead(ray, grid, d.first, d.sizeLogs, t);
    uvec3 next = d.seen ? ahead : d.first;
    uvec3 cell = next >> fineLog();
    uvec3 present = d.first >> fineLog();
    bool outside = cell.x >= grid.cells.x || cell.y >= grid.cells.y || cell.z >= grid.cells.z;
    if (outside || (d.seen && tMax <= t)) {
        d.done = true;
        return;
    }
    bool stays = WALK != 0u && d.crowd != 0u && cell.x == present.x && cell.y == present.y && cell.z == present.z;
    if (WALK != 0u && !stays) {
        next = cell << FINE_LOG;
        d.sizeLogs = uvec3(FINE_LOG);
        d.crowd = 0u;
    }
    d.first = next;
    uint word = wordAt(placeOf(grid, d));
    COUNT_NODE(true)
    bool crowded = WALK != 0u && !stays && (word & CROWDED) != 0u;
    if (crowded) {
        t = d.seen ? t : grid.begin;
        d.sizeLogs = partSizeLogs(grid, word);
        d.first = divisionAt(ray, grid, next, d.sizeLogs, uvec3(1u) << (uvec3(FINE_LOG) - d.sizeLogs), t);
        d.crowd = word;
    }
    d.list = crowded ? 0u : word;
    d.seen = !crowded;
}

void walk(WalkRay ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) best) {
    GridRay grid = prepareGrid(ray);
    Division d;
    d.first = uvec3(at.x & 0x7fffu, at.x >> 16, at.y & 0x7fffu);
    d.crowd = at.w;
    d.sizeLogs = WALK != 0u && at.w != 0u ? partSizeLogs(grid, at.w) : uvec3(fineLog());
    d.list = at.z;
    d.seen = (at.y & SEEN) != 0u;
    d.done = grid.isFar || (at.y == 0u && !grid.meets);
    if (!d.done && at.y == 0u) d.first = divisionAt(ray, grid, uvec3(0u), d.sizeLogs, grid.cells, grid.begin);
    for (uint step = 0u; !d.done && step < maxSteps; ++step) {
        if (d.list == 0u) stepDivision(ray, grid, best.t, d);
        if (d.list == 0u && !d.done) stepDivision(ray, grid, best.t, d);
        if (d.list != 0u) {
            bool hit = stepList(ray, grid, d.list, best);
            d.done = ANY_HIT && hit;
        }
    }
    uint state = d.first.z | STARTED | (d.seen ? SEEN : 0u);
    if (!grid.isFar) at = d.done ? uvec4(0u, DONE, 0u, 0u) : uvec4(d.first.x | (d.first.y << 16), state, d.list, d.crowd);

    for (uint step = 0u; grid.isFar && at.y < DONE && step < maxSteps; ++step) stepFar(ray, grid, at, best);
}
