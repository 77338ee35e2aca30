// What walks of grids have in common (grid.glsl, grid_nested.glsl): distances to planes, lists, and the walk from far off.
//
// Whoever includes this defines before it fineLog(), log2 of how many planes a cell is divided by at most, parts of parts
// included, along an axis.

CONSTANT uint CROWDED = 0x80000000u;
CONSTANT uint LAST = 0x80000000u;
CONSTANT uint FIRST_CELL = 8u;

// Where a walk from far off stands: at.x: slices done; at.y: cells of the slice done, or DONE; at.z: 0, or 1 + the next
// reference to test, or triangles done. Others keep these in at.y, too.
CONSTANT uint STARTED = 0x40000000u;
CONSTANT uint DONE = 0x80000000u;

// A ray's relation to the grid.
struct GridRay {
    uvec3 cells;
    uvec3 ahead;       // 1 where the ray goes towards higher numbers, else 0
    vec3 fineStep;     // from plane to plane, the finest
    vec3 fineInverse;  // 1 / that
    vec3 direction;
    vec3 toOrigin;     // the ray's, from the grid's
    uint lists;
    uint listWords;
    uint divisions;
    float slack;       // 80 u M
    float begin;       // where the walk begins, and if it does
    bool meets;
    bool isFar;
};

vec3 floats(uvec3 v) { return vec3(float(int(v.x)), float(int(v.y)), float(int(v.z))); }

uint lane(uvec4 v, uint i) { return (i & 2u) == 0u ? ((i & 1u) == 0u ? v.x : v.y) : ((i & 1u) == 0u ? v.z : v.w); }

uint wordAt(uint i) { return lane(nodes_at(i >> 2), i); }

// Distances to one plane an axis, by their numbers in the finest division. Exact up to the difference.
vec3 planeDistances(WalkRay ray, GridRay grid, uvec3 fine) {
    precise vec3 plane = header.gridOrigin + floats(fine) * grid.fineStep;
    precise vec3 distance = (plane - ray.origin) * ray.inverse;
    return distance;
}

// Of `count` divisions from plane `first` on, 2^sizeLogs finest planes long: the one before `number` where the ray, at
// distance t, has not come as far, along each axis. The first one that it meets stays.
uvec3 stepBack(WalkRay ray, GridRay grid, uvec3 first, uvec3 sizeLogs, uvec3 count, uvec3 number, float t) {
    vec3 enter = planeDistances(ray, grid, first + ((number + uvec3(1u) - grid.ahead) << sizeLogs));
    uvec3 back = uvec3(grid.ahead.x == 1u ? max(number.x, 1u) - 1u : min(number.x + 1u, count.x - 1u),
                       grid.ahead.y == 1u ? max(number.y, 1u) - 1u : min(number.y + 1u, count.y - 1u),
                       grid.ahead.z == 1u ? max(number.z, 1u) - 1u : min(number.z + 1u, count.z - 1u));
    return uvec3(enter.x > t ? back.x : number.x, enter.y > t ? back.y : number.y, enter.z > t ? back.z : number.z);
}

// From a division's lower planes to those of its neighbour behind the nearest of the three planes ahead, which is at
// distance t.
uvec3 stepAhead(WalkRay ray, GridRay grid, uvec3 first, uvec3 sizeLogs, INOUT(float) t) {
    vec3 leave = planeDistances(ray, grid, first + (grid.ahead << sizeLogs));
    bool alongX = leave.x <= leave.y && leave.x <= leave.z;
    bool alongY = !alongX && leave.y <= leave.z;
    t = alongX ? leave.x : (alongY ? leave.y : leave.z);
    uvec3 move = uvec3(alongX ? 1u : 0u, alongY ? 1u : 0u, alongX || alongY ? 0u : 1u);
    // Backwards it wraps around, and out of the grid, too.
    return first + ((move * (grid.ahead * 2u - uvec3(1u))) << sizeLogs);
}

float leastOf(vec3 v) { return v.x <= v.y && v.x <= v.z ? v.x : (v.y <= v.z ? v.y : v.z); }

float mostOf(vec3 v) { return v.x >= v.y && v.x >= v.z ? v.x : (v.y >= v.z ? v.y : v.z); }

GridRay prepareGrid(WalkRay ray) {
    GridRay g;
    uvec4 shape = nodes_at(0u);
    uvec4 lists = nodes_at(1u);
    g.cells = uvec3(shape.x, shape.y, shape.z);
    g.lists = lists.x;
    g.listWords = lists.y;
    g.divisions = lists.z;
    g.slack = ray.tolerance * 5.0f;
    g.isFar = g.slack > uintBitsToFloat(shape.w);
    uint behind = octantOf(ray);
    g.ahead = uvec3(1u - (behind & 1u), 1u - ((behind >> 1) & 1u), 1u - (behind >> 2));
    g.fineStep = header.gridStep * uintBitsToFloat((127u - fineLog()) << 23);
    g.fineInverse = vec3(1.0f) / g.fineStep;
    precise vec3 direction = vec3(1.0f / ray.inverse.x, 1.0f / ray.inverse.y, 1.0f / ray.inverse.z);
    precise vec3 toOrigin = ray.origin - header.gridOrigin;
    g.direction = direction;
    g.toOrigin = toOrigin;
    uvec3 whole = g.cells << fineLog();
    vec3 enter = planeDistances(ray, g, whole * (uvec3(1u) - g.ahead));
    vec3 leave = planeDistances(ray, g, whole * g.ahead);
    float first = mostOf(enter);
    float last = leastOf(leave);
    g.begin = first > ray.tMin ? first : ray.tMin;
    g.meets = g.begin <= (last < ray.tMax ? last : ray.tMax);
    return g;
}

