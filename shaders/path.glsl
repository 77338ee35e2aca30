// The state of a slot: beginning a sample, following a ray, putting one off.
//
// Whoever includes this declares `frame`, states[], rays[], pending[] and results[] before it, and includes camera.glsl.

// Turns `state` to the camera ray of its present sample.
Ray beginSample(INOUT(PathState) state) {
    state.weight = vec3(1.0f);
    state.depth = 0u;
    state.key = 0u;
    state.pendingCount = 0u;
    state.media = frame.eyeMedia;
    state.travelled = 0.0f;
    state.passes = 0u;
    state.density = 0.0f;
    return cameraRay(state.pixel, state.sampleIndex);
}

PathState beginPixel(uint pixel) {
    return PathState(vec3(1.0f), 0u, vec3(0.0f), 0.0f, pixel, 0u, 0u, 0u, 0u, 0u, 0u, 0u, 0.0f, 0u, 0.0f, 0u);
}

// Puts off a ray below `state`'s present one until all that was put off after it is done; or discards it, if it goes deeper
// than NIVELL_MAX or weighs less than MIN_CONTRIB: then the greatest component of its weight is added to the pixel's
// discarded weight, which so bounds the error, times the brightest radiance. `media`: what it is in. Requires room for
// maxDepth + 1 rays a slot, and state.travelled to be that of the ray's origin.
void follow(uint slot, INOUT(PathState) state, vec3 origin, vec3 direction, vec3 weight, uint key, uint media) {
    float largest = largestOf(weight);
    bool deep = state.depth + 1u > frame.maxDepth;
    if (deep || largest < frame.minContribution) {
        state.discarded += largest;
    } else if (largest > 0.0f) {
        pending[state.pendingCount * frame.slots + slot] =
            PendingRay(origin, state.depth + 1u, direction, key, weight, media, state.travelled, state.passes, 0.0f, 0.0f);
        state.pendingCount += 1u;
    }
}

// Puts off the rest of `ray` beyond a surface at distance t that it passes straight through: as deep as before, but no more
// than MOST_PASSES such surfaces since the camera. It is the same ray, which only begins later: so it meets all that it
// would have met, to the bit, but the surface. Requires the rays that follow() puts off at the same surface to be put off
// after it: then what waits is at most one ray of each depth, and two of the last, so that room for maxDepth + 1 rays will
// do here, too.
void passOn(uint slot, INOUT(PathState) state, Ray ray, float t, vec3 weight, uint key, uint media) {
    float largest = largestOf(weight);
    if (state.passes >= MOST_PASSES || largest < frame.minContribution) {
        state.discarded += largest;
    } else if (largest > 0.0f) {
        pending[state.pendingCount * frame.slots + slot] =
            PendingRay(ray.origin, state.depth, ray.direction, key, weight, media, state.travelled, state.passes + 1u,
                       nextFloat(t, 1.0f), 0.0f);
        state.pendingCount += 1u;
    }
}

// Takes up the ray that was put off last. Requires pendingCount > 0.
Ray takeUp(uint slot, INOUT(PathState) state) {
    state.pendingCount -= 1u;
    PendingRay next = pending[state.pendingCount * frame.slots + slot];
    state.weight = next.weight;
    state.depth = next.depth;
    state.key = next.key;
    state.media = next.media;
    state.travelled = next.travelled;
    state.passes = next.passes;
    state.density = next.density;
    state.deepest = max(state.deepest, next.depth);
    return Ray(next.origin, next.begin, next.direction, FAR_AWAY);
}
