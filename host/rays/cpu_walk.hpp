/// The walks of shaders/structures/, compiled as C++: the very statements that a device runs, over the very bytes.
#pragma once

#include "rays/tracer.hpp"

namespace raig {

struct WalkOptions {
    bool anyHit = false;
    bool skipSeeThrough = false;
};

/// Walks `structure` with each ray, on the calling thread; adds to `counters`. One such function a file, made from
/// cpu_walk.cpp.in. Throws CorruptStructure if a walk goes on beyond mostStepsOf(structure).
using CpuWalk = void (*)(const Structure& structure, WalkOptions options, std::span<const Ray> rays, std::span<Hit> hits,
                         WalkCounters& counters);

/// The walk of this file of shaders/structures/ (Structure::walkFile).
CpuWalk cpuWalk(std::string_view walkFile);

/// At least as many loop iterations as a walk of a sound structure makes for one ray: the walk's own mostSteps().
uint64_t mostStepsOf(const Structure& structure);

}  // namespace raig
