#version 450
// Goes on with pixels that have some samples already: one slot an invocation.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
#include "frame.glsl"

void main() {
    uint i = entryIndex();
    if (i < now.count) resume(i);
}
