// How textures lie on triangles: their coordinates, how much of them a ray covers, and the normals that they bend.
//
// Whoever includes this declares `frame`, scene_at(i) and the constant FEATURES before it, and includes facet.glsl and
// texture.glsl.

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
// have tangents, else from the triangle's texture coordinates. uv1 and uv2 lead from its first corner to the
// others in transformed texture coordinates.
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
