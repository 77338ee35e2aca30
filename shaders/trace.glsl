// One ray from beginning to end, or as far as maxSteps lets it come: what the trace kernels and the CPU call.
//
// Whoever includes this declares before it, in this order: header, nodes_at(i), triangles_at(i), the constants ANY_HIT, WALK
// and SKIP_SEE_THROUGH, COUNT_NODE(did), COUNT_TRIANGLE(did); then intersect.glsl, triangles.glsl and structures/NAME.glsl.
//
// A structure's walk(ray, at, maxSteps, best) takes `at`, all 0 at the start, on by at most maxSteps loop iterations and
// improves `best`; isDone(at) says that nothing is left. Then best.primitive == NO_HIT, or best is the nearest hit in
// [tMin, tMax], ties to the lowest id; with ANY_HIT it is the first one met.

// Begins (at == 0) or takes up again the walk of `ray`. Returns true if it is finished. `hit` carries the best hit so far
// from call to call: distances are scaled by powers of two inside, so nothing is lost on the way.
bool traceRay(Ray ray, INOUT(uvec4) at, uint maxSteps, INOUT(Hit) hit) {
    WalkRay walkRay = prepareRay(ray, header.lo, header.hi, header.unit);
    bool found = hit.primitive != NO_HIT;
    Hit best = hit;
    best.t = found ? distanceInside(walkRay, header.unit, hit.t) : walkRay.tMax;
    uvec4 state = at;
    if (walkRay.valid && header.triangleCount > 0u) walk(walkRay, state, maxSteps, best);
    bool done = !walkRay.valid || header.triangleCount == 0u || isDone(state);
    at = state;
    hit = best;
    hit.t = best.primitive == NO_HIT ? uintBitsToFloat(0x7f800000u) : distanceOutside(walkRay, header.unit, best.t);
    return done;
}
