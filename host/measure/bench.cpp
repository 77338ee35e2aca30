#include "measure/bench.hpp"

#include "base/error.hpp"
#include "device/buffer.hpp"
#include "measure/embree_peer.hpp"
#include "rays/primitives.hpp"

#include <algorithm>
#include <chrono>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

constexpr uint32_t warmUps = 2;

double secondsSince(Clock::time_point start) { return std::chrono::duration<double>(Clock::now() - start).count(); }

Quartiles scaled(const std::vector<double>& seconds, double rays) {
    std::vector<double> rates;
    for (const double s : seconds) rates.push_back(rays / s * 1e-6);
    return quartilesOf(rates);
}

/// Rays that stay where they are traced: what is measured is the walk, not the way there.
class Traced {
public:
    Traced(Tracer& tracer, DeviceTracer* onDevice, Device* device, std::span<const Ray> rays, Query query)
        : tracer_(tracer), onDevice_(onDevice), rays_(rays), query_(query), hits_(rays.size()) {
        if (!device) return;
        rayBuffer_.emplace(*device, rays.size_bytes());
        hitBuffer_.emplace(*device, rays.size() * sizeof(Hit));
        rayBuffer_->uploadValues(rays);
    }

    double run() {
        const Clock::time_point start = Clock::now();
        if (onDevice_)
            onDevice_->traceBuffers(*rayBuffer_, *hitBuffer_, static_cast<uint32_t>(rays_.size()), query_, false);
        else
            tracer_.trace(rays_, hits_, query_);
        return secondsSince(start);
    }

    uint64_t countHits() {
        if (hitBuffer_) hitBuffer_->download(std::as_writable_bytes(std::span(hits_)));
        return static_cast<uint64_t>(
            std::count_if(hits_.begin(), hits_.end(), [](const Hit& hit) { return hit.primitive != NO_HIT; }));
    }

private:
    Tracer& tracer_;
    DeviceTracer* onDevice_;
    std::span<const Ray> rays_;
    Query query_;
    std::vector<Hit> hits_;
    std::optional<Buffer> rayBuffer_, hitBuffer_;
};

/// The measurements of one structure.
class StructureBench {
public:
    StructureBench(const Geometry& geometry, const BenchSettings& settings, const std::string& name, BenchReport& report)
        : geometry_(geometry), settings_(settings), name_(name), report_(report) {}

    void build(const std::vector<Primitive>& triangles) {
        std::vector<double> seconds, ratios;
        for (uint32_t i = 0; i < settings_.repetitions; ++i) {
            peer_ = EmbreePeer::make(geometry_);
            const Clock::time_point start = Clock::now();
            structure_ = structureType(name_).build(triangles, settings_.params);
            seconds.push_back(secondsSince(start));
            if (peer_) ratios.push_back(seconds.back() / peer_->buildSeconds());
            if (seconds.back() > 10.0) break;  // what takes so long is not noise
        }
        BenchBuild& build = report_.builds.emplace_back(BenchBuild{name_, structure_.walk, quartilesOf(seconds), {}, {}});
        if (!ratios.empty()) build.toEmbree = quartilesOf(ratios);
        build.statistics = structure_.statistics;
        cpu_ = makeCpuTracer(structure_);
        if (settings_.device) {
            device_ = std::make_unique<Device>(*settings_.device);
            onDevice_ = makeDeviceTracer(*device_, structure_);
        }
    }

    RaySets makeSets() {
        const MeasuringCamera camera = measuringCamera(geometry_, geometry_.bounds);
        return makeRaySets(geometry_, geometry_.bounds, camera, settings_.side, *cpu_);
    }

    void trace(const char* what, const std::vector<Ray>& rays, Query query) {
        BenchResult result{name_, structure_.walk, what, rays.size(), 0, 0, {}, {}, {}, {}};
        if (rays.empty()) return;
        Traced traced(*cpu_, onDevice_.get(), device_.get(), rays, query);
        std::vector<double> own, peers, ratios;
        for (uint32_t i = 0; i < warmUps + settings_.repetitions; ++i) {
            size_t hits = 0;
            const double theirs = peer_ ? peer_->trace(rays, query, hits) : 0.0, ours = traced.run();
            result.embreeHits = hits;
            if (i < warmUps) continue;
            own.push_back(ours);
            if (!peer_) continue;
            peers.push_back(theirs);
            ratios.push_back(theirs / ours);
        }
        result.hits = traced.countHits();
        std::vector<Hit> ignored(rays.size());
        result.counters = cpu_->trace(rays, ignored, query).counters;
        result.megaRays = scaled(own, static_cast<double>(rays.size()));
        if (peer_) {
            result.embree = scaled(peers, static_cast<double>(rays.size()));
            result.toEmbree = quartilesOf(ratios);
        }
        report_.results.push_back(result);
    }

private:
    const Geometry& geometry_;
    const BenchSettings& settings_;
    const std::string& name_;
    BenchReport& report_;
    std::unique_ptr<EmbreePeer> peer_;
    Structure structure_;
    std::unique_ptr<Device> device_;
    std::unique_ptr<Tracer> cpu_;
    std::unique_ptr<DeviceTracer> onDevice_;
};

}  // namespace

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

BenchReport bench(const Geometry& geometry, const BenchSettings& settings,
                  const std::function<void(const std::string&, double)>& progress) {
    BenchReport report;
    const std::vector<Primitive> triangles = primitivesOf(geometry);
    const double steps = 6.0 * static_cast<double>(settings.structures.size());
    double step = 0.0;
    for (const std::string& name : settings.structures) {
        StructureBench one(geometry, settings, name, report);
        progress("building " + name, step++ / steps);
        one.build(triangles);
        progress("making rays", step++ / steps);
        const RaySets sets = one.makeSets();
        const auto trace = [&](const char* what, const std::vector<Ray>& rays, Query query) {
            progress(name + ": " + what, step++ / steps);
            one.trace(what, rays, query);
        };
        trace("primary", sets.primary, Query::closest);
        trace("shadow", sets.shadow, Query::any);
        trace("diffuse", sets.diffuse, Query::closest);
        trace("specular", sets.specular, Query::closest);
    }
    return report;
}

}  // namespace raig