// Tests reference `list` - 1, goes on to the next one of its list or, after the last, to 0, and says if it was hit.
bool stepList(WalkRay ray, GridRay grid, INOUT(uint) list, INOUT(Hit) best) {
    uint place = list - 1u;
    uint word = place < grid.listWords ? wordAt((grid.lists << 2) + place) : 0u;
    list = (word & LAST) != 0u ? 0u : list + 1u;
    return testTriangle(ray, min(word & ~LAST, header.triangleCount - 1u), best);
}

// Which cells a far ray must visit in slice `slice` of its main axis: from `lo` for `size` cells; none has size 0.
// Returns the distance before which it cannot meet what is in the slice.
float sliceCells(WalkRay ray, GridRay grid, uint slice, INOUT(uvec3) lo, INOUT(uvec3) size) {
    bool isX = ray.axisZ == 0u;
    bool isY = ray.axisZ == 1u;
    uint forwards = isX ? grid.ahead.x : (isY ? grid.ahead.y : grid.ahead.z);
    uint count = isX ? grid.cells.x : (isY ? grid.cells.y : grid.cells.z);
    uint number = forwards == 1u ? slice : count - 1u - slice;
    vec3 enters = planeDistances(ray, grid, (uvec3(number) + uvec3(1u) - grid.ahead) << fineLog());
    vec3 leaves = planeDistances(ray, grid, (uvec3(number) + grid.ahead) << fineLog());
    precise vec3 reach = vec3(abs(ray.inverse.x), abs(ray.inverse.y), abs(ray.inverse.z)) * grid.slack;
    precise vec3 enter = enters - reach;
    precise vec3 leave = leaves + reach;
    float first = isX ? enter.x : (isY ? enter.y : enter.z);
    float last = isX ? leave.x : (isY ? leave.y : leave.z);

    precise vec3 a = grid.toOrigin + first * grid.direction;
    precise vec3 b = grid.toOrigin + last * grid.direction;
    precise vec3 low = (min(a, b) - vec3(grid.slack)) / header.gridStep;
    precise vec3 high = (max(a, b) + vec3(grid.slack)) / header.gridStep;
    vec3 cells = floats(grid.cells);
    low = max(min(floor(low), cells), vec3(0.0f));
    high = max(min(floor(high) + vec3(1.0f), cells), low);
    high = last < ray.tMin ? low : high;
    lo = uvec3(isX ? number : uint(int(low.x)), isY ? number : uint(int(low.y)), isX || isY ? uint(int(low.z)) : number);
    size = uvec3(isX ? 1u : uint(int(high.x - low.x)), isY ? 1u : uint(int(high.y - low.y)),
                 isX || isY ? uint(int(high.z - low.z)) : 1u);
    return first;
}

// One cell, or one triangle, of a walk from far off.
void stepFar(WalkRay ray, GridRay grid, INOUT(uvec4) at, INOUT(Hit) best) {
    vec3 extent = header.hi - header.lo;
    if (grid.slack * 4.0f >= mostOf(extent)) {
        bool hit = testTriangle(ray, at.z, best);
        at.z += 1u;
        at.y = at.z >= header.triangleCount || (ANY_HIT && hit) ? DONE : STARTED;
        return;
    }
    if (at.z != 0u) {
        bool hit = stepList(ray, grid, at.z, best);
        if (ANY_HIT && hit) at.y = DONE;
        return;
    }
    uvec3 lo = uvec3(0u);
    uvec3 size = uvec3(0u);
    uint slices = ray.axisZ == 0u ? grid.cells.x : (ray.axisZ == 1u ? grid.cells.y : grid.cells.z);
    bool none = at.x >= slices;
    float first = sliceCells(ray, grid, none ? 0u : at.x, lo, size);
    if (none || first > best.t) {
        at = uvec4(0u, DONE, 0u, 0u);
        return;
    }
    uint count = size.x * size.y * size.z;
    if (at.y >= count) {
        at = uvec4(at.x + 1u, 0u, 0u, 0u);
        return;
    }
    size = max(size, uvec3(1u));
    uvec3 cell = lo + uvec3(at.y % size.x, (at.y / size.x) % size.y, at.y / (size.x * size.y));
    uint word = wordAt(FIRST_CELL + cell.x + grid.cells.x * (cell.y + grid.cells.y * cell.z));
    COUNT_NODE(true)
    if (WALK != 0u && (word & CROWDED) != 0u) word = wordAt(min((word & 0x0fffffffu) * 8u, (grid.lists << 2) - 1u));
    at.y += 1u;
    at.z = word;
}

// Far off, each cell is met once, and then every triangle; each list is gone through once a cell and part that has it.
// Twice, as slices may be empty.
float mostSteps() {
    uvec4 lists = nodes_at(1u);
    float words = 4.0f * float(int(lists.x)) + float(int(lists.y));
    return 2.0f * words + 2.0f * float(int(header.triangleCount)) + 4096.0f;
}

bool isDone(uvec4 at) { return at.y == DONE; }
