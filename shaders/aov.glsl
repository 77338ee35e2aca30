// What the ray through a pixel meets first, as it is kept beside the picture: of surfaces that alpha cuts out or blends, the
// first that is there by half at least.
//
// Whoever includes this declares primaryHits[] and the counter `counted` besides what begin() and surfaceAt() ask for, and
// includes gather.glsl and surface.glsl.

// The share of the light that falls in along the normal which a surface sends on in any way: what is scattered and
// mirrored, or, of a surface that lets light through, scattered and let through of what Fresnel's law does not reflect.
vec3 albedoOf(SurfacePoint p) {
    precise vec3 opaque =
        vec3((1.0f - p.metallic) * p.dielectric) + p.metallic * p.metal + (1.0f - p.dielectric) * p.diffuse;
    precise vec3 clear = p.diffuse + p.through;
    return p.transmissive ? clear : opaque;
}

PrimaryHit nothingFound(uint pixel) {
    return PrimaryHit(vec3(0.0f), uintBitsToFloat(0x7f800000u), vec3(0.0f), 0.0f, vec3(0.0f), 0.0f, NO_HIT, NO_HIT, NO_HIT,
                      pixel);
}

// Slot i of a tile that has begun: its ray rays[i] has met hits[i], its nearest.
// Ensures  that is what the slot has found. But where less than half of the surface is there, it has found nothing yet: its
//          ray goes on behind that, and is counted; with `compacts` no ray goes on. Those that do not meet nothing from now
//          on, and change no more what was found.
void findPrimaryHit(uint i) {
    Ray ray = rays[i];
    Hit hit = hits[i];
    PrimaryHit found = nothingFound(states[i].pixel);
    bool goesOn = false;
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
        if ((FEATURES & FEATURE_COVERAGE) != 0u && p.coverage < 0.5f) {
            found = nothingFound(states[i].pixel);
            goesOn = now.compacts == 0u;
        }
    }
    if ((FEATURES & FEATURE_COVERAGE) != 0u) {
        bool hasEnded = ray.tMin > ray.tMax;
        if (hasEnded) return;
        if (goesOn) {
            rays[i].tMin = nextFloat(hit.t, 1.0f);
            atomicAdd(counted, 1u);
        } else {
            rays[i] = noRay();
        }
    }
    primaryHits[i] = found;
}
