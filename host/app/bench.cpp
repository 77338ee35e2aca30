// `raig bench`: speed over the standard sets of rays, side by side with Embree.
#include "measure/bench.hpp"

#include "app/bench_baseline.hpp"
#include "app/bench_document.hpp"
#include "app/commands.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "measure/embree_peer.hpp"
#include "scene/import.hpp"

#include <algorithm>
#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;
using Devices = std::vector<std::optional<DeviceInfo>>;

/// Nothing means the CPU path. By default the best device and the CPU path, as each is what some people have.
Devices chooseDevices(const Options& options) {
    Devices devices;
    if (options.device == "all")
        for (const DeviceInfo& info : listDevices()) devices.emplace_back(info);
    else
        devices.push_back(chooseDevice(options.device));
    if ((options.device == "all" || options.device == "auto") && (devices.empty() || devices.back())) devices.emplace_back();
    return devices;
}

std::string nameOf(const std::optional<DeviceInfo>& info) {
    return info ? info->name : "cpu";
}

/// Which peers were measured, or why not. `without`: devices that have ray queries, and why they could not be asked.
Json peersOf(const Json& results, const std::vector<std::string>& without) {
    Json peers;
    const std::optional<std::string> embree = embreeVersion();
    peers["embree"] = {{"measured", embree.has_value()}};
    if (embree)
        peers["embree"]["version"] = *embree;
    else
        peers["embree"]["why"] = "raig was built without Embree";
    const bool hasDriver = std::ranges::any_of(results, [](const Json& row) { return row["structure"] == driverName; });
    peers["driver"] = {{"measured", hasDriver}};
    if (!hasDriver)
        peers["driver"]["why"] = without.empty() ? "no device that was measured has VK_KHR_ray_query" : without.front();
    return peers;
}

Json describeRun(const Devices& devices) {
    Json list = Json::array();
    for (const auto& info : devices) {
        const MeasuredArithmetic measured =
            info ? measureArithmetic(*info) : MeasuredArithmetic{measureHostArithmetic(), ""};
        list.push_back({{"name", nameOf(info)},
                        {"driver", info ? Json(info->driver) : Json(nullptr)},
                        {"arithmetic", toJson(measured)}});
    }
    return {{"version", RAIG_VERSION},
            {"commit", commitId()},
            {"machine", {{"processor", processorName()}, {"threads", threadCount()}}},
            {"device", list[0]["name"]},
            {"driver", list[0]["driver"]},
            {"arithmetic", list[0]["arithmetic"]},
            {"devices", list},
            {"peers", nullptr},  // known when all is measured
            {"results", Json::array()},
            {"builds", Json::array()}};
}

/// What is odd about the numbers of hits: walks find the same everywhere, and nearly what Embree does.
void remark(const BenchReport& report) {
    for (const BenchResult& r : report.results) {
        if (isPeer(r.structure)) continue;
        const auto other = std::ranges::find_if(report.results, [&](const BenchResult& o) {
            return !isPeer(o.structure) && o.rays == r.rays && o.query == r.query;
        });
        if (other->hits != r.hits)
            log::warn("{} of the {} rays hit by {} on {}, and {} by {} on {}: they should be the same", r.hits, r.rays,
                      r.structure, r.device, other->hits, other->structure, other->device);
        else if (&*other == &r && r.toEmbree && r.hits != r.toEmbree->hits)
            log::note("remark: {} of the {} rays hit, {} by Embree, which is not watertight by default", r.hits, r.rays,
                      r.toEmbree->hits);
    }
}

SceneBenches benchScene(const std::filesystem::path& file, const Moment& moment, const BenchSettings& settings) {
    const Geometry geometry = flatten(importScene(file, moment));
    SceneBenches benches{file.filename().string(), geometry.triangles.size(), describeOptions(settings.params), {}};
    {
        Progress progress(benches.scene);
        const auto tell = [&](const std::string& step, double done) { progress.update(step, done); };
        benches.report = raig::bench(geometry, settings, tell);
    }
    remark(benches.report);
    return benches;
}

/// Returns the exit code.
ExitCode compareWith(const BenchBaseline& baseline, const Options& options, Json& document) {
    size_t alone = 0;
    const std::vector<BenchChange> changes = baseline.changes(document, alone);
    const auto slower =
        std::ranges::count_if(changes, [&](const BenchChange& c) { return c.factor() * options.slower < 1.0; });
    document["baseline"] = {
        {"file", options.baseline.string()}, {"commit", baseline.commit()}, {"slower", slower}, {"not_compared", alone},
        {"allowed_factor", options.slower},  {"changes", toJson(changes)}};
    if (!options.json) {
        fmt::print("against {}, of commit {}\n", options.baseline.string(), baseline.commit());
        printChanges(changes, options.slower);
    }
    if (alone > 0) log::note("{} measurements have none like them in the baseline, and were not compared", alone);
    log::note("{} of {} measurements are slower than the baseline's by more than a factor of {}", slower, changes.size(),
              options.slower);
    if (changes.empty()) return ExitCode::badInput;
    return slower > 0 ? ExitCode::fellShort : ExitCode::done;
}

}  // namespace

int bench(const Options& options) {
    std::optional<BenchBaseline> baseline;
    if (!options.baseline.empty()) {
        baseline.emplace(options.baseline);
        std::vector<std::string> scenes;
        for (const std::filesystem::path& file : options.inputs) scenes.push_back(file.filename().string());
        baseline->requireSome(scenes);
    }
    BenchSettings settings{.side = options.side,
                           .repetitions = options.repetitions,
                           .structures = {},
                           .params = options.buildParams,
                           .devices = chooseDevices(options),
                           .bothQueries = options.bothQueries};
    for (const StructureType& type : structureTypes())
        if (options.accel == type.name || (options.accel == "all" && type.name != "brute"))
            settings.structures.emplace_back(type.name);
    Json document = describeRun(settings.devices);
    std::vector<std::string> withoutDriver;
    for (const std::filesystem::path& file : options.inputs) {
        const SceneBenches benches = benchScene(file, options.moment, settings);
        addJson(document, benches);
        for (const std::string& why : benches.report.withoutDriver)
            withoutDriver.push_back(fmt::format("not measured in {}: {}", benches.scene, why));
        if (!options.json) printTables(benches);
    }
    document["peers"] = peersOf(document["results"], withoutDriver);
    if (!options.json)
        for (const auto& [name, peer] : document["peers"].items())
            if (!peer["measured"]) fmt::print("{}: {}\n", name, peer["why"].get<std::string>());
    const ExitCode code = baseline ? compareWith(*baseline, options, document) : ExitCode::done;
    if (options.json) std::printf("%s\n", document.dump(2, ' ', false, Json::error_handler_t::replace).c_str());
    if (code == ExitCode::badInput) throw baseline->nothingInCommon();  // what was measured is told first
    return static_cast<int>(code);
}

}  // namespace raig
