#version 450
// Looks up, for each ray of the list that comes from the camera, what the item buffer shows where it goes through the
// picture. One ray an invocation. Where that is follows from the ray, so this knows nothing of how samples are placed.
#extension GL_GOOGLE_include_directive : require

#include "frame_buffers.glsl"
#include "shared/items.glsl"

layout(set = 0, binding = 12, std430) writeonly buffer HintBlock { uvec2 hints[]; };
layout(set = 0, binding = 13, std430) readonly buffer ItemBlock {
    ItemWindow window;
    uvec2 items[];
};

// Where the ray crosses the picture, in pixels of the part that is rendered. (Those through a lens go through the place that
// is in focus: the pinhole's, unless that is far away.)
vec2 crossing(Ray ray) {
    vec3 along = ray.direction;
    vec3 from = ray.origin - frame.eye;
    float depth = dot(along, frame.forward);
    if ((FEATURES & FEATURE_LENS) != 0u && frame.lensSlope > 0.0) {
        float focus = frame.lensRadius / frame.lensSlope;
        from += along * (focus / depth);
        depth = frame.orthographic != 0u ? 1.0 : focus;
    } else if (frame.orthographic != 0u) {
        depth = 1.0;
    } else {
        from = along;
    }
    vec2 place = vec2(dot(from, frame.right) / frame.halfWidth, -dot(from, frame.up) / frame.halfHeight) / depth;
    return (place * 0.5 + 0.5) * vec2(frame.width, frame.height) - vec2(frame.left, frame.top);
}

uvec2 itemAt(vec2 place) {
    float scale = float(window.scale);
    vec2 at = floor((place - vec2(0.0, window.firstRow)) * scale);
    vec2 size = vec2(frame.partWidth, window.rows) * scale;
    bool inside = at.x >= 0.0 && at.y >= 0.0 && at.x < size.x && at.y < size.y;  // false for what is no number
    return inside ? items[uint(at.y) * frame.partWidth * window.scale + uint(at.x)] : uvec2(NO_ITEM);
}

void main() {
    uint i = entryIndex();
    if (i >= now.count) return;
    uint slot = slotList[now.listAt + i];
    bool fromCamera = false;
    if (slot != NO_SLOT) fromCamera = states[slot].depth == 0u;
    hints[i] = fromCamera ? itemAt(crossing(rays[i])) : uvec2(NO_HINT);
}
