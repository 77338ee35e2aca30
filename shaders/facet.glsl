// Triangles as the frame's kernels read them: their corners and normals in the world, wherever their mesh stands.
//
// Whoever includes this declares `frame`, scene_at(i) and the constant FEATURES before it, and includes shared/place.glsl
// and spawn.glsl.

struct Corners {
    vec3 a;
    vec3 b;
    vec3 c;
};

// A triangle as it is stored, its corners in the order that they have in the world, and the element of its instance, if
// there are instances.
struct Facet {
    uvec4 triangle;
    uint instance;
};

vec3 xyzOf(uvec4 v) { return vec3(uintBitsToFloat(v.x), uintBitsToFloat(v.y), uintBitsToFloat(v.z)); }
vec4 rowOf(uvec4 v) { return vec4(xyzOf(v), uintBitsToFloat(v.w)); }

uint vertexElement(uint vertex) { return frame.verticesAt + vertex * frame.vertexStride; }

// The instance that triangle `id` is of: the last whose first id is not greater.
uint instanceOf(uint id) {
    uint low = 0u;
    uint high = frame.instanceCount - 1u;
    for (uint i = 0u; i < 32u && low < high; ++i) {
        uint middle = high - (high - low) / 2u;
        bool after = scene_at(frame.instancesAt + middle * FRAME_INSTANCE_STRIDE + 3u).w > id;
        low = after ? low : middle;
        high = after ? middle - 1u : high;
    }
    return frame.instancesAt + low * FRAME_INSTANCE_STRIDE;
}

// Triangle or sphere `id`, its global one.
Facet facetOf(uint id) {
    if ((FEATURES & FEATURE_INSTANCES) == 0u) return Facet(scene_at(frame.trianglesAt + id), 0u);
    uint instance = instanceOf(id);
    uvec4 stored = scene_at(frame.trianglesAt + scene_at(instance + 4u).w + id);
    uint word = scene_at(instance + 5u).w;
    bool mirrored = (word & 1u) != 0u;
    bool isSphere = (FEATURES & FEATURE_SPHERES) != 0u && stored.y == NO_VERTEX;
    uint first = isSphere ? stored.x + (word >> 1) : stored.x;
    return Facet(uvec4(first, mirrored ? stored.z : stored.y, mirrored ? stored.y : stored.z, stored.w), instance);
}

// Where they are in the world.
Corners cornersOf(Facet facet) {
    vec3 a = xyzOf(scene_at(vertexElement(facet.triangle.x)));
    vec3 b = xyzOf(scene_at(vertexElement(facet.triangle.y)));
    vec3 c = xyzOf(scene_at(vertexElement(facet.triangle.z)));
    if ((FEATURES & FEATURE_INSTANCES) == 0u) return Corners(a, b, c);
    Placement placement = Placement(rowOf(scene_at(facet.instance)), rowOf(scene_at(facet.instance + 1u)),
                                    rowOf(scene_at(facet.instance + 2u)));
    return Corners(placePoint(placement, a), placePoint(placement, b), placePoint(placement, c));
}

Corners vertexNormals(Facet facet) {
    vec3 a = xyzOf(scene_at(vertexElement(facet.triangle.x) + 1u));
    vec3 b = xyzOf(scene_at(vertexElement(facet.triangle.y) + 1u));
    vec3 c = xyzOf(scene_at(vertexElement(facet.triangle.z) + 1u));
    if ((FEATURES & FEATURE_INSTANCES) == 0u) return Corners(a, b, c);
    NormalPlacement placement = NormalPlacement(xyzOf(scene_at(facet.instance + 3u)), xyzOf(scene_at(facet.instance + 4u)),
                                                xyzOf(scene_at(facet.instance + 5u)));
    return Corners(placeNormal(placement, a), placeNormal(placement, b), placeNormal(placement, c));
}

// The vertices' normals interpolated, on the side of n; n itself where a vertex has none, or where they cancel.
vec3 interpolatedNormal(Corners normals, vec3 b, vec3 n) {
    vec3 n0 = normals.a;
    vec3 n1 = normals.b;
    vec3 n2 = normals.c;
    precise vec3 sum = b.x * n0 + b.y * n1 + b.z * n2;
    bool missing = dot(n0, n0) == 0.0f || dot(n1, n1) == 0.0f || dot(n2, n2) == 0.0f;
    if (missing || sqrt(dot(sum, sum)) < 1e-3f) return n;
    vec3 interpolated = unit(sum);
    return dot(interpolated, n) < 0.0f ? -interpolated : interpolated;
}

// How far the smooth surface that the vertices' normals tell of lies outside the triangle at `position`, on the side of n:
// the way to the mean of where it is projected to in the planes across the normals at the vertices, as far as these lie
// outside. Shadow rays that start there do not meet facets where the smooth surface would be lit.
// Source: Hanika 2021, "Hacking the Shadow Terminator", in Ray Tracing Gems II.
vec3 liftOf(Corners corners, Corners normals, vec3 b, vec3 position, vec3 n) {
    precise vec3 sum = normals.a + normals.b + normals.c;
    float side = dot(sum, n) < 0.0f ? -1.0f : 1.0f;
    precise float below0 = min(0.0f, side * dot(position - corners.a, normals.a));
    precise float below1 = min(0.0f, side * dot(position - corners.b, normals.b));
    precise float below2 = min(0.0f, side * dot(position - corners.c, normals.c));
    precise vec3 lift = -side * (b.x * below0 * normals.a + b.y * below1 * normals.b + b.z * below2 * normals.c);
    return dot(lift, n) > 0.0f ? lift : vec3(0.0f);
}

// `normal`, bent towards where the ray of unit direction d comes from, if the ray would meet it from behind or nearly so:
// until the cosine between them is 1/1024 or so. Continuous, so silhouettes of smooth surfaces are, too.
vec3 facingNormal(vec3 normal, vec3 d) {
    precise float lacking = 0.0009765625f + dot(normal, d);
    precise vec3 bent_ = normal - lacking * d;
    return lacking > 0.0f ? unit(bent_) : normal;
}
