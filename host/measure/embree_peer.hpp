/// Embree, the peer that raig is measured against on the CPU [Wald et al. 2014, "Embree: A Kernel Framework for Efficient
/// CPU Ray Tracing"].
#pragma once

#include "rays/tracer.hpp"
#include "scene/geometry.hpp"

#include <memory>
#include <span>

namespace raig {

/// One scene in Embree: default (not robust) and of medium build quality, traced ray by ray.
class EmbreePeer {
public:
    /// Builds over the scene's triangles with as many threads as oneTBB may use. Nothing where raig was built without
    /// Embree.
    static std::unique_ptr<EmbreePeer> make(const Geometry& geometry);
    ~EmbreePeer();

    double buildSeconds() const { return buildSeconds_; }
    /// Traces the rays over all threads, by rtcIntersect1 (closest) or rtcOccluded1 (any). Returns seconds; `hits`, how many
    /// hit.
    double trace(std::span<const Ray> rays, Query query, size_t& hits);

private:
    struct State;
    explicit EmbreePeer(std::unique_ptr<State> state, double buildSeconds);

    std::unique_ptr<State> state_;
    double buildSeconds_;
};

}  // namespace raig
