// What one ray of each slot contributes by itself, which rays go on from where it hits, and which ask for light there.
//
// Whoever includes this declares `frame`, `now`, slotList[], states[], rays[], hits[], pending[], shadowRays[] and
// contributions[] before it, and includes the rest of the frame's code.

// Emission, absorption, ambient light; reflected and transmitted rays are put off, the reflected one to be taken up first.
// Returns how light that arrives directly counts in the pixel.
Direct shadeSurface(uint slot, Ray ray, Hit hit, SurfacePoint p, INOUT(PathState) state) {
    Crossing crossing = crossingAt(p, state.media);
    if (crossing.absorbs) state.weight = state.weight * absorbed(crossing.absorption, hit.t - ray.tMin);
    state.forgotten += crossing.forgets ? 1u : 0u;
    if ((FEATURES & FEATURE_COVERAGE) != 0u && !crossing.hidden) {
        precise vec3 rest = (1.0f - p.coverage) * state.weight;
        passOn(slot, state, ray, hit.t, rest, 2u * state.key + 2u, crossing.beyond);
        precise vec3 kept = p.coverage * state.weight;
        state.weight = kept;
    }
    precise vec3 emitted = state.sum + state.weight * p.emission;
    if (!crossing.hidden) state.sum = emitted;

    Split split = splitAt(ray.direction, p, crossing);
    precise vec3 scattered = state.weight * split.diffuse;
    vec3 everywhere = scattered;
    if ((FEATURES & FEATURE_LOBES) != 0u) {
        precise vec3 both = state.weight * (split.diffuse + split.rough);
        everywhere = both;
    }
    precise vec3 ambient = state.sum + everywhere * (p.openness * frame.ambient);
    state.sum = ambient;
    precise float travelled = state.travelled + hit.t;
    state.travelled = travelled;
    if ((FEATURES & FEATURE_TRANSMISSION) != 0u) {
        vec3 weight = state.weight * split.transmitted;
        follow(slot, state, spawnOrigin(p.at, -p.normal), split.transmittedWay, weight, 2u * state.key + 2u,
               crossing.beyond);
    }
    if (BRANCHES) {
        vec3 weight = state.weight * split.reflected;
        follow(slot, state, spawnOrigin(p.at, p.normal), split.reflectedWay, weight, 2u * state.key + 1u,
               crossing.within);
    }
    precise vec3 direct = scattered * 0.318309886f;
    return Direct(direct, state.weight, split.lobe);
}

// `share` of what the lobe sends towards the eye is asked for, with an a of at least `least`: see lobe.glsl. `chances`: of
// the other way in which a path may find the same light.
void storeShadowRay(uint index, ShadowRay shadow, SurfacePoint p, vec3 towardsEye, Direct direct, Chances chances,
                    float share, float least, INOUT(PathState) state) {
    vec3 value = direct.scattered;
    if ((FEATURES & FEATURE_LOBES) != 0u && largestOf(shadow.light) > 0.0f) {
        vec3 mirrored = lobeTowards(direct.lobe, p.shading, p.roughness, towardsEye, shadow.towards, least);
        precise vec3 both = value + (share * direct.weight) * mirrored;
        value = both;
    }
    precise vec3 contribution = value * shadow.light;
    float other = 0.0f;
    if ((FEATURES & FEATURE_PATH) != 0u && shadow.density > 0.0f) {
        precise float ratio = bounceDensity(p, towardsEye, shadow.towards, chances) / shadow.density;
        precise vec3 balanced_ = contribution / (1.0f + ratio);
        contribution = balanced_;
        other = ratio;
    }
    bool asked = largestOf(contribution) > 0.0f;
    if (!asked) shadow = noShadowRay();
    state.shadowRays += asked ? 1u : 0u;
    shadowRays[index] = shadow.ray;
    contributions[index] = asked ? vec4(contribution.x, contribution.y, contribution.z, other) : vec4(0.0f);
}

// Entry i of the list: its slot's ray rays[i] has met hits[i]. By Whitted's integrator, or one ray of a path.
// Ensures  shadowRays[j * count + i] and contributions[...], for each j < frame.shadowRays, hold the j-th light's.
// Cost     O(lights + log emitters). Only what has changed is stored, as storing costs as much as shading on some devices.
void shadeLight(uint i) {
    uint slot = slotList[now.listAt + i];
    bool working = slot != NO_SLOT;
    PathState state = beginPixel(0u);  // where there is no slot: any slot's is being written by its own entry
    if (working) state = states[slot];
    Ray ray = rays[i];
    Hit hit = hits[i];
    Direct direct = Direct(vec3(0.0f), vec3(0.0f), noLobe());
    Chances chances = noChances();
    SurfacePoint p;
    if (working && hit.primitive == NO_HIT) {
        vec3 weight = state.weight;
        if ((FEATURES & FEATURE_PATH) != 0u) weight = distantShare(ray.direction, state.density) * weight;
        precise vec3 sum = state.sum + weight * distantRadiance(ray.direction);
        state.sum = sum;
    } else if (working) {
        p = surfaceAt(ray, hit, state.travelled);
        if ((FEATURES & FEATURE_PATH) != 0u) {
            direct = bounce(slot, ray, hit, p, state, chances);
        } else {
            direct = shadeSurface(slot, ray, hit, p, state);
        }
    }
    bool lit = largestOf(direct.scattered) > 0.0f;
    float share = 0.0f;  // of the light of what reflected rays find, too
    if ((FEATURES & FEATURE_LOBES) != 0u) {
        lit = lit || largestOf(direct.weight * direct.lobe.grazing) > 0.0f;
        if (lit && !p.transmissive) share = 1.0f - p.gloss;
    }
    const float least = (FEATURES & FEATURE_PATH) != 0u ? LEAST_DRAWN_SPREAD : LEAST_SAMPLED_SPREAD;
    if ((FEATURES & FEATURE_LIGHTS) != 0u) {
        for (uint j = 0u; j < frame.lightCount; ++j) {
            ShadowRay shadow = noShadowRay();
            if (lit) shadow = lightRay(p, j);
            storeShadowRay(j * now.count + i, shadow, p, -ray.direction, direct, chances, 1.0f, LEAST_SPREAD, state);
        }
    }
    if ((FEATURES & FEATURE_EMITTERS) != 0u) {
        ShadowRay shadow = noShadowRay();
        if (lit) shadow = emitterRay(p, state.pixel, state.sampleIndex, state.key);
        storeShadowRay(frame.lightCount * now.count + i, shadow, p, -ray.direction, direct, chances, share, least, state);
    }
    if ((FEATURES & FEATURE_SHINING) != 0u) {
        ShadowRay shadow = noShadowRay();
        if (lit) shadow = environmentRay(p, state.pixel, state.sampleIndex, state.key);
        storeShadowRay((frame.shadowRays - 1u) * now.count + i, shadow, p, -ray.direction, direct, chances, share, least,
                       state);
    }
    if (working) {
        states[slot].sum = state.sum;
        if (frame.shadowRays > 0u) states[slot].shadowRays = state.shadowRays;
        if (BRANCHES) {
            states[slot].weight = state.weight;
            states[slot].discarded = state.discarded;
            states[slot].pendingCount = state.pendingCount;
        }
        if ((FEATURES & FEATURE_NESTED) != 0u) states[slot].forgotten = state.forgotten;
    }
}

// The same by the integrator that the picture asks for.
void shade(uint i) {
    if ((FEATURES & FEATURE_AO) != 0u) {
        shadeOcclusion(i);
    } else {
        shadeLight(i);
    }
}
