// What an item buffer says a ray may meet first: tested before all else, the very test that the walk makes. Then the walk
// only has to look as far as that: it proves that nothing is nearer, or finds it. So hits are those of a walk without hints.
//
// Whoever includes this declares what trace.glsl asks for, rayAt() and hints[] (HINTS_A_RAY each, those that there are
// first), and includes trace.glsl and shared/items.glsl.

// The nearest hit on what the hints of `ray` name, as far as traceRay() can take it up without loss; none where the ray
// meets none of that.
Hit hitOfHints(uint ray) {
    Hit none = Hit(0.0f, 0.0f, 0.0f, NO_HIT);
    WalkRay world = prepareRay(rayAt(ray), header.lo, header.hi, header.unit);
    Hit best = bestSoFar(world, none);
    for (uint k = 0u; k < HINTS_A_RAY && hints[HINTS_A_RAY * ray + k].x != NO_HINT; ++k) {
        uvec2 hint = hints[HINTS_A_RAY * ray + k];
        if (hint.x < NO_HINT && world.valid) {
#if RAIG_INSTANCED
            StructureHeader whole = header;
            inside.ray = world;
            inside.best = best;
            WalkRay local = enterInstance(hint.y, uint(int(whole.gridStep.y)) * INSTANCES_UNIT);
            Hit found = Hit(localDistance(best.t), 0.0f, 0.0f, NO_HIT);
            testTriangle(local, hint.x, found);
            best = inside.best;
            header = whole;
#else
            testTriangle(world, hint.x, best);
#endif
        }
    }
    Hit hit = outside(world, best);
    bool kept = best.primitive != NO_HIT && distanceInside(world, header.unit, hit.t) == best.t;
    return Hit(kept ? hit.t : 0.0f, kept ? hit.u : 0.0f, kept ? hit.v : 0.0f, kept ? hit.primitive : NO_HIT);
}

// The primitive that `hint` names; NO_HIT if it says that there is none.
uint primitiveOfHint(uvec2 hint) {
    uint primitive = NO_HIT;
    if (hint.x < NO_HINT) {
#if RAIG_INSTANCED
        uint at = uint(int(header.gridStep.y)) * INSTANCES_UNIT + hint.y * INSTANCE_STRIDE;
        uint references = storedNodes_at(storedNodes_at(at + 7u).x + 4u).y;
        primitive = storedNodes_at(at + 6u).w + storedTriangles_at(references + hint.x * TRIANGLE_STRIDE).w;
#else
        primitive = storedTriangles_at(hint.x * TRIANGLE_STRIDE).w;
#endif
    }
    return primitive;
}

// True if the ray has hints, and none names what it meets.
bool hintsFailed(uint ray, Hit hit) {
    bool named = hints[HINTS_A_RAY * ray].x == NO_HINT;
    for (uint k = 0u; k < HINTS_A_RAY; ++k) {
        uvec2 hint = hints[HINTS_A_RAY * ray + k];
        named = named || (hint.x != NO_HINT && primitiveOfHint(hint) == hit.primitive);
    }
    return !named;
}
