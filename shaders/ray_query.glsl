// Traces rays by the driver's own ray query: what `raig bench` measures raig's walks against, where a device has it.
#version 460
#extension GL_GOOGLE_include_directive : require
#extension GL_EXT_ray_query : require
#include "shared/rays.glsl"

layout(local_size_x = 128) in;  // as every device has it

layout(set = 0, binding = 0) uniform accelerationStructureEXT scene;
layout(set = 0, binding = 1, std430) restrict readonly buffer Rays { Ray rays[]; };
layout(set = 0, binding = 2, std430) restrict writeonly buffer Hits { Hit hits[]; };
layout(push_constant) uniform Push {
    uint first;
    uint end;
    uint anyHit;
};

void main() {
    const uint i = first + gl_GlobalInvocationID.x;
    if (i >= end) return;
    const Ray ray = rays[i];
    const uint flags = gl_RayFlagsOpaqueEXT | (anyHit != 0 ? gl_RayFlagsTerminateOnFirstHitEXT : gl_RayFlagsNoneEXT);
    rayQueryEXT query;
    rayQueryInitializeEXT(query, scene, flags, 0xffu, ray.origin, ray.tMin, ray.direction, ray.tMax);
    while (rayQueryProceedEXT(query)) {}
    if (rayQueryGetIntersectionTypeEXT(query, true) == gl_RayQueryCommittedIntersectionNoneEXT) {
        hits[i] = Hit(ray.tMax, 0.0, 0.0, NO_HIT);
        return;
    }
    const vec2 at = rayQueryGetIntersectionBarycentricsEXT(query, true);
    hits[i] = Hit(rayQueryGetIntersectionTEXT(query, true), at.x, at.y,
                  uint(rayQueryGetIntersectionPrimitiveIndexEXT(query, true)));
}
