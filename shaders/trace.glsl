// One ray from beginning to end, or as far as maxSteps lets it come: what the trace kernels and the CPU call.
//
// Whoever includes this declares before it, in this order: header, nodes_at(i), triangles_at(i), the constants ANY_HIT,
// WALK, SKIP_SEE_THROUGH and HAS_SPHERES, COUNT_NODE(did), COUNT_TRIANGLE(did), COUNT_BOXES(how many), COUNT_LINK(did),
// RAIG_INSTANCED (see triangles.glsl); then intersect.glsl, instances.glsl if that is 1, triangles.glsl and
// structures/NAME.glsl.
//
// A structure's walk(ray, at, maxSteps, best) takes `at`, all 0 at the start, on by at most maxSteps loop iterations and
// improves `best`; isDone(at) says that nothing is left. Then best.primitive == NO_HIT, or best is the nearest hit in
// [tMin, tMax], ties to the lowest id; with ANY_HIT it is the first one met. mostSteps() is at least as many iterations as
// any ray takes, all calls together, unless the structure is corrupt: where it may lead a walk around, the walk goes on for
// longer.

// Nothing met so far; or, taken up again, what `hit` says.
Hit bestSoFar(WalkRay walkRay, Hit hit) {
    Hit best = hit;
    best.t = hit.primitive != NO_HIT ? distanceInside(walkRay, header.unit, hit.t) : walkRay.tMax;
    return best;
}

Hit outside(WalkRay walkRay, Hit best) {
    Hit hit = best;
    hit.t = best.primitive == NO_HIT ? uintBitsToFloat(0x7f800000u) : distanceOutside(walkRay, header.unit, best.t);
    return hit;
}

// Begins (at == 0) or takes up again the walk of `ray`. Returns true if it is finished. `hit` carries the best hit so far
// from call to call: distances are scaled by powers of two inside, so nothing is lost on the way.
bool traceRay(Ray ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) hit) {
    WalkRay walkRay = prepareRay(ray, header.lo, header.hi, header.unit);
    Hit best = bestSoFar(walkRay, hit);
    uvec4 state = at;
    bool walks = walkRay.valid && header.triangleCount > 0u;
    if (walks) walk(walkRay, state, maxSteps, best);
    at = state;
    hit = outside(walkRay, best);
    return !walks || isDone(state);
}

#if RAIG_INSTANCED
// As traceRay, through two levels. `top`, 0 at the start, is the next node of the top tree, and `inside` says that the ray
// is in the instance there, where `at` is the bottom's.
//
// Rounds of the outer loop are what is counted: each makes at most PIECE steps in the top tree and as many in a bottom, so
// that a device which counts all loops of neighbours together comes to 2 PIECE a round, wherever each of them is. As the
// top's links only lead on, and bottoms' walks end, so do the rounds.
CONSTANT uint PIECE = 64u;
CONSTANT uint IN_INSTANCE = 0x80000000u;

bool traceInstances(Ray ray, INOUT(uint) top, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) hit) {
    StructureHeader whole = header;
    WalkRay world = prepareRay(ray, whole.lo, whole.hi, whole.unit);
    inside.ray = world;
    inside.best = bestSoFar(world, hit);
    uint end = whole.nodeCount;
    uint first = octantOf(world) * uint(int(whole.gridStep.x));
    uint instancesAt = uint(int(whole.gridStep.y)) * INSTANCES_UNIT;
    uint place = world.valid && whole.triangleCount > 0u ? top & ~IN_INSTANCE : end;
    bool goesOn = (top & IN_INSTANCE) != 0u;  // in the instance of the node at `place`
    uvec4 state = at;
    uint rounds = maxSteps / (2u * PIECE);
    rounds = rounds < 1u ? 1u : rounds;
    for (uint i = 0u; place < end && i < rounds; ++i) {
        uint found = 0u;
        if (goesOn) found = storedNodes_at((first + place) * 2u).w;
        for (uint step = 0u; found == 0u && place < end && step < PIECE; ++step) {
            COUNT_NODE(true)
            COUNT_BOXES(1u)
            found = stepTop(world, first, place);
        }
        if (found != 0u) {
            WalkRay local = enterInstance(found & ~TOP_LEAF, instancesAt);
            Hit best = Hit(localDistance(inside.best.t), 0.0f, 0.0f, NO_HIT);
            walk(local, state, PIECE, best);
            goesOn = !isDone(state);
            bool stops = ANY_HIT && inside.best.primitive != NO_HIT;
            place = stops ? end : (goesOn ? place : place + 1u);
            state = goesOn ? state : uvec4(0u);
        }
    }
    header = whole;
    at = state;
    top = goesOn && place < end ? place | IN_INSTANCE : place;
    hit = outside(world, inside.best);
    return place >= end;
}
#endif

// Traces two rays from beginning to end, the second only if `both`. Returns how many are not finished after maxSteps.
// A structure that can walk two rays in turn says so by WALKS_IN_PAIRS: for those that cannot, they go one after the other.
uint tracePair(Ray rayA, Ray rayB, bool both, uint maxSteps, INOUT(Hit) hitA, INOUT(Hit) hitB) {
#ifdef WALKS_IN_PAIRS
    WalkRay walkA = prepareRay(rayA, header.lo, header.hi, header.unit);
    WalkRay walkB = prepareRay(rayB, header.lo, header.hi, header.unit);
    Hit bestA = bestSoFar(walkA, hitA);
    Hit bestB = bestSoFar(walkB, hitB);
    uvec4 atA = walkA.valid ? uvec4(0u) : endOfWalk();
    uvec4 atB = walkB.valid && both ? uvec4(0u) : endOfWalk();
    walkPair(walkA, walkB, atA, atB, maxSteps, bestA, bestB);
    hitA = outside(walkA, bestA);
    hitB = outside(walkB, bestB);
    return (isDone(atA) ? 0u : 1u) + (isDone(atB) ? 0u : 1u);
#else
    uvec4 atA = uvec4(0u);
    uvec4 atB = uvec4(0u);
    bool doneA = traceRay(rayA, atA, maxSteps, hitA);
    bool doneB = !both || traceRay(rayB, atB, maxSteps, hitB);
    return (doneA ? 0u : 1u) + (doneB ? 0u : 1u);
#endif
}
