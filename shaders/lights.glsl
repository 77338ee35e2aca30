// Direct light: for each light, the ray that asks whether it is seen, and what it would add.
//
// Whoever includes this declares `frame`, scene_at(i) and FEATURES before it, and includes sampling.glsl and surface.glsl.

// `light` arrives at the point (irradiance, W/m^2) unless something opaque is on `ray`. A ray that is not worth asking for
// has tMin > tMax, and no light.
struct ShadowRay {
    Ray ray;
    vec3 light;
    vec3 towards;   // unit, to where it comes from
    float density;  // by solid angle, of drawing that; 0 of lights without size
};

ShadowRay noShadowRay() { return ShadowRay(noRay(), vec3(0.0f), vec3(0.0f), 0.0f); }

bool isLifted(SurfacePoint p) {
    return p.lift.x != 0.0f || p.lift.y != 0.0f || p.lift.z != 0.0f;
}

// Where the shadow rays of a point start from: the point, or the smooth surface above it.
vec3 shadowOrigin(SurfacePoint p) {
    if ((FEATURES & FEATURE_NORMALS) == 0u) return spawnOrigin(p.at, p.normal);
    precise vec3 position = p.at.position + p.lift;
    precise vec3 error = p.at.error + 5.9604648e-8f * abs(position);
    return spawnOrigin(isLifted(p) ? BoundedPoint(position, p.at.blur, error) : p.at, p.normal);
}

// True if light from direction l can reach the point's side: that of the smooth surface, which no normal texture bends, and
// that of the triangle. Where the smooth surface lies above the triangle light may come from under the triangle's plane,
// too: whether the triangle itself is in its way its ray finds out.
bool canReach(SurfacePoint p, vec3 l) {
    bool above = dot(p.normal, l) > 0.0f;
    if ((FEATURES & FEATURE_NORMALS) == 0u) return above;
    return dot(p.smooth_, l) > 0.0f && (above || isLifted(p));
}

// The irradiance that distance and direction leave of a point or spot light (element `at`); `l` points to it.
// Source: KHR_lights_punctual (falloff by range and by cone).
vec3 punctualLight(uint at, uint type, vec3 l, float squaredDistance) {
    uvec4 direction = scene_at(at + 1u);
    uvec4 intensity = scene_at(at + 2u);
    float range = uintBitsToFloat(direction.w);
    precise float ratio = squaredDistance / (range * range);
    precise float window = clamp(1.0f - ratio * ratio, 0.0f, 1.0f);
    precise float falloff = (range > 0.0f ? window : 1.0f) / squaredDistance;
    if (type == LIGHT_SPOT) {
        float outer = uintBitsToFloat(intensity.w);
        float inner = uintBitsToFloat(scene_at(at + 3u).x);
        precise float cosine = -dot(xyzOf(direction), l);
        precise float edge = clamp((cosine - outer) / (inner - outer), 0.0f, 1.0f);
        precise float cone = edge * edge;
        falloff = falloff * (inner > outer ? cone : (cosine >= outer ? 1.0f : 0.0f));
    }
    precise vec3 result = falloff * xyzOf(intensity);
    return result;
}

// Light `j` of the scene (j < lightCount) as seen from p.
ShadowRay lightRay(SurfacePoint p, uint j) {
    uint at = frame.lightsAt + j * LIGHT_STRIDE;
    uvec4 position = scene_at(at);
    uint type = position.w;
    precise vec3 v = xyzOf(position) - p.at.position;
    precise float squaredDistance = dot(v, v);
    precise vec3 towards = v / sqrt(squaredDistance);
    vec3 l = type == LIGHT_DIRECTIONAL ? -xyzOf(scene_at(at + 1u)) : towards;
    precise float cosine = dot(p.shading, l);
    if (!(canReach(p, l) && cosine > 0.0f)) return noShadowRay();

    vec3 arriving = type == LIGHT_DIRECTIONAL ? xyzOf(scene_at(at + 2u)) : punctualLight(at, type, l, squaredDistance);
    precise vec3 light = cosine * arriving;
    if (!(largestOf(light) > 0.0f)) return noShadowRay();

    vec3 origin = shadowOrigin(p);
    precise vec3 all = xyzOf(position) - origin;
    // A ray of no length meets nothing: so asks for a light that casts no shadows.
    float reach = scene_at(at + 3u).y != 0u ? 1.0f : 0.0f;
    if (type == LIGHT_DIRECTIONAL) return ShadowRay(Ray(origin, 0.0f, l, FAR_AWAY * reach), light, l, 0.0f);
    return ShadowRay(Ray(origin, 0.0f, all, reach), light, l, 0.0f);
}

// The emitter that number x in [0, 1) picks: the first whose cumulated probability exceeds it.
uint pickEmitter(float x) {
    uint low = 0u;
    uint high = frame.emitterCount - 1u;
    for (uint i = 0u; i < 32u && low < high; ++i) {
        uint middle = low + (high - low) / 2u;
        bool before = uintBitsToFloat(scene_at(frame.emittersAt + middle).x) <= x;
        low = before ? middle + 1u : low;
        high = before ? high : middle;
    }
    return low;
}

// A point on an emitting triangle, as seen from p.
struct EmitterPoint {
    uvec4 triangle;
    vec3 weights;    // barycentric
    BoundedPoint at;
    vec3 v;          // the way there
    vec3 towards;    // ... as a unit vector
    vec3 facing;     // the triangle's unit normal on p's side
    float geometry;  // both cosines over the squared distance; 0 where it cannot light p
};

