#include "measure/bench.hpp"

#include "base/error.hpp"
#include "measure/driver_peer.hpp"
#include "measure/embree_peer.hpp"
#include "rays/primitives.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>

namespace raig {

namespace {

constexpr uint32_t warmUps = 2;
constexpr double shortest = 0.02;   // seconds: a pair of runs that takes less is repeated, as others may have the processor
constexpr double mostTimes = 20.0;  // it is
constexpr double longTime = 10.0;   // seconds: what takes so long is done once

/// One set of rays, and what they are asked for.
struct Batch {
    const char* name;
    const std::vector<Ray>& rays;
    Query query;
    bool coherent;  ///< neighbours go much the same way
};

/// What is timed over a batch: a structure on a device, or Embree in one of its ways.
struct Entrant {
    BenchResult result;
    std::function<TraceReport(uint64_t& hits)> trace;
    std::vector<double> seconds = {}, deviceSeconds = {}, embreeSeconds = {}, ratios = {};
    uint32_t times = 1;  ///< it runs for one measurement
};

/// One structure, walked on each device.
struct Walked {
    Structure structure;
    std::unique_ptr<Tracer> cpu;
    std::vector<std::unique_ptr<DeviceTracer>> onDevices;  ///< none: the CPU path
};

class SceneBench {
public:
    SceneBench(const Geometry& geometry, const BenchSettings& settings,
               const std::function<void(const std::string&, double)>& progress)
        : geometry_(geometry), settings_(settings), progress_(progress), primitives_(primitivesOf(geometry)) {
        for (const auto& info : settings.devices) devices_.push_back(info ? std::make_unique<Device>(*info) : nullptr);
    }

    BenchReport run() {
        for (const std::string& name : settings_.structures) {
            progress_("building " + name, share());
            const std::unique_ptr<Walked> walked = build(name);
            if (name == settings_.structures.front()) {
                progress_("making rays", share());
                const MeasuringCamera camera = measuringCamera(geometry_, geometry_.bounds);
                sets_ = makeRaySets(geometry_, geometry_.bounds, camera, settings_.side, *walked->cpu);
                measuresPeers_ = embree_ && embree_->makeRobust(geometry_);
                makeDrivers();
            }
            for (const Batch& batch : batches()) {
                progress_(name + ": " + batch.name, share());
                ++stepsDone_;
                if (!batch.rays.empty()) measure(*walked, batch);
            }
            measuresPeers_ = false;  // but once
            drivers_.clear();
        }
        return std::move(report_);
    }

private:
    std::vector<Batch> batches() const {
        std::vector<Batch> all;
        for (const Batch& batch :
             {Batch{"primary", sets_.primary, Query::closest, true}, Batch{"shadow", sets_.shadow, Query::any, true},
              Batch{"diffuse", sets_.diffuse, Query::closest, false},
              Batch{"specular", sets_.specular, Query::closest, true}}) {
            all.push_back(batch);
            const Query other = batch.query == Query::any ? Query::closest : Query::any;
            if (settings_.bothQueries) all.push_back({batch.name, batch.rays, other, batch.coherent});
        }
        return all;
    }

    double share() const { return double(stepsDone_) / (double(settings_.structures.size()) * double(batches().size())); }

    std::unique_ptr<Walked> build(const std::string& name) {
        auto walked = std::make_unique<Walked>();
        std::vector<double> seconds, ratios;
        for (uint32_t i = 0; i < settings_.repetitions; ++i) {
            embree_ = EmbreePeer::make(geometry_);
            const auto start = std::chrono::steady_clock::now();
            walked->structure = structureType(name).build(primitives_, settings_.params);
            seconds.push_back(std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count());
            if (embree_) ratios.push_back(seconds.back() / embree_->buildSeconds());
            if (seconds.back() > longTime) break;
        }
        const Structure& structure = walked->structure;
        BenchBuild& build =
            report_.builds.emplace_back(BenchBuild{name, structure.walk, quartilesOf(seconds), {}, structure.statistics});
        if (!ratios.empty()) build.toEmbree = quartilesOf(ratios);
        walked->cpu = makeCpuTracer(structure);
        for (const auto& device : devices_)
            walked->onDevices.push_back(device ? makeDeviceTracer(*device, structure) : nullptr);
        return walked;
    }

    /// Each entrant in turn with Embree, one entrant after the other, and all that again.
    void measure(Walked& walked, const Batch& batch) {
        std::vector<Entrant> entrants = waysOfEmbree(batch);
        addDrivers(batch, entrants);
        addWalks(walked, batch, entrants);
        uint64_t embreeHits = 0;
        for (uint32_t i = 0; i < warmUps + settings_.repetitions; ++i)
            for (Entrant& entrant : entrants) {
                if (!entrant.seconds.empty() && entrant.seconds.front() > longTime) continue;
                double embree = 0.0, own = 0.0, device = 0.0;
                for (uint32_t k = 0; k < entrant.times; ++k) {
                    if (embree_) {
                        const EmbreePeer::Traced traced = embree_->trace(batch.rays, batch.query);
                        embree += traced.seconds / entrant.times;
                        embreeHits = traced.hits;
                    }
                    const TraceReport report = entrant.trace(entrant.result.hits);
                    own += report.seconds / entrant.times;
                    device += report.deviceSeconds / entrant.times;
                }
                if (i < warmUps && own <= longTime) {
                    entrant.times = static_cast<uint32_t>(std::clamp(std::ceil(shortest / (embree + own)), 1.0, mostTimes));
                    continue;
                }
                entrant.seconds.push_back(own);
                entrant.deviceSeconds.push_back(device);
                entrant.embreeSeconds.push_back(embree);
                entrant.ratios.push_back(embree / own);
            }
        for (Entrant& entrant : entrants) report_.results.push_back(summary(entrant, embreeHits));
    }

