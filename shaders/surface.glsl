// What a ray finds where it hits: the point, the normals, and the surface in the terms of host/scene/surface.hpp.
//
// Whoever includes this declares `frame`, scene_at(i) and the constant FEATURES before it, and includes shared/place.glsl,
// spawn.glsl and texture.glsl.

struct SurfacePoint {
    BoundedPoint at;
    vec3 normal;         // n: of the triangle or sphere, on the ray's side
    vec3 shading;        // ns: interpolated from the vertices, on the ray's side
    bool front;          // the ray came from where the corners run counterclockwise, or from outside the sphere
    vec3 diffuse;        // tinted by texture and vertex colours
    float gloss;
    vec3 mirror;         // tinted
    float ior;
    vec3 through;        // tinted transmission
    bool transmissive;   // lets light through at all, before the tint
    vec3 absorption;
    bool thin;
    uint medium;         // what is within, if it is known to be closed: see media.glsl
    vec3 emission;
};

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

// The shading normal for a ray of unit direction d: the vertices' normals interpolated, on the side of n. n itself where a
// vertex has none, where they cancel, and where the ray would meet the interpolated one from behind.
vec3 shadingNormal(Facet facet, vec3 b, vec3 d, vec3 n) {
    Corners normals = vertexNormals(facet);
    vec3 n0 = normals.a;
    vec3 n1 = normals.b;
    vec3 n2 = normals.c;
    precise vec3 sum = b.x * n0 + b.y * n1 + b.z * n2;
    bool missing = dot(n0, n0) == 0.0f || dot(n1, n1) == 0.0f || dot(n2, n2) == 0.0f;
    if (missing || sqrt(dot(sum, sum)) < 1e-3f) return n;
    vec3 interpolated = unit(sum);
    if (dot(interpolated, n) < 0.0f) interpolated = -interpolated;
    return dot(interpolated, d) >= 0.0f ? n : interpolated;
}

// The texture coordinates at barycentric coordinates b. Requires FEATURE_UVS.
vec2 textureCoordinates(uvec4 triangle, vec3 b) {
    uint at0 = vertexElement(triangle.x);
    uint at1 = vertexElement(triangle.y);
    uint at2 = vertexElement(triangle.z);
    precise float u = b.x * uintBitsToFloat(scene_at(at0).w) + b.y * uintBitsToFloat(scene_at(at1).w) +
                      b.z * uintBitsToFloat(scene_at(at2).w);
    precise float v = b.x * uintBitsToFloat(scene_at(at0 + 1u).w) + b.y * uintBitsToFloat(scene_at(at1 + 1u).w) +
                      b.z * uintBitsToFloat(scene_at(at2 + 1u).w);
    return vec2(u, v);
}

// What multiplies the surface's colours at barycentric coordinates b: texture times vertex colour, 1 where absent.
vec3 tintAt(uvec4 triangle, vec3 b, uint texture_) {
    vec3 tint = vec3(1.0f);
    if ((FEATURES & FEATURE_TEXTURES) != 0u && texture_ != NO_TEXTURE) {
        vec2 uv = textureCoordinates(triangle, b);
        tint = textureColour(texture_, uv.x, uv.y);
    }
    if ((FEATURES & FEATURE_COLORS) != 0u) {
        uint last = frame.vertexStride - 1u;
        precise vec3 colour = b.x * xyzOf(scene_at(vertexElement(triangle.x) + last)) +
                              b.y * xyzOf(scene_at(vertexElement(triangle.y) + last)) +
                              b.z * xyzOf(scene_at(vertexElement(triangle.z) + last));
        tint = tint * colour;
    }
    return tint;
}

// Where the ray meets the triangle, with its normals. Returns the tint.
vec3 meetTriangle(Facet facet, uint texture_, Ray ray, Hit hit, INOUT(SurfacePoint) p) {
    uvec4 triangle = facet.triangle;
    Corners corners = cornersOf(facet);
    precise float b0 = 1.0f - hit.u - hit.v;
    vec3 b = vec3(b0, hit.u, hit.v);
    p.at = pointOf(corners.a, corners.b, corners.c, hit.u, hit.v);
    vec3 faced = faceNormal(corners.a, corners.b, corners.c, -ray.direction);
    p.front = dot(ray.direction, faced) < 0.0f;
    p.normal = p.front ? faced : -faced;
    p.shading = p.normal;
    if ((FEATURES & FEATURE_NORMALS) != 0u) p.shading = shadingNormal(facet, b, ray.direction, p.normal);
    return tintAt(triangle, b, texture_);
}

// The same for a sphere: the point at the hit's t, projected to the surface. It has neither texture nor vertex colours.
vec3 meetSphere(uvec4 triangle, Ray ray, Hit hit, INOUT(SurfacePoint) p) {
    uvec4 sphere = scene_at(frame.spheresAt + triangle.x);
    vec3 centre = xyzOf(sphere);
    precise vec3 away = ray.origin - centre + hit.t * ray.direction;
    precise vec3 scaled = away * unitScale(away);
    vec3 outwards = unit(scaled);
    p.at = pointOfSphere(centre, uintBitsToFloat(sphere.w), outwards);
    p.front = dot(ray.direction, outwards) < 0.0f;
    p.normal = p.front ? outwards : -outwards;
    p.shading = p.normal;
    return vec3(1.0f);
}

// What `ray` (unit direction) finds at `hit`. Requires hit.primitive != NO_HIT.
SurfacePoint surfaceAt(Ray ray, Hit hit) {
    Facet facet = facetOf(hit.primitive);
    uvec4 triangle = facet.triangle;
    uint material = frame.materialsAt + triangle.w * MATERIAL_STRIDE;
    uvec4 diffuse = scene_at(material);
    uvec4 mirror = scene_at(material + 1u);
    uvec4 through = scene_at(material + 2u);
    uvec4 absorption = scene_at(material + 3u);

    SurfacePoint p;
    vec3 tint = vec3(1.0f);
    if ((FEATURES & FEATURE_SPHERES) != 0u && triangle.y == NO_VERTEX) {
        tint = meetSphere(triangle, ray, hit, p);
    } else {
        tint = meetTriangle(facet, absorption.w, ray, hit, p);
    }
    p.diffuse = xyzOf(diffuse) * tint;
    p.gloss = uintBitsToFloat(diffuse.w);
    p.mirror = (through.w & SURFACE_TINTS_MIRROR) != 0u ? xyzOf(mirror) * tint : xyzOf(mirror);
    p.ior = uintBitsToFloat(mirror.w);
    p.through = (through.w & SURFACE_TINTS_THROUGH) != 0u ? xyzOf(through) * tint : xyzOf(through);
    p.transmissive = (FEATURES & FEATURE_TRANSMISSION) != 0u && largestOf(xyzOf(through)) > 0.0f;
    p.absorption = xyzOf(absorption);
    p.thin = (through.w & SURFACE_THIN) != 0u;
    uvec4 emission = scene_at(material + 4u);
    p.emission = xyzOf(emission);
    p.medium = emission.w;
    return p;
}
