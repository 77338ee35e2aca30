#include "base/parallel.hpp"
#include "rays/adaptive.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/frame_tiles.hpp"

#include <chrono>

namespace raig {

using namespace shared;

namespace {

using Clock = std::chrono::steady_clock;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

/// Tiles in the CPU's memory: small enough to stay in its caches.
class CpuTiles : public FrameTiles {
public:
    CpuTiles(FrameData& data, Tracer& tracer, uint32_t slots) : data_(data), tracer_(tracer), slots_(slots) {
        const SlotBytes bytes = slotBytes(data);
        const size_t shadowRays = size_t{slots} * data.params.shadowRays;
        list_.resize(2 * size_t{slots});
        states_.resize(slots);
        rays_.resize(slots);
        hits_.resize(slots);
        pending_.resize(size_t{slots} * bytes.pendingRays);
        shadowRays_.resize(shadowRays);
        shadowHits_.resize(shadowRays);
        contributions_.resize(shadowRays);
        results_.resize(slots);
        data.params.slots = slots;

        kernels_.FEATURES = data.features;
        kernels_.BRANCHES = bytes.pendingRays > 0;
        kernels_.frame = data.params;
        kernels_.slotList = list_.data();
        kernels_.states = states_.data();
        kernels_.rays = rays_.data();
        kernels_.hits = hits_.data();
        kernels_.pending = pending_.data();
        kernels_.shadowRays = shadowRays_.data();
        kernels_.shadowHits = shadowHits_.data();
        kernels_.contributions = contributions_.data();
        kernels_.results = results_.data();
        kernels_.scene = data.elements;
    }

    void setSamples(uint32_t samples) override { kernels_.frame.samples = samples; }
    void sendStates(std::span<const PathState> states) override { std::ranges::copy(states, states_.begin()); }
    uint32_t slots() const override { return slots_; }
    double longestSeconds() const override { return 0.05; }

    double run(FrameKernel kernel, const TileStep& step) override {
        const Clock::time_point start = Clock::now();
        kernels_.now = step;
        if (kernel != FrameKernel::pass || step.listAt == 0) kernels_.counted = 0;
        parallelFor(step.count, 256, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) runOne(kernel, static_cast<uint32_t>(i));
        });
        return secondsSince(start);
    }

    double trace(uint32_t count) override {
        return tracer_.trace(std::span(rays_).first(count), std::span(hits_).first(count), Query::closest).seconds;
    }
    double traceShadows(uint32_t count) override {
        const uint32_t through = raysThroughGlass(data_, count);
        const auto rays = std::span(shadowRays_).first(count);
        const auto hits = std::span(shadowHits_).first(count);
        return tracer_.traceShadows(rays.first(through), hits.first(through)).seconds +
               tracer_.trace(rays.subspan(through), hits.subspan(through), Query::any).seconds;
    }
    double traceCosts(std::span<uint32_t> costs) override {
        return tracer_
            .traceCosts(std::span(rays_).first(costs.size()), std::span(hits_).first(costs.size()), Query::closest, false,
                        costs)
            .seconds;
    }
    double traceShadowsCosts(std::span<uint32_t> costs) override {
        const uint32_t through = raysThroughGlass(data_, static_cast<uint32_t>(costs.size()));
        const auto rays = std::span(shadowRays_).first(costs.size());
        const auto hits = std::span(shadowHits_).first(costs.size());
        const auto trace = [&](size_t first, size_t count, bool shadows) {
            return tracer_
                .traceCosts(rays.subspan(first, count), hits.subspan(first, count), Query::any, shadows,
                            costs.subspan(first, count))
                .seconds;
        };
        return trace(0, through, true) + trace(through, costs.size() - through, false);
    }
    double traceShadowsToNearest(uint32_t count) override {
        return tracer_.trace(std::span(shadowRays_).first(count), std::span(shadowHits_).first(count), Query::closest)
            .seconds;
    }
    double traceShadowsToNearestCosts(std::span<uint32_t> costs) override {
        return tracer_
            .traceCosts(std::span(shadowRays_).first(costs.size()), std::span(shadowHits_).first(costs.size()),
                        Query::closest, false, costs)
            .seconds;
    }
    void readList(uint32_t at, std::span<uint32_t> slots) override {
        std::copy_n(list_.begin() + at, slots.size(), slots.begin());
    }
    uint32_t counted() override { return kernels_.counted; }
    void read(std::span<PixelResult> results) override {
        std::copy_n(results_.begin(), results.size(), results.begin());
    }

private:
    void runOne(FrameKernel kernel, uint32_t i) {
        switch (kernel) {
            case FrameKernel::begin: return kernels_.begin(i);
            case FrameKernel::shade: return kernels_.shade(i);
            case FrameKernel::gather: return kernels_.gather(i);
            case FrameKernel::resume: return kernels_.resume(i);
            case FrameKernel::pass: return kernels_.pass(i);
        }
    }

    const FrameData& data_;
    Tracer& tracer_;
    uint32_t slots_;
    FrameKernels kernels_;
    std::vector<uint32_t> list_;
    std::vector<PathState> states_;
    std::vector<Ray> rays_;
    std::vector<Hit> hits_;
    std::vector<PendingRay> pending_;
    std::vector<Ray> shadowRays_;
    std::vector<Hit> shadowHits_;
    std::vector<vec4> contributions_;
    std::vector<PixelResult> results_;
};

}  // namespace

Picture renderPicture(const Scene& scene, const Geometry& geometry, Tracer& tracer, const FrameOptions& options,
                      const FrameProgress& progress) {
    const Clock::time_point start = Clock::now();
    checkOptions(scene, options);
    FrameData data = packFrame(scene, geometry);
    setView(scene, geometry, withMargin(options), data);
    takeOptions(options, data);
    constexpr uint64_t tileBytes = uint64_t{64} << 20;
    CpuTiles tiles(data, tracer, chooseSlots(options.tilePixels, tileBytes / slotBytes(data).all, data));
    Picture picture;
    picture.statistics.setupSeconds = secondsSince(start);
    renderTiles(tiles, data, options, progress, picture);
    picture.statistics.seconds = secondsSince(start);
    return picture;
}

}  // namespace raig