    BenchResult summary(Entrant& entrant, uint64_t embreeHits) const {
        BenchResult result = std::move(entrant.result);
        result.megaRays = megaRaysOf(entrant.seconds, result.count);
        if (entrant.deviceSeconds.front() > 0.0) result.deviceMegaRays = megaRaysOf(entrant.deviceSeconds, result.count);
        if (embree_)
            result.toEmbree = {megaRaysOf(entrant.embreeSeconds, result.count), quartilesOf(entrant.ratios), embreeHits};
        return result;
    }

    void makeDrivers() {
        for (const auto& info : settings_.devices) {
            if (!info || !info->features.rayQuery) continue;
            if (!geometry_.spheres.empty() || geometry_.triangles.empty()) {
                report_.withoutDriver.push_back(info->name + ": only scenes of triangles are given to ray queries");
                continue;
            }
            try {
                drivers_.push_back(std::make_unique<DriverPeer>(*info, geometry_));
            } catch (const Error& error) {  // what a peer cannot do does not keep raig from it
                report_.withoutDriver.push_back(error.what());
            }
        }
    }

    void addDrivers(const Batch& batch, std::vector<Entrant>& entrants) const {
        for (const auto& driver : drivers_) {
            BenchResult result = resultOf(driverName, "ray query", nullptr, batch);
            result.device = driver->device();
            entrants.push_back({std::move(result), timed(driver->place(batch.rays, batch.query))});
        }
    }

    std::vector<Entrant> waysOfEmbree(const Batch& batch) {
        using Width = EmbreePeer::Width;
        std::vector<Entrant> entrants;
        if (!measuresPeers_) return entrants;
        for (const Width width : {Width::single, batch.coherent ? Width::coherentPacket8 : Width::packet8})
            for (const bool robust : {false, true}) {
                const std::string way = width == Width::single ? "single" : "packet8";
                entrants.push_back({resultOf(embreeName, way + (robust ? " robust" : ""), nullptr, batch),
                                    [this, &batch, width, robust](uint64_t& hits) {
                                        const auto traced = embree_->trace(batch.rays, batch.query, width, robust);
                                        hits = traced.hits;
                                        TraceReport report;
                                        report.seconds = traced.seconds;
                                        return report;
                                    }});
            }
        return entrants;
    }

    void addWalks(Walked& walked, const Batch& batch, std::vector<Entrant>& entrants) const {
        std::vector<Hit> ignored(batch.rays.size());
        const WalkCounters counters = walked.cpu->trace(batch.rays, ignored, batch.query).counters;  // the same everywhere
        for (size_t i = 0; i < devices_.size(); ++i) {
            Device* const device = devices_[i].get();
            auto rays = device ? std::make_unique<ResidentRays>(*walked.onDevices[i], *device, batch.rays, batch.query)
                               : std::make_unique<ResidentRays>(*walked.cpu, batch.rays, batch.query);
            entrants.push_back(
                {resultOf(walked.structure.name, walked.structure.walk, device, batch), timed(std::move(rays))});
            entrants.back().result.counters = counters;
        }
    }

    static std::function<TraceReport(uint64_t&)> timed(std::shared_ptr<ResidentRays> rays) {
        return [rays](uint64_t& hits) {
            const TraceReport report = rays->trace();
            hits = std::ranges::count_if(rays->hits(), [](const Hit& hit) { return hit.primitive != NO_HIT; });
            return report;
        };
    }

    static BenchResult resultOf(const std::string& structure, const std::string& walk, const Device* device,
                                const Batch& batch) {
        BenchResult result;
        result.structure = structure;
        result.walk = walk;
        result.device = device ? device->info().name : "cpu";
        result.rays = batch.name;
        result.query = batch.query;
        result.count = batch.rays.size();
        return result;
    }

    const Geometry& geometry_;
    const BenchSettings& settings_;
    const std::function<void(const std::string&, double)>& progress_;
    std::vector<Primitive> primitives_;
    std::vector<std::unique_ptr<Device>> devices_;  ///< none: the CPU path
    std::unique_ptr<EmbreePeer> embree_;
    bool measuresPeers_ = false;
    std::vector<std::unique_ptr<DriverPeer>> drivers_;
    RaySets sets_;
    BenchReport report_;
    size_t stepsDone_ = 0;
};

}  // namespace

BenchReport bench(const Geometry& geometry, const BenchSettings& settings,
                  const std::function<void(const std::string&, double)>& progress) {
    return SceneBench(geometry, settings, progress).run();
}

}  // namespace raig
