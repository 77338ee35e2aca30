// What an item buffer says a ray meets first: tested before all else, the very test that the walk makes. Then the walk only
// has to look as far as that: it proves that nothing is nearer, or finds it. So hits are those of a walk without hints.
//
// Whoever includes this declares what trace.glsl asks for, and includes that and shared/items.glsl.

// The hit on what `hint` names, as far as traceRay() can take it up without loss; none where the ray does not meet that.
Hit hitOfHint(Ray ray, uvec2 hint) {
    Hit none = Hit(0.0f, 0.0f, 0.0f, NO_HIT);
    WalkRay world = prepareRay(ray, header.lo, header.hi, header.unit);
    Hit best = bestSoFar(world, none);
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
