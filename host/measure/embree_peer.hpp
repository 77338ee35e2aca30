/// Embree, the peer that raig is measured against on the CPU [Wald et al. 2014, "Embree: A Kernel Framework for Efficient
/// CPU Ray Tracing"].
#pragma once

#include "rays/tracer.hpp"
#include "scene/geometry.hpp"

#include <memory>
#include <optional>
#include <span>
#include <string>

namespace raig {

/// One scene in Embree, of medium build quality.
class EmbreePeer {
public:
    /// Builds over the scene's triangles and spheres with as many threads as oneTBB may use. Nothing where raig was built
    /// without Embree, or Embree cannot.
    static std::unique_ptr<EmbreePeer> make(const Geometry& geometry);
    ~EmbreePeer();

    double buildSeconds() const { return buildSeconds_; }

    /// Builds a second time, with Embree's scene flag "robust", which leaves fewer gaps between triangles. False where
    /// Embree cannot.
    bool makeRobust(const Geometry& geometry);

    /// How rays are handed over: one by one, by rtcIntersect1 (closest) or rtcOccluded1 (any); or eight at once, in the
    /// order they have, by rtcIntersect8 or rtcOccluded8. Embree walks packets in another way where it is told that they are
    /// coherent: up to twice as fast where they are, and at two thirds of the speed where not (measured).
    enum class Width { single, packet8, coherentPacket8 };
    struct Traced {
        double seconds;
        uint64_t hits;
    };
    /// Traces the rays over all threads. They are copied into Embree's own layout before, which is not timed. Memory: 80
    /// bytes a ray, kept: all ways use the same, as packets are as fast as their memory. `robust` requires makeRobust().
    Traced trace(std::span<const Ray> rays, Query query, Width width = Width::single, bool robust = false);
    /// What the last trace() found, of closest hits: t, and ids of the geometry; u and v are 0. Requires hits.size() rays in
    /// that trace, of that width.
    void copyHits(std::span<Hit> hits, Width width) const;

private:
    struct State;
    explicit EmbreePeer(std::unique_ptr<State> state, double buildSeconds);

    std::unique_ptr<State> state_;
    double buildSeconds_;
};

/// As in "3.13.5"; nothing where raig was built without Embree.
std::optional<std::string> embreeVersion();

}  // namespace raig
