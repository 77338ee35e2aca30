// Copies elements of a large array to a plain buffer: what shared/load.glsl promises, put to the test.
#version 450
#extension GL_GOOGLE_include_directive : require
#include "shared/load.glsl"

layout(local_size_x_id = 0) in;
layout(constant_id = 1) const uint CHUNKS = 1u;
layout(constant_id = 2) const uint SHIFT = 31u;

RAIG_ARRAY(source, 0)
layout(set = 0, binding = 1, std430) writeonly buffer Copies { uvec4 copies[]; };
layout(push_constant) uniform Push { uint first; uint count; };

RAIG_ARRAY_AT(source, CHUNKS, SHIFT)

void main() {
    uint i = gl_GlobalInvocationID.x;
    if (i < count) copies[i] = source_at(first + i);
}
