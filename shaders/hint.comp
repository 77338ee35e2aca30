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

// What is shown at an item of the window; NO_HINT where that does not reach.
uvec2 itemAt(vec2 at) {
    vec2 size = vec2(frame.partWidth, window.rows) * float(window.scale);
    bool inside = at.x >= 0.0 && at.y >= 0.0 && at.x < size.x && at.y < size.y;  // false for what is no number
    return inside ? items[uint(at.y) * frame.partWidth * window.scale + uint(at.x)] : uvec2(NO_HINT, 0u);
}

// Hints of the ray that crosses the picture there: each of the four nearest items once.
void writeHints(uint ray, vec2 place) {
    vec2 at = (place - vec2(0.0, window.firstRow)) * float(window.scale);
    vec2 own = floor(at);
    vec2 aside = vec2(at.x - own.x < 0.5 ? -1.0 : 1.0, at.y - own.y < 0.5 ? -1.0 : 1.0);
    uvec2 found[HINTS_A_RAY] = uvec2[](itemAt(own), itemAt(own + vec2(aside.x, 0.0)), itemAt(own + vec2(0.0, aside.y)),
                                       itemAt(own + aside));
    uint kept = 0u;
    for (uint k = 0u; k < HINTS_A_RAY; ++k) {
        bool isNew = found[k].x != NO_HINT;
        for (uint j = 0u; j < k; ++j) isNew = isNew && found[j] != found[k];
        if (isNew) hints[HINTS_A_RAY * ray + kept++] = found[k];
    }
    for (; kept < HINTS_A_RAY; ++kept) hints[HINTS_A_RAY * ray + kept] = uvec2(NO_HINT, 0u);
}

void main() {
    uint i = entryIndex();
    if (i >= now.count) return;
    uint slot = slotList[now.listAt + i];
    bool fromCamera = false;
    if (slot != NO_SLOT) fromCamera = states[slot].depth == 0u;
    // The rest of a ray begins behind what the buffer shows.
    if ((FEATURES & FEATURE_COVERAGE) != 0u && fromCamera) fromCamera = states[slot].passes == 0u;
    if (fromCamera)
        writeHints(i, crossing(rays[i]));
    else
        hints[HINTS_A_RAY * i].x = NO_HINT;
}
