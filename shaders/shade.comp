#version 450
// Shades the hits of a tile's rays: one slot an invocation.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
#include "frame.glsl"

void main() {
    uint i = entryIndex();
    if (i < now.count) shade(i);
}
