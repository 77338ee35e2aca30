// References to primitives as they lie in memory: three uvec4 each (shared/structure.glsl).
//
// Whoever includes this declares before it triangles_at(i), SKIP_SEE_THROUGH, HAS_SPHERES, COUNT_TRIANGLE(did) and
// RAIG_INSTANCED: 1 if there may be two levels, then also INSTANCED, whether there are, and it includes instances.glsl.
#include "sphere.glsl"

// Tests reference `index`, a triangle or, where the structure has any (HAS_SPHERES), a sphere. True if it became the best
// hit.
bool testTriangle(WalkRay ray, uint index, INOUT(Hit) best) {
    uvec4 a = triangles_at(index * TRIANGLE_STRIDE);
    uvec4 b = triangles_at(index * TRIANGLE_STRIDE + 1u);
    uvec4 c = triangles_at(index * TRIANGLE_STRIDE + 2u);
    COUNT_TRIANGLE(true)
    bool obstacle = !SKIP_SEE_THROUGH || (b.w & TRIANGLE_SEE_THROUGH) == 0u;
    vec3 first = vec3(uintBitsToFloat(a.x), uintBitsToFloat(a.y), uintBitsToFloat(a.z));
    vec3 second = vec3(uintBitsToFloat(b.x), uintBitsToFloat(b.y), uintBitsToFloat(b.z));
    vec3 third = vec3(uintBitsToFloat(c.x), uintBitsToFloat(c.y), uintBitsToFloat(c.z));
    bool isSphere = HAS_SPHERES && (b.w & TRIANGLE_SPHERE) != 0u;
    bool hit = false;
#if RAIG_INSTANCED
    if (INSTANCED) {
        uint id = inside.firstId + a.w;
        if (isSphere) {
            // Spheres are written out: all that may be between them and the world is a power of two.
            float radius = second.x * inside.placement.x.x;
            hit = intersectSphere(inside.ray, placePoint(inside.placement, first), radius, id, obstacle, inside.best);
        } else {
            hit = intersectPlaced(first, second, third, id, obstacle);
        }
        best.t = hit ? localDistance(inside.best.t) : best.t;
        return hit;
    }
#endif
    if (isSphere) {
        hit = intersectSphere(ray, first, second.x, a.w, obstacle, best);
    } else {
        hit = intersectTriangle(ray, first, second, third, a.w, obstacle, best);
    }
    return hit;
}
