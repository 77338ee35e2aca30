// Shadow rays where surfaces let light pass by their alpha: what each meets takes its share, and the ray goes on behind it.
//
// Whoever includes this declares `now`, shadowRays[], shadowHits[], contributions[] and the counter `counted` before it, and
// includes surface.glsl and path.glsl.

// Shadow ray now.listAt + i has met shadowHits[...], its nearest.
// Ensures  its contribution is what is left of it behind that, and it goes on there if that is anything, and is counted;
//          else it meets nothing from now on. With `compacts` no ray goes on: what would have to counts as dark.
void pass(uint i) {
    uint index = now.listAt + i;
    Hit hit = shadowHits[index];
    Ray ray = shadowRays[index];
    bool throughGlass = (FEATURES & FEATURE_AO) == 0u;
    if ((FEATURES & FEATURE_PATH) != 0u) throughGlass = now.listAt < frame.lightCount * now.count;
    bool goesOn = false;
    if (hit.primitive != NO_HIT) {
        precise float rest = 1.0f - shadeOf(hit, throughGlass);
        goesOn = rest > 0.0f && now.compacts == 0u;
        vec4 contribution = contributions[index];
        float left = goesOn ? rest : 0.0f;
        float other = 0.0f;
        if ((FEATURES & FEATURE_PATH) != 0u) {
            // A drawn ray would pass by the chance `rest`: so much less of the light is its.
            precise float ratio = rest * contribution.w;
            precise float more = left * ((1.0f + contribution.w) / (1.0f + ratio));
            left = more;
            other = ratio;
        }
        contributions[index] = vec4(left * contribution.x, left * contribution.y, left * contribution.z, other);
    }
    Ray next = noRay();
    if (goesOn) next = Ray(ray.origin, nextFloat(hit.t, 1.0f), ray.direction, ray.tMax);
    shadowRays[index] = next;
    if (goesOn) atomicAdd(counted, 1u);
}
