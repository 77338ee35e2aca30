/// Batches of rays to hits, over a structure that is resident on a device or in the CPU's memory.
#pragma once

#include "device/device.hpp"
#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <memory>
#include <span>
#include <stdexcept>

namespace raig {

class BigArray;
class Buffer;
class Commands;

/// What a walk did, summed over rays; counted only where asked for, as counting costs time.
struct WalkCounters {
    uint64_t nodeFetches = 0;    ///< nodes or cells read, each time
    uint64_t triangleTests = 0;
    uint64_t boxTests = 0;       ///< bounds of nodes, whatever kind, against a ray: a node may hold those of its children
    uint64_t linkReads = 0;      ///< links that lie apart from nodes

    WalkCounters& operator+=(const WalkCounters& other) {
        nodeFetches += other.nodeFetches;
        triangleTests += other.triangleTests;
        boxTests += other.boxTests;
        linkReads += other.linkReads;
        return *this;
    }
};

struct TraceReport {
    double seconds = 0.0;        ///< wall time, transfers excluded
    double deviceSeconds = 0.0;  ///< by the device's own clock; 0 where it has none
    double uploadSeconds = 0.0;
    WalkCounters counters;
    uint64_t failedHints = 0;    ///< that did not name what the ray meets
};

/// Thrown where a walk goes on for longer than any of a sound structure does: links lead it around. What findFault() finds
/// no fault with is sound; this is for what became of it in memory later: a bug, so it is no Error.
class CorruptStructure : public std::logic_error {
public:
    explicit CorruptStructure(const Structure& structure);
};

/// Traces rays against one structure. Not for use by two threads at once.
class Tracer {
public:
    virtual ~Tracer() = default;

    /// hits[i] = what rays[i] meets. closest: the nearest, ties to the lowest id. any: the first the walk meets, which is a
    /// hit exactly where closest has one. Requires hits.size() == rays.size(). Throws CorruptStructure.
    virtual TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) = 0;

    /// As trace, any: but triangles marked as letting light through (Structure::markSeeThrough) are no hits.
    virtual TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) = 0;

    /// As traceShadows if `shadows`, else as trace; and costs[i] = the nodes fetched and primitives tested by rays[i].
    /// Slower: kernels that count are others than those that do not. Requires costs.size() == rays.size(), and Query::any
    /// for shadows.
    virtual TraceReport traceCosts(std::span<const Ray> rays, std::span<Hit> hits, Query query, bool shadows,
                                   std::span<uint32_t> costs) = 0;
};

/// The walk on the CPU, over all cores; always counts. `structure` must outlive it.
std::unique_ptr<Tracer> makeCpuTracer(const Structure& structure);

/// The walk on a Vulkan device: `structure` is copied there. Throws limitError if it does not fit.
class DeviceTracer : public Tracer {
public:
    /// Records the trace of `count` rays of a device buffer (Ray, tightly packed) into another (Hit), and runs it to the
    /// end: rays whose walk is longer than one dispatch may be are taken up again until all are done.
    /// `shadows`: as traceShadows. The buffers must have storage usage; `count` > 0.
    /// `hints` (shared/items.glsl, HINTS_A_RAY a ray; none for shadows) tell what each ray may meet: the hits are the same,
    /// to the bit, but found sooner where a hint is right. `first`: which ray, and hit, of the buffers is the first of them.
    virtual TraceReport traceBuffers(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows,
                                     const Buffer* hints = nullptr, uint32_t first = 0) = 0;

    /// As traceBuffers, and costs of each ray as traceCosts has them. Requires costs.size() == count.
    virtual TraceReport traceBuffersCosts(Buffer& rays, Buffer& hits, uint32_t count, Query query, bool shadows,
                                          std::span<uint32_t> costs, const Buffer* hints = nullptr, uint32_t first = 0) = 0;

    /// The structure's arrays on the device.
    virtual const BigArray& nodes() const = 0;
    virtual const BigArray& references() const = 0;
};

std::unique_ptr<DeviceTracer> makeDeviceTracer(Device& device, const Structure& structure, bool counting = false);

}  // namespace raig
