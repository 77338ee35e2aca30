// Path tracing: from each point that a ray meets one ray goes on, in a direction that is drawn from what the surface does
// with light. It brings what Whitted's rays and ambient light stand for, and more.
//
// Light of emitters and of the environment is found by two kinds of rays: drawn from these, and drawn from surfaces. Each is
// weighted by its density over the sum of both [Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte
// Carlo Rendering": the balance heuristic]; so neither a small emitter nor a narrow lobe makes much noise. Emission that
// comes by a mirror or through glass, or straight to the camera, no other ray finds: it counts in full. So do spheres that
// glow, and the sky. Point, spot and directional lights are found by rays to them alone.
// Source: Kajiya 1986, "The Rendering Equation".
//
// Numbers: a path's k-th ray has key k; dimension 6 + 3 k is of the direction in which it goes on, 2^30 + k of which way it
// goes at all, and whether, 2^29 + k of whether a surface lets it pass. (Those of emitters are 1 + 3 k and 2 + 3 k, of the
// environment 2^31 + 2 k and the next, of the lens 3.)
//
// Whoever includes this declares `frame`, pending[] and FEATURES before it, and includes path.glsl, fresnel.glsl,
// directions.glsl, lobe.glsl and environment.glsl.

// How irradiance at a point counts in the pixel: by `scattered`, and by what `lobe` sends back times `weight`.
struct Direct {
    vec3 scattered;
    vec3 weight;
    Lobe lobe;
};

// The chances with which a ray is reflected, transmitted, scattered, or drawn from the lobe of a rough surface: in
// proportion to the most that each may count.
struct Chances {
    float reflected;
    float transmitted;
    float scattered;
    float rough;
};

Chances noChances() { return Chances(0.0f, 0.0f, 0.0f, 0.0f); }

Chances chancesOf(vec3 weight, Split split) {
    float reflected = largestOf(weight * split.reflected);
    float transmitted = largestOf(weight * split.transmitted);
    float scattered = largestOf(weight * split.diffuse);
    float rough = (FEATURES & FEATURE_LOBES) != 0u ? largestOf(weight * split.rough) : 0.0f;
    precise float sum = reflected + transmitted + scattered + rough;
    precise float scale = 1.0f / (sum > 0.0f ? sum : 1.0f);
    return Chances(scale * reflected, scale * transmitted, scale * scattered, scale * rough);
}

float drawnSpread(SurfacePoint p) { return max(p.roughness * p.roughness, LEAST_DRAWN_SPREAD); }

// A direction in which small mirrors send light to v, by which of them are seen from there, for a point of the unit square.
// What the mirrors of a sphere reflect of v, stretched so that it is one, covers a cap of the sphere evenly [Dupuy and
// Benyoub 2023, "Sampling Visible GGX Normals with Spherical Caps"]; a point of the disk is taken to the cap by area.
vec3 mirroredDirection(SurfacePoint p, vec3 v, vec2 square) {
    float a = drawnSpread(p);
    vec3 seen = alongNormal(p.shading, v);
    vec3 stretched = unit(vec3(a * seen.x, a * seen.y, seen.z));
    vec2 disk = diskOf(square);
    precise float within = dot(disk, disk);
    precise float cap = 1.0f + stretched.z;
    precise float aside = sqrt(max(0.0f, cap * (2.0f - within * cap)));
    precise vec3 h = vec3(a * (disk.x * aside + stretched.x), a * (disk.y * aside + stretched.y),
                          max(0.0f, cap * (1.0f - within)));
    precise float length2 = dot(h, h);
    precise vec3 facet = h / sqrt(length2);
    if (!(length2 > 0.0f)) facet = vec3(0.0f, 0.0f, 1.0f);
    precise vec3 way = 2.0f * dot(seen, facet) * facet - seen;
    return aboutNormal(p.shading, way);
}

