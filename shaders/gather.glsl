// Beginning a tile, and what follows the shadow rays: their light is added, and each slot moves on to its next ray.
//
// Whoever includes this declares `frame`, `now`, slotList[], states[], rays[], pending[], shadowHits[], contributions[],
// results[] and the counter `atWork` before it, and includes path.glsl.
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
    precise vec3 mean = state.sum / float(frame.samples);
    precise float discarded = state.discarded / float(frame.samples);
    return PixelResult(mean, discarded, state.pixel, state.closestRays, state.shadowRays, state.deepest);
}

// Slot slotList[listAt + i] moves on: to a ray that was put off, else to the next sample, else it is done and its pixel is in
// results[]. Slots that go on are listed from slotList[nextAt] on, in any order, and counted in atWork.
void gather(uint i) {
    uint slot = slotList[now.listAt + i];
    PathState state = states[slot];
    precise vec3 sum = state.sum + gatheredLight(i);
    state.sum = sum;

    bool resumes = (FEATURES & (FEATURE_MIRRORS | FEATURE_TRANSMISSION)) != 0u && state.pendingCount > 0u;
    if (!resumes) state.sampleIndex += 1u;
    if (!resumes && state.sampleIndex == frame.samples) {
        results[slot] = resultOf(state);
    } else {
        Ray next;
        if (resumes) {
            next = takeUp(slot, state);
        } else {
            next = beginSample(state);
        }
        uint place = atomicAdd(atWork, 1u);
        slotList[now.nextAt + place] = slot;
        rays[place] = next;
        states[slot] = state;
    }
}
