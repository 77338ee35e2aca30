/// How long a structure takes over a set of rays, apart from bringing the rays to it.
#pragma once

#include "device/buffer.hpp"
#include "rays/tracer.hpp"

#include <chrono>
#include <functional>
#include <vector>

namespace raig {

/// By the wall clock.
double secondsSince(std::chrono::steady_clock::time_point start);

struct Quartiles {
    double median = 0.0, q1 = 0.0, q3 = 0.0;
};

/// Of at least one value; between two, the mean of them by their distance.
Quartiles quartilesOf(std::vector<double> values);

/// Millions of rays a second, from what each of some runs over `rays` took.
Quartiles megaRaysOf(const std::vector<double>& seconds, uint64_t rays);

/// Rays that stay where they are traced, once on the CPU or on a device: what is timed is the walk, not the way there.
/// The tracer, its device and the rays must outlive it.
class ResidentRays {
public:
    ResidentRays(Tracer& tracer, std::span<const Ray> rays, Query query);

    static constexpr size_t batchRays = 1u << 21;
    /// `device` is the tracer's. `batch`: how many rays a buffer holds. Throws limitError where there is no room for rays
    /// and hits, 48 bytes each.
    ResidentRays(DeviceTracer& tracer, Device& device, std::span<const Ray> rays, Query query, size_t batch = batchRays);

    /// The same of what else traces on a device: rays of one buffer into hits of another, to the end.
    using TraceBuffers = std::function<TraceReport(Buffer& rays, Buffer& hits, uint32_t count)>;
    ResidentRays(TraceBuffers trace, Device& device, std::span<const Ray> rays, size_t batch = batchRays);

    ResidentRays(const ResidentRays&) = delete;
    ResidentRays& operator=(const ResidentRays&) = delete;

    /// Traces all of them. `seconds` is wall time; `counters` are the CPU's, or those of a tracer that counts.
    TraceReport trace();
    /// What was hit in the last trace().
    const std::vector<Hit>& hits();

private:
    struct Batch {
        Buffer rays, hits;
        uint32_t count;
    };

    std::vector<Hit> hits_;
    std::function<TraceReport()> traceOnCpu_;
    TraceBuffers traceBuffers_;
    std::vector<Batch> batches_;  ///< on a device, as one buffer holds only so much
};

}  // namespace raig
