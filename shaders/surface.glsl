// What a ray finds where it hits: the point, the normals, and the surface in the terms of host/scene/surface.hpp.
//
// Whoever includes this declares `frame`, scene_at(i) and the constant FEATURES before it, and includes shared/place.glsl,
// spawn.glsl and texture.glsl.

struct SurfacePoint {
    BoundedPoint at;
    vec3 normal;         // n: of the triangle or sphere, on the ray's side
    vec3 smooth_;        // interpolated from the vertices, on the ray's side
    vec3 shading;        // ns: that, bent by the normal texture
    bool front;          // the ray came from where the corners run counterclockwise, or from outside the sphere
    vec3 lift;           // from there to where shadow rays start: see liftOf()
    vec3 diffuse;        // before the share that the dielectric mirrors is taken off
    float gloss;         // the share of what is mirrored that the reflected ray brings
    float metallic;      // the share that is metal; the rest is a dielectric
    vec3 metal;          // what the metal reflects along the normal; at grazing it reflects all
    float dielectric;    // what the dielectric reflects along the normal ...
    float grazing;       // ... and at grazing
    float roughness;
    float ior;
    vec3 through;
    bool transmissive;   // lets light through at all, before textures
    vec3 absorption;
    bool thin;
    uint medium;         // what is within, if it is known to be closed: see media.glsl
    vec3 emission;
    float coverage;      // how much of the surface is there: the rest of the light passes straight on
    float glow;          // by area, the density with which a path's light is drawn here; 0: it is not
    float openness;      // the share of ambient light that the occlusion texture lets in
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

// A corner's texture coordinates of set 0 or 1.
vec2 uvOfVertex(uint vertex, uint set_) {
    uint at = vertexElement(vertex);
    if ((FEATURES & FEATURE_MORE_UVS) != 0u && set_ == 1u) {
        uvec4 more = scene_at(at + ((FEATURES & FEATURE_TANGENTS) != 0u ? 3u : 2u));
        return vec2(uintBitsToFloat(more.x), uintBitsToFloat(more.y));
    }
    return vec2(uintBitsToFloat(scene_at(at).w), uintBitsToFloat(scene_at(at + 1u).w));
}

// The texture coordinates of a set at barycentric coordinates b. Requires FEATURE_UVS.
vec2 textureCoordinates(uvec4 triangle, vec3 b, uint set_) {
    precise vec2 uv = b.x * uvOfVertex(triangle.x, set_) + b.y * uvOfVertex(triangle.y, set_) +
                      b.z * uvOfVertex(triangle.z, set_);
    return uv;
}

// The side of the square of texture coordinates of a set that a ray covers which is `width` across where it meets the
// triangle at the angle of that cosine: the square of the ray's cross section, as long as its ellipse on the triangle is,
// and the triangle's own scale by area (ray cones: Akenine-Moeller et al. 2019, section 20.3.4); of a sliver it may be
// anything.
float coveredUvs(uvec4 triangle, Corners corners, uint set_, float width, float cosine) {
    vec2 uv0 = uvOfVertex(triangle.x, set_);
    precise vec2 uv1 = uvOfVertex(triangle.y, set_) - uv0;
    precise vec2 uv2 = uvOfVertex(triangle.z, set_) - uv0;
    precise vec3 ab = corners.b - corners.a;
    precise vec3 ac = corners.c - corners.a;
    float scaleAb = unitScale(ab);
    float scaleAc = unitScale(ac);
    vec3 cross_ = crossOf(ab * scaleAb, ac * scaleAc);
    float scale = unitScale(cross_);
    precise vec3 scaled = cross_ * scale;
    precise float area = sqrt(dot(scaled, scaled)) / scale;  // of the scaled triangle, twice
    precise float uvArea = abs(uv1.x * uv2.y - uv2.x * uv1.y);
    precise float density = sqrt(uvArea / area * scaleAb * scaleAc);
    precise float covered = width / cosine * density;
    return covered;
}

// What a hit's look-ups have in common: the triangle, barycentric coordinates, and what the ray covers of each set.
struct Look {
    uvec4 triangle;
    vec3 b;
    float covered;
    float coveredMore;
};

vec4 lookUp(Look look, uint texture_, bool encoded) {
    uint set_ = (FEATURES & FEATURE_MORE_UVS) != 0u ? textureSet(texture_) : 0u;
    vec2 uv = textureCoordinates(look.triangle, look.b, set_);
    return textureAt(texture_, uv, set_ == 1u ? look.coveredMore : look.covered, encoded);
}

// Where u of a normal texture grows on the triangle, unit length or zero, and 1 or -1: times the cross product of the normal
// (that of the corners' order) and it, where the texture's y grows, which is upwards, against v. From the vertices where all
// have tangents, else from the triangle's texture coordinates. `dv`s are those of the transformed coordinates.
vec4 tangentAt(Facet facet, Corners corners, vec3 b, vec2 uv1, vec2 uv2) {
    if ((FEATURES & FEATURE_TANGENTS) != 0u) {
        uvec4 stored0 = scene_at(vertexElement(facet.triangle.x) + 2u);
        vec4 t0 = rowOf(stored0);
        vec4 t1 = rowOf(scene_at(vertexElement(facet.triangle.y) + 2u));
        vec4 t2 = rowOf(scene_at(vertexElement(facet.triangle.z) + 2u));
        float hand = t0.w;
        if ((FEATURES & FEATURE_INSTANCES) != 0u) {
            Placement placement = Placement(rowOf(scene_at(facet.instance)), rowOf(scene_at(facet.instance + 1u)),
                                            rowOf(scene_at(facet.instance + 2u)));
            if ((scene_at(facet.instance + 5u).w & 1u) != 0u) hand = -hand;
            t0 = vec4(placeTangent(placement, t0), t0.w);
            t1 = vec4(placeTangent(placement, t1), t1.w);
            t2 = vec4(placeTangent(placement, t2), t2.w);
        }
        precise vec4 sum = b.x * t0 + b.y * t1 + b.z * t2;
        if (t0.w != 0.0f && t1.w != 0.0f && t2.w != 0.0f) return vec4(sum.x, sum.y, sum.z, hand);
    }
    precise float turn = uv1.x * uv2.y - uv2.x * uv1.y;
    float sign_ = turn > 0.0f ? 1.0f : -1.0f;
    precise vec3 ab = corners.b - corners.a;
    precise vec3 ac = corners.c - corners.a;
    float scale = unitScale(vec3(largestOf(abs(ab)), largestOf(abs(ac)), 0.0f));
    precise vec3 along = sign_ * (uv2.y * (ab * scale) - uv1.y * (ac * scale));
    vec3 tangent = along * unitScale(along);
    return turn == 0.0f ? vec4(0.0f) : vec4(tangent.x, tangent.y, tangent.z, -sign_);
}

// `normal`, of the front, as the material's normal texture bends it.
vec3 bentNormal(Facet facet, Corners corners, Look look, uint texture_, float scale, vec3 normal) {
    uint set_ = (FEATURES & FEATURE_MORE_UVS) != 0u ? textureSet(texture_) : 0u;
    vec2 uv0 = uvOfVertex(facet.triangle.x, set_);
    precise vec2 uv1 = uvOfVertex(facet.triangle.y, set_) - uv0;
    precise vec2 uv2 = uvOfVertex(facet.triangle.z, set_) - uv0;
    vec4 tangent = tangentAt(facet, corners, look.b, transformed(texture_, uv1, 0.0f), transformed(texture_, uv2, 0.0f));
    vec3 t = vec3(tangent.x, tangent.y, tangent.z);
    precise vec3 across = t - dot(normal, t) * normal;
    precise float square = dot(across, across);
    if (!(square > 1e-6f)) return normal;
    precise vec3 x = across / sqrt(square);
    precise vec3 y = tangent.w * crossOf(normal, x);
    vec4 value = lookUp(look, texture_, false);
    precise vec3 sum = (scale * (2.0f * value.x - 1.0f)) * x + (scale * (2.0f * value.y - 1.0f)) * y +
                       (2.0f * value.z - 1.0f) * normal;
    return dot(sum, sum) > 1e-6f ? unit(sum) : normal;
}

// The radiance that a triangle sends out by itself at barycentric coordinates b.
vec3 emissionAt(uvec4 triangle, vec3 b, float covered, float coveredMore) {
    uint material = frame.materialsAt + triangle.w * MATERIAL_STRIDE;
    vec3 emission = xyzOf(scene_at(material + 1u));
    if ((FEATURES & FEATURE_EMISSION_TEXTURES) == 0u) return emission;
    uint texture_ = scene_at(material + 4u).w;
    if (texture_ == NO_TEXTURE) return emission;
    vec4 value = lookUp(Look(triangle, b, covered, coveredMore), texture_, true);
    precise vec3 tinted = emission * vec3(value.x, value.y, value.z);
    return tinted;
}

// How much of a surface is there where `alpha` is what varies of it.
float coverageOf(uint material, float alpha) {
    uvec4 more = scene_at(material + 3u);
    precise float all = uintBitsToFloat(more.y) * ((more.w & SURFACE_ALPHA_VARIES) != 0u ? alpha : 1.0f);
    float cutoff = uintBitsToFloat(scene_at(material + 6u).x);
    float cut = all >= cutoff ? 1.0f : 0.0f;
    if ((FEATURES & FEATURE_BLENDS) == 0u) return cut;
    return cutoff > 0.0f ? cut : all;
}

// The density, by area, with which a path takes points of an emitting triangle to be drawn. They are drawn by the mean of
// the emission's texture; that this leaves out what textures do makes light that two kinds of rays find no brighter, as both
// go by it.
float glowOf(uvec4 triangle) {
    vec3 emission = xyzOf(scene_at(frame.materialsAt + triangle.w * MATERIAL_STRIDE + 1u));
    precise float glow = (0.2126f * emission.x + 0.7152f * emission.y + 0.0722f * emission.z) * frame.emitterScale;
    return glow;
}

// A material in the terms of host/scene/surface.hpp, its factors as they are at a point.
void reduceMaterial(uint material, vec3 base, float metallic, float roughness, INOUT(SurfacePoint) p) {
    uvec4 absorption = scene_at(material + 2u);
    uvec4 more = scene_at(material + 3u);
    float transmission = uintBitsToFloat(more.x);
    p.ior = uintBitsToFloat(absorption.w);
    p.absorption = xyzOf(absorption);
    p.thin = (more.w & SURFACE_THIN) != 0u;
    p.medium = scene_at(material + 5u).w;
    precise float polish = max(0.0f, 1.0f - 2.0f * roughness);
    precise float blur = max(0.0f, 2.0f * roughness - 1.0f);
    precise float shine = 1.0f - blur * blur;
    float normalReflectance = uintBitsToFloat(more.z);
    precise float gloss = polish * polish;
    if ((FEATURES & FEATURE_PATH) != 0u) gloss = roughness * roughness < LEAST_DRAWN_SPREAD ? 1.0f : 0.0f;
    precise vec3 diffuse = ((1.0f - metallic) * (1.0f - transmission)) * base;
    precise float dielectric = shine * normalReflectance;
    precise float grazing = shine * min(1.0f, 50.0f * normalReflectance);
    precise vec3 through = ((1.0f - metallic) * transmission) * base;
    p.gloss = gloss;
    p.diffuse = diffuse;
    p.metallic = metallic;
    p.metal = base;
    p.dielectric = dielectric;
    p.grazing = grazing;
    p.roughness = roughness;
    p.through = through;
    p.transmissive = (FEATURES & FEATURE_TRANSMISSION) != 0u && (more.w & SURFACE_TRANSMITS) != 0u;
}

// The mean of the vertices' colours at barycentric coordinates b.
vec4 vertexColour(uvec4 triangle, vec3 b) {
    uint last = frame.vertexStride - 1u;
    precise vec4 colour = b.x * rowOf(scene_at(vertexElement(triangle.x) + last)) +
                          b.y * rowOf(scene_at(vertexElement(triangle.y) + last)) +
                          b.z * rowOf(scene_at(vertexElement(triangle.z) + last));
    return colour;
}

// The coverage of a triangle, or a sphere, at barycentric coordinates b for a ray of no width.
float coverageAt(uvec4 triangle, vec3 b) {
    uint material = frame.materialsAt + triangle.w * MATERIAL_STRIDE;
    float alpha = 1.0f;
    if ((FEATURES & FEATURE_SPHERES) == 0u || triangle.y != NO_VERTEX) {
        if ((FEATURES & FEATURE_COLORS) != 0u) alpha = vertexColour(triangle, b).w;
        if ((FEATURES & FEATURE_COLOR_TEXTURES) != 0u) {
            uint texture_ = scene_at(material + 4u).x;
            if (texture_ != NO_TEXTURE) {
                precise float both = alpha * lookUp(Look(triangle, b, 0.0f, 0.0f), texture_, true).w;
                alpha = both;
            }
        }
    }
    return coverageOf(material, alpha);
}

// What is in the way of a shadow ray at `hit`: the coverage there; with `throughGlass` 0 if the surface lets light through
// by its material.
float shadeOf(Hit hit, bool throughGlass) {
    uvec4 triangle = facetOf(hit.primitive).triangle;
    precise float b0 = 1.0f - hit.u - hit.v;
    bool transmits = (scene_at(frame.materialsAt + triangle.w * MATERIAL_STRIDE + 3u).w & SURFACE_TRANSMITS) != 0u;
    return transmits && throughGlass ? 0.0f : coverageAt(triangle, vec3(b0, hit.u, hit.v));
}

// Where the ray meets the triangle, with its normals and its material. `width` is that of the ray there.
void meetTriangle(Facet facet, Ray ray, Hit hit, float width, INOUT(SurfacePoint) p) {
    uvec4 triangle = facet.triangle;
    Corners corners = cornersOf(facet);
    precise float b0 = 1.0f - hit.u - hit.v;
    vec3 b = vec3(b0, hit.u, hit.v);
    p.at = pointOf(corners.a, corners.b, corners.c, hit.u, hit.v);
    vec3 faced = faceNormal(corners.a, corners.b, corners.c, -ray.direction);
    precise float cosine = dot(ray.direction, faced);
    p.front = cosine < 0.0f;
    p.normal = p.front ? faced : -faced;
    p.smooth_ = p.normal;
    if ((FEATURES & FEATURE_NORMALS) != 0u) {
        Corners normals = vertexNormals(facet);
        p.smooth_ = interpolatedNormal(normals, b, p.normal);
        if ((FEATURES & (FEATURE_LIGHTS | FEATURE_EMITTERS | FEATURE_SHINING | FEATURE_PATH)) != 0u)
            p.lift = liftOf(corners, normals, b, p.at.position, p.normal);
    }
    p.shading = p.smooth_;

    uint material = frame.materialsAt + triangle.w * MATERIAL_STRIDE;
    uvec4 first = scene_at(material);
    vec3 base = xyzOf(first);
    float metallic = uintBitsToFloat(first.w);
    float roughness = uintBitsToFloat(scene_at(material + 1u).w);
    Look look = Look(triangle, b, 0.0f, 0.0f);
    float alpha = 1.0f;
    if ((FEATURES & FEATURE_COLORS) != 0u) {
        vec4 colour = vertexColour(triangle, b);
        base = base * vec3(colour.x, colour.y, colour.z);
        alpha = colour.w;
    }
    if ((FEATURES & FEATURE_TEXTURES) != 0u) {
        uvec4 textures = scene_at(material + 4u);
        uvec4 last = scene_at(material + 5u);
        look.covered = coveredUvs(triangle, corners, 0u, width, abs(cosine));
        if ((FEATURES & FEATURE_MORE_UVS) != 0u)
            look.coveredMore = coveredUvs(triangle, corners, 1u, width, abs(cosine));
        if ((FEATURES & FEATURE_COLOR_TEXTURES) != 0u && textures.x != NO_TEXTURE) {
            vec4 value = lookUp(look, textures.x, true);
            base = base * vec3(value.x, value.y, value.z);
            precise float both = alpha * value.w;
            alpha = both;
        }
        if ((FEATURES & FEATURE_ROUGHNESS_TEXTURES) != 0u && textures.y != NO_TEXTURE) {
            vec4 value = lookUp(look, textures.y, false);
            roughness = roughness * value.y;
            metallic = metallic * value.z;
        }
        if ((FEATURES & FEATURE_NORMAL_TEXTURES) != 0u && textures.z != NO_TEXTURE) {
            float side = p.front ? 1.0f : -1.0f;
            p.shading = side * bentNormal(facet, corners, look, textures.z, uintBitsToFloat(last.z), side * p.shading);
        }
        if ((FEATURES & FEATURE_OCCLUSION_TEXTURES) != 0u && last.x != NO_TEXTURE) {
            float strength = uintBitsToFloat(last.y);
            precise float open = 1.0f + strength * (lookUp(look, last.x, false).x - 1.0f);
            p.openness = open;
        }
    }
    if ((FEATURES & (FEATURE_NORMALS | FEATURE_NORMAL_TEXTURES)) != 0u && p.shading != p.normal)
        p.shading = facingNormal(p.shading, ray.direction);
    if ((FEATURES & FEATURE_COVERAGE) != 0u) p.coverage = coverageOf(material, alpha);
    p.emission = emissionAt(triangle, b, look.covered, look.coveredMore);
    if ((FEATURES & FEATURE_PATH) != 0u && (FEATURES & FEATURE_EMITTERS) != 0u) p.glow = glowOf(triangle);
    reduceMaterial(material, base, metallic, roughness, p);
}

// The same for a sphere: the point at the hit's t, projected to the surface. It has neither texture nor vertex colours.
void meetSphere(uvec4 triangle, Ray ray, Hit hit, INOUT(SurfacePoint) p) {
    uvec4 sphere = scene_at(frame.spheresAt + triangle.x);
    vec3 centre = xyzOf(sphere);
    precise vec3 away = ray.origin - centre + hit.t * ray.direction;
    precise vec3 scaled = away * unitScale(away);
    vec3 outwards = unit(scaled);
    p.at = pointOfSphere(centre, uintBitsToFloat(sphere.w), outwards);
    p.front = dot(ray.direction, outwards) < 0.0f;
    p.normal = p.front ? outwards : -outwards;
    p.smooth_ = p.normal;
    p.shading = p.normal;
    uint material = frame.materialsAt + triangle.w * MATERIAL_STRIDE;
    uvec4 first = scene_at(material);
    uvec4 second = scene_at(material + 1u);
    if ((FEATURES & FEATURE_COVERAGE) != 0u) p.coverage = coverageOf(material, 1.0f);
    p.emission = xyzOf(second);
    reduceMaterial(material, xyzOf(first), uintBitsToFloat(first.w), uintBitsToFloat(second.w), p);
}

// What `ray` (unit direction) finds at `hit`, after light from its origin has `travelled` so far to the camera. Requires
// hit.primitive != NO_HIT. The ray is as wide as the pixel that it comes from is seen there, straightened out: mirrors and
// lenses on the way are taken as flat.
SurfacePoint surfaceAt(Ray ray, Hit hit, float travelled) {
    Facet facet = facetOf(hit.primitive);
    precise float pixel = 2.0f * frame.halfHeight / float(frame.height);
    precise float width = pixel * (travelled + hit.t);
    SurfacePoint p;
    p.openness = 1.0f;
    p.coverage = 1.0f;
    p.lift = vec3(0.0f);
    if ((FEATURES & FEATURE_PATH) != 0u) p.glow = 0.0f;
    if ((FEATURES & FEATURE_SPHERES) != 0u && facet.triangle.y == NO_VERTEX) {
        meetSphere(facet.triangle, ray, hit, p);
    } else {
        meetTriangle(facet, ray, hit, frame.orthographic != 0u ? pixel : width, p);
    }
    return p;
}
