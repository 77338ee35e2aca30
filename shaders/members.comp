#version 450
// Copies structs that cross the border, whole and member by member: tests/shared_structs_test.cpp compares.
#extension GL_GOOGLE_include_directive : require

#include "shared/language.glsl"
#include "shared/rays.glsl"
#include "shared/structure.glsl"
#include "shared/frame.glsl"
#include "shared/items.glsl"

layout(local_size_x = 1) in;
layout(set = 0, binding = 0, std430) buffer WordBlock { uint words[]; };  // the members', one struct's after the other's

// Two of each, so that the distance between elements is seen too: the second is made equal to the first.
layout(set = 0, binding = 1, std430) buffer RayBlock { Ray rays[2]; };
layout(set = 0, binding = 2, std430) buffer HitBlock { Hit hits[2]; };
layout(set = 0, binding = 3, std430) buffer HeaderBlock { StructureHeader headers[2]; };
layout(set = 0, binding = 4, std430) buffer ParamsBlock { FrameParams params[2]; };
layout(set = 0, binding = 5, std430) buffer StepBlock { TileStep steps[2]; };
layout(set = 0, binding = 6, std430) buffer StateBlock { PathState states[2]; };
layout(set = 0, binding = 7, std430) buffer PendingBlock { PendingRay pending[2]; };
layout(set = 0, binding = 8, std430) buffer ResultBlock { PixelResult results[2]; };
layout(set = 0, binding = 9, std430) buffer PrimaryBlock { PrimaryHit primaryHits[2]; };
layout(set = 0, binding = 10, std430) buffer ViewBlock { ItemView views[2]; };
layout(set = 0, binding = 11, std430) buffer CallBlock { ItemCall calls[2]; };
layout(set = 0, binding = 12, std430) buffer WindowBlock { ItemWindow windows[2]; };
layout(push_constant) uniform Push { TileStep pushed; };

uint at = 0u;
void put(uint x) { words[at++] = x; }
void put(float x) { put(floatBitsToUint(x)); }
void put(vec3 v) { put(v.x); put(v.y); put(v.z); }
void put(vec4 v) { put(v.xyz); put(v.w); }

#include "members.glsl"

void main() {
    putAll(rays[0]);
    putAll(hits[0]);
    putAll(headers[0]);
    putAll(params[0]);
    putAll(steps[0]);
    putAll(states[0]);
    putAll(pending[0]);
    putAll(results[0]);
    putAll(primaryHits[0]);
    putAll(views[0]);
    putAll(calls[0]);
    putAll(windows[0]);
    putAll(pushed);
    rays[1] = rays[0];
    hits[1] = hits[0];
    headers[1] = headers[0];
    params[1] = params[0];
    steps[1] = steps[0];
    states[1] = states[0];
    pending[1] = pending[0];
    results[1] = results[0];
    primaryHits[1] = primaryHits[0];
    views[1] = views[0];
    calls[1] = calls[0];
    windows[1] = windows[0];
}
