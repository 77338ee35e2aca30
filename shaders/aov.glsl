// What the ray through a pixel meets first, as it is kept beside the picture.
//
// Whoever includes this declares primaryHits[] besides what begin() and surfaceAt() ask for, and includes gather.glsl and
// surface.glsl.

// The share of the light that falls in along the normal which a surface sends on in any way: what is scattered and
// mirrored, or, of a surface that lets light through, scattered and let through of what Fresnel's law does not reflect.
vec3 albedoOf(SurfacePoint p) {
    precise vec3 opaque =
        vec3((1.0f - p.metallic) * p.dielectric) + p.metallic * p.metal + (1.0f - p.dielectric) * p.diffuse;
    precise vec3 clear = p.diffuse + p.through;
    return p.transmissive ? clear : opaque;
}

// Slot i of a tile that has begun: its ray rays[i] has met hits[i].
void findPrimaryHit(uint i) {
    Ray ray = rays[i];
    Hit hit = hits[i];
    PrimaryHit found = PrimaryHit(vec3(0.0f), uintBitsToFloat(0x7f800000u), vec3(0.0f), 0.0f, vec3(0.0f), 0.0f, NO_HIT,
                                  NO_HIT, NO_HIT, states[i].pixel);
    if (hit.primitive != NO_HIT) {
        SurfacePoint p = surfaceAt(ray, hit, 0.0f);
        uvec4 triangle = facetOf(hit.primitive).triangle;
        bool isSphere = (FEATURES & FEATURE_SPHERES) != 0u && triangle.y == NO_VERTEX;
        vec2 uv = vec2(hit.u, hit.v);
        if ((FEATURES & FEATURE_UVS) != 0u) {
            uv = vec2(0.0f, 0.0f);
            precise float b0 = 1.0f - hit.u - hit.v;
            if (!isSphere) uv = textureCoordinates(triangle, vec3(b0, hit.u, hit.v), 0u);
        }
        found = PrimaryHit(p.at.position, hit.t, p.shading, uv.x, albedoOf(p), uv.y, hit.primitive, NO_HIT, triangle.w,
                           states[i].pixel);
    }
    primaryHits[i] = found;
}
