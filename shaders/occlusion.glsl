// Ambient occlusion: how much of what is above a surface is open, up to a distance. Nothing else counts, no material and no
// light.
//
// Whoever includes this declares `frame`, `now`, slotList[], states[], rays[], hits[], shadowRays[] and contributions[]
// before it, and includes surface.glsl, directions.glsl and path.glsl.

// The ray that asks, one direction a sample, drawn by its cosine about the shading normal. One that would go below the
// triangle is mirrored in it, so that what is convex is white all over, however coarse it is. Dimension 6 + 3 k is its
// direction's, behind k surfaces that let it pass by their alpha.
Ray probeOf(SurfacePoint p, PathState state) {
    vec2 square = sampleSquare(state.pixel, state.sampleIndex, 6u + 3u * state.passes, frame.seed);
    vec3 way = cosineDirection(p.shading, square);
    precise float height = dot(way, p.normal);
    precise vec3 mirrored = way - 2.0f * height * p.normal;
    return Ray(spawnOrigin(p.at, p.normal), 0.0f, height < 0.0f ? unit(mirrored) : way, frame.reach);
}

// Entry i of the list: its slot's camera ray rays[i] has met hits[i]. It is white, if the ray that it asks for meets
// nothing, or if it has met nothing itself. Requires frame.shadowRays == 1.
void shadeOcclusion(uint i) {
    uint slot = slotList[now.listAt + i];
    bool working = slot != NO_SLOT;
    PathState state = beginPixel(0u);
    if (working) state = states[slot];
    Ray ray = rays[i];
    Hit hit = hits[i];
    bool met = working && hit.primitive != NO_HIT;
    Ray probe = noRay();
    vec3 weight = vec3(0.0f);
    if (met) {
        SurfacePoint p = surfaceAt(ray, hit, 0.0f);
        weight = state.weight;
        if ((FEATURES & FEATURE_COVERAGE) != 0u) {
            precise vec3 rest = (1.0f - p.coverage) * weight;
            passOn(slot, state, ray, hit.t, rest, 0u, 0u);
            precise vec3 kept = p.coverage * weight;
            weight = kept;
        }
        if (weight.x > 0.0f) probe = probeOf(p, state);
    }
    shadowRays[i] = probe;
    contributions[i] = vec4(weight.x, weight.y, weight.z, 0.0f);
    if (working && !met) states[slot].sum = state.sum + state.weight;
    if (weight.x > 0.0f) states[slot].shadowRays = state.shadowRays + 1u;
    if ((FEATURES & FEATURE_COVERAGE) != 0u && working) {
        states[slot].discarded = state.discarded;
        states[slot].pendingCount = state.pendingCount;
    }
}
