#version 450
// Lets shadow rays pass through what their hits leave of them: one ray an invocation.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
#include "frame.glsl"
#include "pass.glsl"

void main() {
    uint i = entryIndex();
    if (i < now.count) pass(i);
}
