// The bindings of the frame's kernels on a device. (The CPU's are the members of host/rays/frame_kernels.hpp.)
#include "shared/language.glsl"
#include "shared/rays.glsl"
#include "shared/frame.glsl"
#include "shared/load.glsl"
#include "shared/place.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint FEATURES = 0;  // FEATURE_* of what the scene has
layout(constant_id = 2) const uint SCENE_CHUNKS = 1;
layout(constant_id = 3) const uint SCENE_SHIFT = 31;

layout(set = 0, binding = 0, std430) readonly buffer FrameBlock { FrameParams frame; };
layout(set = 0, binding = 1, std430) buffer CountBlock { uint counted; };
layout(set = 0, binding = 2, std430) buffer ListBlock { uint slotList[]; };
layout(set = 0, binding = 3, std430) buffer StateBlock { PathState states[]; };
layout(set = 0, binding = 4, std430) buffer RayBlock { Ray rays[]; };
layout(set = 0, binding = 5, std430) readonly buffer HitBlock { Hit hits[]; };
layout(set = 0, binding = 6, std430) buffer PendingBlock { PendingRay pending[]; };
layout(set = 0, binding = 7, std430) buffer ShadowRayBlock { Ray shadowRays[]; };
layout(set = 0, binding = 8, std430) readonly buffer ShadowHitBlock { Hit shadowHits[]; };
layout(set = 0, binding = 9, std430) buffer ContributionBlock { vec4 contributions[]; };
layout(set = 0, binding = 10, std430) writeonly buffer ResultBlock { PixelResult results[]; };
RAIG_ARRAY(scene, 11)

const bool BRANCHES = (FEATURES & (FEATURE_MIRRORS | FEATURE_TRANSMISSION | FEATURE_COVERAGE | FEATURE_PATH)) != 0u;

layout(push_constant) uniform Push { TileStep now; };

RAIG_ARRAY_AT(scene, SCENE_CHUNKS, SCENE_SHIFT)

// Software devices give each core a contiguous half of the groups; taking blocks from both halves in turn balances them.
uint entryIndex() {
    uint group = gl_WorkGroupID.x;
    uint firstHalf = (gl_NumWorkGroups.x + 1u) / 2u;
    uint block = group < firstHalf ? 2u * group : 2u * (group - firstHalf) + 1u;
    return block * gl_WorkGroupSize.x + gl_LocalInvocationID.x;
}
