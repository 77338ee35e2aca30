/// What charts time and judge: a structure on a device or the CPU, or a peer.
#pragma once

#include "device/device.hpp"
#include "measure/sweep.hpp"
#include "rays/tracer.hpp"
#include "scene/geometry.hpp"

#include <functional>

namespace raig {

struct TraceSubject {
    /// Traces; returns seconds. Fills `hits` if that is not empty.
    std::function<double(std::span<const Ray>, std::span<Hit>, Query)> trace;
    Json facts = Json::object();                                     ///< of its build
    bool isExact = false;                                            ///< it must have the yardstick's very bits
    std::function<WalkCounters(std::span<const Ray>, Query)> count;  ///< where it counts
};

/// Throws usageError if the settings (accel and a structure's options) ask for what there is not.
void checkTraceSubject(const Json& settings);

/// Builds it: `accel` is a structure; embree, embree-robust, embree-packet8 or embree-packet8-robust; or textbook, a control
/// (measure/naive_bvh.hpp). `device`: none, the CPU path. Throws limitError where raig was built without Embree, and what
/// building and uploading throw.
TraceSubject makeTraceSubject(const Json& settings, const Geometry& geometry, const std::vector<Primitive>& primitives,
                              Device* device);

}  // namespace raig
