#version 450
// Writes which reference a pixel of the item buffer shows.
layout(constant_id = 1) const bool HAS_SPHERES = false;

layout(location = 0) flat in uvec2 item;
layout(location = 1) in vec2 onDisk;
layout(location = 0) out uvec2 words;

void main() {
    if (HAS_SPHERES && dot(onDisk, onDisk) > 1.0) discard;
    words = item;
}
