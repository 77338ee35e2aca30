/// What is seen first in each pixel, for tests.
#pragma once

#include "rays/primary_hits.hpp"
#include "support/rendering.hpp"

#include <cstring>

namespace raig::test {

inline PrimaryHits onCpu(const Stage& stage, const FrameOptions& options) {
    return findPrimaryHits(stage.scene, stage.geometry, *makeCpuTracer(stage.structure), options);
}

inline PrimaryHits onDevice(Device& device, const Stage& stage, const FrameOptions& options) {
    const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
    return findPrimaryHits(device, stage.scene, stage.geometry, *tracer, options);
}

inline bool haveSameBits(const PrimaryHit& a, const PrimaryHit& b) {
    return std::memcmp(&a, &b, sizeof(PrimaryHit)) == 0;
}

inline bool haveSameBits(const PrimaryHits& a, const PrimaryHits& b) {
    return a.pixels.size() == b.pixels.size() && !a.pixels.empty() &&
           std::memcmp(a.pixels.data(), b.pixels.data(), a.pixels.size() * sizeof(PrimaryHit)) == 0;
}

}  // namespace raig::test
