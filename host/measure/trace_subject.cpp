#include "measure/trace_subject.hpp"

#include "base/error.hpp"
#include "measure/embree_peer.hpp"
#include "measure/naive_bvh.hpp"
#include "measure/tasks.hpp"
#include "measure/timing.hpp"

#include <algorithm>
#include <array>
#include <chrono>
#include <cmath>

namespace raig {

namespace {

using Clock = std::chrono::steady_clock;

/// A whole number among those allowed, or 0 where the setting is not there.
uint32_t choiceOf(const Json& settings, const char* name, std::initializer_list<uint32_t> allowed) {
    if (!settings.contains(name)) return 0;
    const double value = numberOf(settings, name, 0.0);
    for (const uint32_t one : allowed)
        if (value == one) return one;
    throw usageError("the setting \"{}\" takes one of {}", name, fmt::join(allowed, ", "));
}

/// The same of all from 1 to `most`.
uint32_t countOf(const Json& settings, const char* name, uint32_t most) {
    if (!settings.contains(name)) return 0;
    const double value = numberOf(settings, name, 0.0);
    if (!(value >= 1.0 && value <= most && value == std::floor(value)))
        throw usageError("the setting \"{}\" takes a whole number from 1 to {}", name, most);
    return static_cast<uint32_t>(value);
}

/// With the same limits as on the command line.
BuildParams paramsOf(const Json& settings) {
    BuildParams params;
    params.build = textOf(settings, "build", params.build);
    params.walk = textOf(settings, "walk", params.walk);
    params.bound = textOf(settings, "bound", params.bound);
    params.arity = choiceOf(settings, "arity", {2, 4, 8});
    params.precision = choiceOf(settings, "precision", {32, 16, 8});
    params.maxLeaf = countOf(settings, "max-leaf", 255);
    params.maxTreeDepth = countOf(settings, "max-tree-depth", 64);
    params.levels = countOf(settings, "levels", 2);
    if (settings.contains("grid-density")) {
        const double density = numberOf(settings, "grid-density", 0.0);
        if (!(density >= 1e-3 && density <= 1e3))
            throw usageError("the setting \"grid-density\" takes a number from 0.001 to 1000");
        params.gridDensity = static_cast<float>(density);
    }
    return params;
}

/// What a structure needs to live: it is built, copied to the device, and walked on both.
struct Built {
    Structure structure;
    std::unique_ptr<Tracer> cpu, device;
};

TraceSubject structureSubject(const Json& settings, const std::vector<Primitive>& primitives, Device* device) {
    auto built = std::make_shared<Built>();
    const Clock::time_point start = Clock::now();
    built->structure = structureType(textOf(settings, "accel", "bvh")).build(primitives, paramsOf(settings));
    const double seconds = secondsSince(start);
    built->cpu = makeCpuTracer(built->structure);
    if (device && textOf(settings, "on", "device") == "device") built->device = makeDeviceTracer(*device, built->structure);
    const StructureStatistics& s = built->structure.statistics;
    const double count = double(std::max<size_t>(primitives.size(), 1));
    TraceSubject subject;
    subject.facts = {{"build_seconds", seconds},
                     {"megabytes", double(s.bytes) / (1 << 20)},
                     {"bytes_per_triangle", double(s.bytes) / count},
                     {"references_per_triangle", double(s.references) / count},
                     {"nodes", s.nodes},
                     {"sah", s.sahCost}};
    subject.isExact = true;
    subject.trace = [built](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
        std::vector<Hit> unwanted(hits.empty() ? rays.size() : 0);
        Tracer& tracer = built->device ? *built->device : *built->cpu;
        return tracer.trace(rays, hits.empty() ? std::span(unwanted) : hits, query).seconds;
    };
    subject.count = [built](std::span<const Ray> rays, Query query) {
        std::vector<Hit> unwanted(rays.size());
        return built->cpu->trace(rays, unwanted, query).counters;
    };
    return subject;
}

TraceSubject textbookSubject(const std::vector<Primitive>& primitives) {
    const Clock::time_point start = Clock::now();
    auto bvh = std::make_shared<hard::naive::Bvh>(primitives);
    TraceSubject subject;
    subject.facts = {{"build_seconds", secondsSince(start)}, {"megabytes", double(bvh->bytes()) / (1 << 20)}};
    subject.trace = [bvh](std::span<const Ray> rays, std::span<Hit> hits, Query) {
        std::vector<Hit> unwanted(hits.empty() ? rays.size() : 0);
        const Clock::time_point begin = Clock::now();
        bvh->trace(rays, hits.empty() ? std::span(unwanted) : hits);
        return secondsSince(begin);
    };
    return subject;
}

TraceSubject embreeSubject(const std::string& name, const Geometry& geometry) {
    std::shared_ptr<EmbreePeer> peer = EmbreePeer::make(geometry);
    const bool robust = name.find("robust") != name.npos;
    if (!peer || (robust && !peer->makeRobust(geometry))) throw limitError("raig was built without Embree");
    const auto width = name.find("packet") != name.npos ? EmbreePeer::Width::coherentPacket8 : EmbreePeer::Width::single;
    TraceSubject subject;
    subject.facts = {{"build_seconds", peer->buildSeconds()}};
    subject.trace = [peer, width, robust](std::span<const Ray> rays, std::span<Hit> hits, Query query) {
        const double seconds = peer->trace(rays, query, width, robust).seconds;
        if (!hits.empty()) peer->copyHits(hits, width);
        return seconds;
    };
    return subject;
}

bool isEmbree(const std::string& accel) {
    return accel.starts_with("embree");
}

}  // namespace

void checkTraceSubject(const Json& settings) {
    constexpr std::array known = {"embree", "embree-robust", "embree-packet8", "embree-packet8-robust"};
    const std::string accel = textOf(settings, "accel", "bvh");
    if (isEmbree(accel) && std::find(known.begin(), known.end(), accel) == known.end())
        throw usageError("there is no peer \"{}\"; there are {}", accel, fmt::join(known, ", "));
    if (!isEmbree(accel) && accel != "textbook")
        structureType(accel).build({}, paramsOf(settings));  // refuses other options
}

TraceSubject makeTraceSubject(const Json& settings, const Geometry& geometry, const std::vector<Primitive>& primitives,
                              Device* device) {
    const std::string accel = textOf(settings, "accel", "bvh");
    if (accel == "textbook") return textbookSubject(primitives);
    return isEmbree(accel) ? embreeSubject(accel, geometry) : structureSubject(settings, primitives, device);
}

}  // namespace raig
