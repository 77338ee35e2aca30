// What a ray finds where it hits: the point, the normals, and the surface in the terms of host/scene/surface.hpp.
//
// Whoever includes this declares `frame`, scene_at(i) and the constant FEATURES before it, and includes spawn.glsl,
// facet.glsl and texture_mapping.glsl.

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