// Of the emitter that is listed at `index`, for a point of the unit square: uniformly by area.
EmitterPoint emitterPoint(SurfacePoint p, uint index, vec2 square) {
    Facet facet = facetOf(scene_at(frame.emittersAt + index).y);
    Corners corners = cornersOf(facet);
    precise float r = sqrt(square.x);
    precise float b1 = r * (1.0f - square.y);
    precise float b2 = r * square.y;
    precise float b0 = 1.0f - b1 - b2;
    BoundedPoint q = pointOf(corners.a, corners.b, corners.c, b1, b2);
    precise vec3 v = q.position - p.at.position;
    precise float squaredDistance = dot(v, v);
    precise vec3 l = v / sqrt(squaredDistance);
    precise float cosine = dot(p.shading, l);
    vec3 facing = faceNormal(corners.a, corners.b, corners.c, -l);
    precise float cosineThere = -dot(facing, l);
    if (cosineThere < 0.0f) facing = -facing;
    precise float geometry = cosine * abs(cosineThere) / squaredDistance;
    bool lit = squaredDistance > 0.0f && canReach(p, l) && cosine > 0.0f && cosineThere != 0.0f;
    return EmitterPoint(facet.triangle, vec3(b0, b1, b2), q, v, l, facing, lit ? geometry : 0.0f);
}

// How many points of emitters are drawn for one shadow ray. A path weighs what it draws by its density, which is known of
// one.
uint emitterCandidates() { return (FEATURES & FEATURE_PATH) != 0u ? 1u : EMITTER_CANDIDATES; }

// The c-th of the points of emitters that are drawn for one shadow ray: which emitter, and where on it. They are stratified,
// too.
struct EmitterNumbers {
    float choice;
    vec2 square;
};
EmitterNumbers emitterNumbers(uint pixel, uint sampleIndex, uint c, uint key) {
    uint number = emitterCandidates() * sampleIndex + c;
    return EmitterNumbers(sampleSquare(pixel, number, 1u + 3u * key, frame.seed).x,
                          sampleSquare(pixel, number, 2u + 3u * key, frame.seed));
}

// One point of the emitters as seen from p. Emitters are picked by area times luminance, points uniformly by area [Shirley,
// Wang and Zimmerman 1996, "Monte Carlo Techniques for Direct Lighting Calculations"]; and of some such points one
// by how they lie to p, which stands for all: what nothing hides is so drawn nearly by what it adds [Talbot, Cline and
// Egbert 2005, "Importance Resampling for Global Illumination"]. `key` is that of the ray which found p; dimension 2^30 +
// key says which of them.
ShadowRay emitterRay(SurfacePoint p, uint pixel, uint sampleIndex, uint key) {
    vec3 sums = vec3(FAR_AWAY);  // of geometry, up to the first three
    float sum = 0.0f;
    for (uint c = 0u; c < emitterCandidates(); ++c) {
        EmitterNumbers numbers = emitterNumbers(pixel, sampleIndex, c, key);
        float one = emitterPoint(p, pickEmitter(numbers.choice), numbers.square).geometry;
        precise float all = sum + one;
        sums.x = c == 0u ? all : sums.x;
        sums.y = c == 1u ? all : sums.y;
        sums.z = c == 2u ? all : sums.z;
        sum = all;
    }
    if (!(sum > 0.0f && sum < FAR_AWAY)) return noShadowRay();
    precise float place = sampleSquare(pixel, sampleIndex, 0x40000000u + key, frame.seed).x * sum;
    uint chosen = 0u;
    if (place >= sums.x) chosen = 1u;
    if (place >= sums.y) chosen = 2u;
    if (place >= sums.z) chosen = 3u;
    chosen = min(chosen, emitterCandidates() - 1u);
    EmitterNumbers numbers = emitterNumbers(pixel, sampleIndex, chosen, key);
    uint index = pickEmitter(numbers.choice);
    EmitterPoint q = emitterPoint(p, index, numbers.square);
    if (!(q.geometry > 0.0f)) return noShadowRay();  // of the last ones, if rounding brought `place` to the sum
    vec3 emission = emissionAt(q.triangle, q.weights, 0.0f, 0.0f);
    if ((FEATURES & FEATURE_COVERAGE) != 0u) emission = coverageAt(q.triangle, q.weights) * emission;
    uvec4 emitter = scene_at(frame.emittersAt + index);
    float below = 0.0f;
    if (index > 0u) below = uintBitsToFloat(scene_at(frame.emittersAt + index - 1u).x);
    precise float probability = uintBitsToFloat(emitter.x) - below;
    precise float density = probability / uintBitsToFloat(emitter.z);
    precise vec3 light = sum / (float(emitterCandidates()) * density) * emission;
    vec3 origin = shadowOrigin(p);
    precise vec3 all = spawnOrigin(seenFrom(q.at, q.v), q.facing) - origin;
    if ((FEATURES & FEATURE_PATH) == 0u) return ShadowRay(Ray(origin, 0.0f, all, 1.0f), light, q.towards, 0.0f);
    precise float towards = glowOf(q.triangle) * dot(q.v, q.v) / abs(dot(q.facing, q.towards));
    return ShadowRay(Ray(origin, 0.0f, all, 1.0f), light, q.towards, towards);
}