// Its density, by solid angle. Requires unit v and l.
float mirroredDensity(SurfacePoint p, vec3 v, vec3 l) {
    vec3 n = p.shading;
    precise vec3 sum = v + l;
    precise float square = dot(sum, sum);
    precise vec3 h = sum / sqrt(square > 0.0f ? square : 1.0f);
    float a = drawnSpread(p);
    precise float nv = max(dot(n, v), 0.0009765625f);
    precise float a2 = a * a;
    precise float shown = nv + sqrt(a2 + (1.0f - a2) * (nv * nv));
    precise float density = facetDensity(n, h, a) * 0.5f / shown;
    return density;
}

// The density, by solid angle, with which the next ray goes in unit direction l, if the last one came from v; that it is
// reflected or transmitted has none.
float bounceDensity(SurfacePoint p, vec3 v, vec3 l, Chances chances) {
    precise float density = chances.scattered * 0.318309886f * max(0.0f, dot(p.shading, l));
    if ((FEATURES & FEATURE_LOBES) != 0u && chances.rough > 0.0f) {
        precise float both = density + chances.rough * mirroredDensity(p, v, l);
        density = both;
    }
    return density;
}

// `density` of a direction over its sum with the other kind's; 1 if the other kind cannot find it.
float balanced(float density, float other) {
    precise float share = density / (density + other);
    return other > 0.0f ? share : 1.0f;
}

// The share in which emission at p counts that a ray has met after a distance of t.
float emissionShare(SurfacePoint p, Ray ray, float t, float density) {
    if ((FEATURES & FEATURE_EMITTERS) == 0u || density == 0.0f) return 1.0f;
    precise float area = abs(dot(p.normal, ray.direction)) / (t * t);
    precise float other = p.glow / area;
    return balanced(density, area > 0.0f ? other : 0.0f);
}

// The same of what a ray finds where nothing is.
float distantShare(vec3 direction, float density) {
    if ((FEATURES & FEATURE_SHINING) == 0u || density == 0.0f) return 1.0f;
    return balanced(density, environmentDensity(direction));
}

// Puts off the ray that goes on, unless it goes deeper than NIVELL_MAX: then the greatest component of its weight counts as
// discarded. One that weighs less than frame.roulette goes on by chance, and then weighs that, which changes no mean: as
// often as its weight is of that, by number x in [0, 1) [Arvo and Kirk 1990, "Particle Transport and Image Synthesis"].
void goOn(uint slot, INOUT(PathState) state, float x, PendingRay next) {
    float largest = largestOf(next.weight);
    precise float survival = largest / frame.roulette;
    bool isLight = largest < frame.roulette;
    if (next.depth > frame.maxDepth) {
        state.discarded += largest;
    } else if (largest > 0.0f && (!isLight || x < survival)) {
        precise vec3 heavier = next.weight / survival;
        if (isLight) next.weight = heavier;
        pending[slot] = next;
        state.pendingCount = 1u;
    }
}

