#version 450
// Adds the light that was not in shadow and moves each slot on: one slot an invocation.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
#include "frame.glsl"

void main() {
    uint i = entryIndex();
    if (i < now.count) gather(i);
}
