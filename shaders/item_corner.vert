#version 450
// Draws a structure's references: three vertices each, pulled out of the very arrays that walks read.
//
// What is drawn is a hint only, so nothing here is `precise`. A sphere is drawn as a triangle around the disk that is its
// outline, which item_word.frag cuts out.
#extension GL_GOOGLE_include_directive : require

#include "shared/language.glsl"
#include "shared/structure.glsl"
#include "shared/place.glsl"
#include "shared/load.glsl"
#include "shared/items.glsl"

layout(constant_id = 0) const bool INSTANCED = false;    // two levels
layout(constant_id = 1) const bool HAS_SPHERES = false;  // some of the references are spheres
layout(constant_id = 2) const uint NODE_CHUNKS = 1;
layout(constant_id = 3) const uint NODE_SHIFT = 0;
layout(constant_id = 4) const uint TRIANGLE_CHUNKS = 1;
layout(constant_id = 5) const uint TRIANGLE_SHIFT = 0;

RAIG_ARRAY(storedNodes, 0)
RAIG_ARRAY(storedTriangles, 1)
layout(set = 0, binding = 2, std430) readonly buffer ListBlock { uint instances[]; };

layout(push_constant) uniform Push {
    ItemView view;
    ItemCall call;
};

layout(location = 0) flat out uvec2 item;
layout(location = 1) out vec2 onDisk;  // of a sphere: within the unit circle inside its outline

RAIG_ARRAY_AT(storedNodes, NODE_CHUNKS, NODE_SHIFT)
RAIG_ARRAY_AT(storedTriangles, TRIANGLE_CHUNKS, TRIANGLE_SHIFT)

Placement placementOf(uint instance) {
    uint at = view.instancesAt + instance * INSTANCE_STRIDE;
    return Placement(uintBitsToFloat(storedNodes_at(at)), uintBitsToFloat(storedNodes_at(at + 1u)),
                     uintBitsToFloat(storedNodes_at(at + 2u)));
}

// A corner of the triangle around the sphere's outline, all relative to the eye: around nothing, if that is inside. The
// outline is a circle about centre - centre r^2 / d^2, in the plane across the line of sight.
vec3 cornerAround(vec3 centre, float radius, uint corner) {
    bool parallel = view.w.w != 0.0;
    float share = parallel ? 0.0 : radius * radius / dot(centre, centre);
    vec3 away = normalize(parallel ? -view.z.xyz : centre);
    vec3 side = normalize(cross(abs(away.x) < 0.6 ? vec3(1, 0, 0) : vec3(0, 1, 0), away));
    onDisk = corner == 0u ? vec2(0.0, 2.0) : vec2(corner == 1u ? -1.7320508 : 1.7320508, -1.0);
    float outline = share < 1.0 ? radius * sqrt(1.0 - share) : 0.0;
    return centre * (1.0 - share) + outline * (onDisk.x * side + onDisk.y * cross(away, side));
}

void main() {
    uint corner = uint(gl_VertexIndex) % 3u;
    uint reference = call.first + uint(gl_VertexIndex) / 3u;
    uint instance = 0u;
    if (INSTANCED) instance = instances[call.listAt + uint(gl_InstanceIndex)];
    uint at = call.referencesAt + reference * TRIANGLE_STRIDE;
    bool isSphere = false;
    float radius = 0.0;
    if (HAS_SPHERES) {
        uvec4 second = storedTriangles_at(at + 1u);
        isSphere = (second.w & TRIANGLE_SPHERE) != 0u;
        radius = uintBitsToFloat(second.x);
    }
    vec3 point = uintBitsToFloat(storedTriangles_at(at + (isSphere ? 0u : corner)).xyz);
    if (INSTANCED) {
        Placement placement = placementOf(instance);
        point = placePoint(placement, point);
        radius *= placement.x.x;
    }
    point -= view.eye;
    onDisk = vec2(0.0);
    if (isSphere) point = cornerAround(point, radius, corner);
    vec4 p = vec4(point, 1.0);
    vec4 place = vec4(dot(view.x, p), dot(view.y, p), dot(view.z, p), dot(view.w, p));
    // What is no number, or nearly none, is put where it is clipped.
    bool sound = all(lessThan(abs(place), vec4(1e30)));
    gl_Position = sound ? place : vec4(0.0, 0.0, -1.0, 1.0);
    item = uvec2(reference, instance);
}
