// Beginning a tile, or taking its pixels up again, and what follows the shadow rays: their light is added, and each slot
// moves on to its next ray.
//
// Whoever includes this declares `frame`, `now`, slotList[], states[], rays[], pending[], shadowHits[], contributions[],
// results[] and the counter `counted` before it, and includes path.glsl.
//
// A slot sums its own contributions, one ray after the other, depth first; so the picture does not depend on tiles, on
// threads, or on the order of the slots.

// Slot i of a new tile takes up its pixel. Then slotList[listAt + i] == i.
void begin(uint i) {
    PathState state = beginPixel(pixelOf(now.firstPixel + i));
    rays[i] = beginSample(state);
    states[i] = state;
    slotList[now.listAt + i] = i;
}

// Slot i of a new tile goes on with its pixel where states[i] says that it stands: at the start of a sample. Then
// slotList[listAt + i] == i.
void resume(uint i) {
    PathState state = states[i];
    rays[i] = beginSample(state);
    states[i] = state;
    slotList[now.listAt + i] = i;
}

// The light of the shadow rays that met nothing, in the order of the lights.
vec3 gatheredLight(uint i) {
    vec3 sum = vec3(0.0f);
    for (uint j = 0u; j < frame.shadowRays; ++j) {
        uint index = j * now.count + i;
        vec4 contribution = contributions[index];
        if (shadowHits[index].primitive == NO_HIT) sum += vec3(contribution.x, contribution.y, contribution.z);
    }
    return sum;
}

PixelResult resultOf(PathState state) {
    return PixelResult(state.sum, state.discarded, state.pixel, state.shadowRays, state.deepest, state.forgotten);
}

// Turns slot `slot` to a ray that was put off, else to its next sample. Returns false, with its pixel in results[], if there
// is neither.
bool moveOn(uint i, uint slot, INOUT(Ray) next) {
    PathState state = states[slot];
    precise vec3 sum = state.sum + gatheredLight(i);
    state.sum = sum;
    bool resumes = BRANCHES && state.pendingCount > 0u;
    if (!resumes) state.sampleIndex += 1u;
    bool finished = !resumes && state.sampleIndex == frame.samples;
    if (finished) {
        results[slot] = resultOf(state);
    } else {
        if (resumes) {
            next = takeUp(slot, state);
        } else {
            next = beginSample(state);
        }
        states[slot].sum = state.sum;
        states[slot].sampleIndex = state.sampleIndex;
        if (BRANCHES && (FEATURES & FEATURE_TEXTURES) != 0u) states[slot].travelled = state.travelled;
        if ((FEATURES & FEATURE_COVERAGE) != 0u) states[slot].passes = state.passes;
        if (BRANCHES) {
            states[slot].weight = state.weight;
            states[slot].depth = state.depth;
            states[slot].key = state.key;
            states[slot].pendingCount = state.pendingCount;
            states[slot].deepest = state.deepest;
            if ((FEATURES & FEATURE_PATH) != 0u) states[slot].density = state.density;
        }
        if ((FEATURES & FEATURE_NESTED) != 0u) states[slot].media = state.media;
    }
    return !finished;
}

// Entry i of the list moves on. With `compacts`, slots that go on are listed from slotList[nextAt] on, in any order, and
// `counted` counts them; else each stays in its place, and `counted` counts those that have finished: that takes
// fewer atomic operations while most go on.
void gather(uint i) {
    uint slot = slotList[now.listAt + i];
    Ray next = noRay();
    bool working = slot != NO_SLOT;
    bool goesOn = false;
    if (working) goesOn = moveOn(i, slot, next);
    uint place = i;
    if (now.compacts != 0u) {
        if (goesOn) place = atomicAdd(counted, 1u);
    } else if (working && !goesOn) {
        atomicAdd(counted, 1u);
    }
    if (goesOn || now.compacts == 0u) {
        slotList[now.nextAt + place] = goesOn ? slot : NO_SLOT;
        rays[place] = next;
    }
}
