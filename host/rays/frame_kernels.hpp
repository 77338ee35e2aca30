/// The frame's code as the CPU runs it: shaders/frame.glsl, its buffers plain memory.
#pragma once

#include "rays/frame_types.hpp"

#include <atomic>
#include <span>

namespace raig::shared {

/// Begin, shade and gather for slots of one tile. Different slots may be worked on at the same time.
/// The names are those of shaders/frame_buffers.glsl; each array is as long as the kernels' contracts ask.
struct FrameKernels {
    uint FEATURES = 0;
    bool BRANCHES = false;
    FrameParams frame{};
    TileStep now{};
    uint counted = 0;
    uint* slotList = nullptr;
    PathState* states = nullptr;
    Ray* rays = nullptr;
    const Hit* hits = nullptr;
    PendingRay* pending = nullptr;
    Ray* shadowRays = nullptr;
    const Hit* shadowHits = nullptr;
    vec4* contributions = nullptr;
    PixelResult* results = nullptr;
    PrimaryHit* primaryHits = nullptr;
    std::span<const uvec4> scene;

    uvec4 scene_at(uint i) const { return scene[i]; }
    static uint atomicAdd(uint& counter, uint value) {
        return std::atomic_ref(counter).fetch_add(value, std::memory_order_relaxed);
    }

#include "frame.glsl"
#include "aov.glsl"
#include "pass.glsl"
};

}  // namespace raig::shared