// Draws the ray that goes on from p: its direction, origin, weight, media and density into `next`. Its weight is zero where
// it would be on the wrong side.
void drawNext(SurfacePoint p, vec3 v, Split split, Crossing crossing, Chances chances, PathState state, float x,
              INOUT(PendingRay) next) {
    float chance = chances.reflected;
    vec3 value = split.reflected;
    next.direction = split.reflectedWay;
    next.origin = spawnOrigin(p.at, p.normal);
    next.media = crossing.within;
    precise float through = chances.reflected + chances.transmitted;
    if ((FEATURES & FEATURE_TRANSMISSION) != 0u && chances.transmitted > 0.0f && x >= chances.reflected) {
        chance = chances.transmitted;
        value = split.transmitted;
        next.direction = split.transmittedWay;
        next.origin = spawnOrigin(p.at, -p.normal);
        next.media = crossing.beyond;
    }
    bool isScattered = chances.scattered > 0.0f && x >= through;
    bool isRough = false;
    if ((FEATURES & FEATURE_LOBES) != 0u) {
        precise float before = through + chances.scattered;
        isRough = chances.rough > 0.0f && x >= before;
    }
    if (isScattered || isRough) {
        vec2 square = sampleSquare(state.pixel, state.sampleIndex, 6u + 3u * state.key, frame.seed);
        vec3 way = cosineDirection(p.shading, square);
        if ((FEATURES & FEATURE_LOBES) != 0u && isRough) way = mirroredDirection(p, v, square);
        next.direction = way;
        next.origin = shadowOrigin(p);
        next.media = crossing.within;
        next.density = bounceDensity(p, v, way, chances);
        chance = chances.scattered;
        value = split.diffuse;
        precise float cosine = dot(p.shading, way);
        if ((FEATURES & FEATURE_LOBES) != 0u && chances.rough > 0.0f) {
            float rough = 1.0f - p.gloss;
            precise vec3 both = split.diffuse * 0.318309886f +
                                rough * lobeTowards(split.lobe, p.shading, p.roughness, v, way, LEAST_DRAWN_SPREAD);
            precise vec3 scaled = cosine * both;
            value = scaled;
            chance = next.density;
        }
        if (!(canReach(p, way) && cosine > 0.0f && next.density > 0.0f)) value = vec3(0.0f);
    }
    precise vec3 weight = state.weight * value / (chance > 0.0f ? chance : 1.0f);
    next.weight = weight;
}

// Emission, absorption, and the ray that goes on. Returns how direct light counts, as shadeSurface() does; `chances` are
// those of the ray that goes on, none if it would go too deep. Dimension 2^29 + k decides whether a surface lets the ray
// pass by its alpha: then nothing of it counts, and it is the same ray that goes on.
Direct bounce(uint slot, Ray ray, Hit hit, SurfacePoint p, INOUT(PathState) state, INOUT(Chances) chances) {
    Crossing crossing = crossingAt(p, state.media);
    if (crossing.absorbs) state.weight = state.weight * absorbed(crossing.absorption, hit.t - ray.tMin);
    state.forgotten += crossing.forgets ? 1u : 0u;
    if ((FEATURES & FEATURE_COVERAGE) != 0u) {
        float x = 0.0f;
        if ((FEATURES & FEATURE_BLENDS) != 0u)
            x = sampleSquare(state.pixel, state.sampleIndex, 0x20000000u + state.key, frame.seed).x;
        if (!crossing.hidden && x >= p.coverage) {
            float largest = largestOf(state.weight);
            if (state.passes >= MOST_PASSES) {
                state.discarded += largest;
            } else if (largest > 0.0f) {
                precise float density = (1.0f - p.coverage) * state.density;
                pending[slot] = PendingRay(ray.origin, state.depth, ray.direction, state.key + 1u, state.weight,
                                           crossing.beyond, state.travelled, state.passes + 1u, nextFloat(hit.t, 1.0f),
                                           density);
                state.pendingCount = 1u;
            }
            return Direct(vec3(0.0f), vec3(0.0f), noLobe());
        }
    }
    float share = emissionShare(p, ray, hit.t, state.density);
    precise vec3 emitted = state.sum + share * state.weight * p.emission;
    if (!crossing.hidden) state.sum = emitted;
    precise float travelled = state.travelled + hit.t;
    state.travelled = travelled;

    Split split = splitAt(ray.direction, p, crossing);
    chances = chancesOf(state.weight, split);
    vec2 choice = sampleSquare(state.pixel, state.sampleIndex, 0x40000000u + state.key, frame.seed);
    PendingRay next = PendingRay(vec3(0.0f), state.depth + 1u, vec3(0.0f), state.key + 1u, vec3(0.0f), 0u, state.travelled,
                                 state.passes, 0.0f, 0.0f);
    drawNext(p, -ray.direction, split, crossing, chances, state, choice.x, next);
    goOn(slot, state, choice.y, next);
    if (next.depth > frame.maxDepth) chances = noChances();
    precise vec3 direct = state.weight * split.diffuse * 0.318309886f;
    return Direct(direct, state.weight, split.lobe);
}
