#version 450
// Describes what the rays of a tile's pixels have met, and lets them pass what is not there: one slot an invocation.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
layout(set = 0, binding = 12, std430) writeonly buffer PrimaryBlock { PrimaryHit primaryHits[]; };
#include "frame.glsl"
#include "aov.glsl"

void main() {
    uint i = entryIndex();
    if (i < now.count) findPrimaryHit(i);
}
