// Light from where nothing is, if a picture of it is given: what is seen of it, and a light that is drawn from it.
//
// The picture is unfolded from an octahedron: host/scene/environment.hpp says how, and in what shares texels are drawn. What
// is seen and what is drawn is the same, all over each texel.
//
// Whoever includes this declares `frame`, scene_at(i) and FEATURES before it, and includes lights.glsl.

// The texel that unit d points to.
uint environmentTexel(vec3 d) {
    precise float sum = abs(d.x) + abs(d.y) + abs(d.z);
    precise float u = d.x / sum;
    precise float v = d.z / sum;
    precise float beyondU = 1.0f - abs(v);
    precise float beyondV = 1.0f - abs(u);
    if (d.y < 0.0f) {
        u = u < 0.0f ? -beyondU : beyondU;
        v = v < 0.0f ? -beyondV : beyondV;
    }
    float side = float(frame.environmentSide);
    precise float column = (0.5f * u + 0.5f) * side;
    precise float row = (0.5f * v + 0.5f) * side;
    uint last = frame.environmentSide - 1u;
    return min(uint(max(row, 0.0f)), last) * frame.environmentSide + min(uint(max(column, 0.0f)), last);
}

// Radiance from where nothing is, in unit direction d.
vec3 distantRadiance(vec3 d) {
    if ((FEATURES & FEATURE_ENVIRONMENT) == 0u) return skyRadiance(d);
    return xyzOf(scene_at(frame.environmentAt + environmentTexel(d)));
}

// Shares as far as texel `i`, or row `i`, in 2^-24.
uint columnShares(uint i) { return scene_at(frame.environmentAt + i).w; }
uint rowShares(uint i) {
    uvec4 four = scene_at(frame.environmentAt + frame.environmentSide * frame.environmentSide + i / 4u);
    uint two = (i & 1u) != 0u ? four.y : four.x;
    uint others = (i & 1u) != 0u ? four.w : four.z;
    return (i & 2u) != 0u ? others : two;
}

// The row that x (24 bits) picks: the first with more shares as far as it.
uint pickRow(uint x) {
    uint low = 0u;
    uint high = frame.environmentSide - 1u;
    for (uint i = 0u; i < 32u && low < high; ++i) {
        uint middle = low + (high - low) / 2u;
        bool before = rowShares(middle) <= x;
        low = before ? middle + 1u : low;
        high = before ? high : middle;
    }
    return low;
}

// The same of the texels of a row.
uint pickColumn(uint row, uint x) {
    uint first = row * frame.environmentSide;
    uint low = 0u;
    uint high = frame.environmentSide - 1u;
    for (uint i = 0u; i < 32u && low < high; ++i) {
        uint middle = low + (high - low) / 2u;
        bool before = columnShares(first + middle) <= x;
        low = before ? middle + 1u : low;
        high = before ? high : middle;
    }
    return low;
}

// The chance with which texel `texel` is picked.
float texelChance(uint texel) {
    uint row = texel / frame.environmentSide;
    uint ofRow = rowShares(row);
    if (row > 0u) ofRow -= rowShares(row - 1u);
    uint ofColumn = columnShares(texel);
    if (texel > row * frame.environmentSide) ofColumn -= columnShares(texel - 1u);
    precise float chance = float(ofRow) * (1.0f / 16777216.0f) * (float(ofColumn) * (1.0f / 16777216.0f));
    return chance;
}

// The density, by solid angle, with which environmentRay() draws unit direction d.
float environmentDensity(vec3 d) {
    float side = float(frame.environmentSide);
    precise float sum = abs(d.x) + abs(d.y) + abs(d.z);
    precise float density = texelChance(environmentTexel(d)) * (0.25f * side * side) / (sum * sum * sum);
    return density;
}

// One direction as seen from p: a texel by its share, in it a point of the unfolded square. `key` is that of the ray which
// found p; dimensions 2^31 + 2 key and the next are the environment's.
ShadowRay environmentRay(SurfacePoint p, uint pixel, uint sampleIndex, uint key) {
    uint dimension = 0x80000000u + 2u * key;
    uvec2 choice = sampleBits(pixel, sampleIndex, dimension, frame.seed);
    vec2 place = sampleSquare(pixel, sampleIndex, dimension + 1u, frame.seed);
    uint row = pickRow(choice.x >> 8u);
    uint column = pickColumn(row, choice.y >> 8u);
    uint texel = row * frame.environmentSide + column;

    float side = float(frame.environmentSide);
    precise float u = 2.0f * (float(column) + place.x) / side - 1.0f;
    precise float v = 2.0f * (float(row) + place.y) / side - 1.0f;
    precise float y = 1.0f - abs(u) - abs(v);
    precise float foldedU = 1.0f - abs(v);
    precise float foldedV = 1.0f - abs(u);
    vec3 q = vec3(u, y, v);
    if (y < 0.0f) q = vec3(u < 0.0f ? -foldedU : foldedU, y, v < 0.0f ? -foldedV : foldedV);
    precise float squared = dot(q, q);
    precise float distance_ = sqrt(squared);
    precise vec3 l = q / distance_;
    precise float cosine = dot(p.shading, l);
    if (!(canReach(p, l) && cosine > 0.0f)) return noShadowRay();

    precise float density = texelChance(texel) * (0.25f * side * side) * (squared * distance_);
    precise vec3 light = cosine / density * xyzOf(scene_at(frame.environmentAt + texel));
    return ShadowRay(Ray(shadowOrigin(p), 0.0f, l, FAR_AWAY), light, l, density);
}
