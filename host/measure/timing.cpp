#include "measure/timing.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <chrono>

namespace raig {

double secondsSince(std::chrono::steady_clock::time_point start) {
    return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

Quartiles quartilesOf(std::vector<double> values) {
    RAIG_CHECK(!values.empty());
    std::sort(values.begin(), values.end());
    const auto at = [&](double share) {
        const double place = share * static_cast<double>(values.size() - 1);
        const auto below = static_cast<size_t>(place);
        const size_t above = std::min(below + 1, values.size() - 1);
        return values[below] + (values[above] - values[below]) * (place - static_cast<double>(below));
    };
    return {at(0.5), at(0.25), at(0.75)};
}

Quartiles megaRaysOf(const std::vector<double>& seconds, uint64_t rays) {
    std::vector<double> rates;
    for (const double s : seconds) rates.push_back(static_cast<double>(rays) / std::max(s, 1e-9) * 1e-6);
    return quartilesOf(rates);
}

ResidentRays::ResidentRays(Tracer& tracer, std::span<const Ray> rays, Query query)
    : hits_(rays.size()), traceOnCpu_([this, &tracer, rays, query] { return tracer.trace(rays, hits_, query); }) {}

ResidentRays::ResidentRays(DeviceTracer& tracer, Device& device, std::span<const Ray> rays, Query query, size_t batch)
    : ResidentRays([&tracer, query](Buffer& from, Buffer& to,
                                    uint32_t count) { return tracer.traceBuffers(from, to, count, query, false); },
                   device, rays, batch) {}

ResidentRays::ResidentRays(TraceBuffers trace, Device& device, std::span<const Ray> rays, size_t batch)
    : hits_(rays.size()), traceBuffers_(std::move(trace)) {
    for (size_t first = 0; first < rays.size(); first += batch) {
        const size_t count = std::min(batch, rays.size() - first);
        batches_.push_back(
            {Buffer(device, count * sizeof(Ray)), Buffer(device, count * sizeof(Hit)), static_cast<uint32_t>(count)});
        batches_.back().rays.uploadValues(rays.subspan(first, count));
    }
}

TraceReport ResidentRays::trace() {
    const auto start = std::chrono::steady_clock::now();
    TraceReport sum;
    if (traceOnCpu_) sum = traceOnCpu_();
    for (Batch& batch : batches_) {
        const TraceReport report = traceBuffers_(batch.rays, batch.hits, batch.count);
        sum.deviceSeconds += report.deviceSeconds;
        sum.counters += report.counters;
    }
    sum.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return sum;
}

const std::vector<Hit>& ResidentRays::hits() {
    std::span<Hit> rest(hits_);
    for (const Batch& batch : batches_) {
        batch.hits.download(std::as_writable_bytes(rest.first(batch.count)));
        rest = rest.subspan(batch.count);
    }
    return hits_;
}

}  // namespace raig
