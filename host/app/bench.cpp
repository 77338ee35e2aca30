// `raig bench`: speed over the standard sets of rays, side by side with Embree.
#include "measure/bench.hpp"

#include "app/commands.hpp"
#include "app/counters_json.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "device/arithmetic.hpp"
#include "scene/import.hpp"

#include <fmt/format.h>
#include <nlohmann/json.hpp>

#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

Json toJson(const std::optional<Quartiles>& q) {
    if (!q) return nullptr;
    return {{"median", q->median}, {"q1", q->q1}, {"q3", q->q3}};
}

std::string ratioText(const std::optional<Quartiles>& q) {
    return q ? fmt::format("{:.3f} ({:.3f}-{:.3f})", q->median, q->q1, q->q3) : "-";
}

void printReport(const std::string& scene, size_t triangles, const BenchReport& report) {
    fmt::print("{}, {} triangles\n", scene, triangles);
    fmt::print("{:10} {:24} {:>10} {:>22} {:>12} {:>9}\n", "structure", "walk", "build s", "of Embree's", "bytes/tri",
               "SAH");
    for (const BenchBuild& b : report.builds)
        fmt::print("{:10} {:24} {:>10.4f} {:>22} {:>12.1f} {:>9.2f}\n", b.structure, b.walk, b.seconds.median,
                   ratioText(b.toEmbree), double(b.statistics.bytes) / double(std::max<size_t>(triangles, 1)),
                   b.statistics.sahCost);
    fmt::print("\n{:10} {:9} {:>9} {:>9} {:>9} {:>22} {:>8} {:>8} {:>8} {:>8}\n", "structure", "rays", "Mrays/s", "Embree",
               "hits", "of Embree's", "visits", "boxes", "tests", "links");
    for (const BenchResult& r : report.results) {
        const auto perRay = [&](uint64_t all) { return static_cast<double>(all) / static_cast<double>(r.count); };
        fmt::print("{:10} {:9} {:>9.2f} {:>9} {:>9} {:>22} {:>8.1f} {:>8.1f} {:>8.2f} {:>8.2f}\n", r.structure, r.rays,
                   r.megaRays.median, r.embree ? fmt::format("{:.2f}", r.embree->median) : "-", r.hits,
                   ratioText(r.toEmbree), perRay(r.counters.nodeFetches), perRay(r.counters.boxTests),
                   perRay(r.counters.triangleTests), perRay(r.counters.linkReads));
    }
    fmt::print("\n");
}

void addJson(Json& json, const std::string& scene, size_t triangles, const std::string& device, const Options& options,
             const BenchReport& report) {
    const std::string given = describeOptions(options.buildParams);
    for (const BenchResult& r : report.results)
        json["results"].push_back({{"scene", scene},
                                   {"triangles", triangles},
                                   {"structure", r.structure},
                                   {"options", given},
                                   {"walk", r.walk},
                                   {"device", device},
                                   {"threads", threadCount()},
                                   {"rays", r.rays},
                                   {"count", r.count},
                                   {"hits", r.hits},
                                   {"hits_embree", r.embree ? Json(r.embreeHits) : Json(nullptr)},
                                   {"query", r.rays == "shadow" ? "any" : "closest"},
                                   {"mrays_per_s", toJson(r.megaRays)},
                                   {"mrays_per_s_embree", toJson(r.embree)},
                                   {"ratio_to_embree", toJson(r.toEmbree)},
                                   {"counters", toJson(r.counters)}});
    for (const BenchBuild& b : report.builds)
        json["builds"].push_back({{"scene", scene},
                                  {"structure", b.structure},
                                  {"options", given},
                                  {"threads", threadCount()},
                                  {"seconds", b.seconds.median},
                                  {"ratio_to_embree", toJson(b.toEmbree)},
                                  {"bytes", b.statistics.bytes},
                                  {"bytes_per_triangle",
                                   double(b.statistics.bytes) / double(std::max<size_t>(triangles, 1))},
                                  {"sah", b.statistics.sahCost}});
}

}  // namespace

int bench(const Options& options) {
    const std::optional<DeviceInfo> info = chooseDevice(options.device);
    const std::string deviceName = info ? info->name : "cpu";
    BenchSettings settings{.side = options.side,
                           .repetitions = options.repetitions,
                           .structures = {},
                           .params = options.buildParams,
                           .device = info ? &*info : nullptr};
    for (const StructureType& type : structureTypes())
        if (options.accel == type.name || (options.accel == "all" && type.name != "brute"))
            settings.structures.emplace_back(type.name);
    const MeasuredArithmetic arithmetic = info ? measureArithmetic(*info) : MeasuredArithmetic{measureHostArithmetic(), ""};
    Json json = {{"version", RAIG_VERSION},
                 {"commit", commitId()},
                 {"machine", {{"processor", processorName()}, {"threads", threadCount()}}},
                 {"device", deviceName},
                 {"driver", info ? Json(info->driver) : Json(nullptr)},
                 {"arithmetic", toJson(arithmetic)},
                 {"results", Json::array()},
                 {"builds", Json::array()}};
    for (const std::filesystem::path& file : options.inputs) {
        const Geometry geometry = flatten(importScene(file));
        BenchReport report;
        {
            Progress progress(file.filename().string());
            const auto tell = [&](const std::string& step, double done) { progress.update(step, done); };
            report = raig::bench(geometry, settings, tell);
        }
        for (const BenchResult& r : report.results)
            if (r.embree && r.hits != r.embreeHits)
                log::note("remark: {} of the {} rays hit, {} by Embree, which is not watertight by default", r.hits, r.rays,
                          r.embreeHits);
        if (options.json)
            addJson(json, file.filename().string(), geometry.triangles.size(), deviceName, options, report);
        else
            printReport(file.filename().string() + (geometry.spheres.empty() ? "" : " (spheres among them)"),
                        geometry.triangles.size(), report);
    }
    if (options.json) std::printf("%s\n", json.dump(2).c_str());
    return static_cast<int>(ExitCode::done);
}

}  // namespace raig
