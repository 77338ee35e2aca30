#include "app/bench_document.hpp"

#include "app/counters_json.hpp"
#include "app/machine.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

Json toJson(const std::optional<Quartiles>& q) {
    if (!q) return nullptr;
    return {{"median", q->median}, {"q1", q->q1}, {"q3", q->q3}};
}

const char* nameOf(Query query) {
    return query == Query::any ? "any" : "closest";
}

double perTriangle(uint64_t bytes, const SceneBenches& benches) {
    return static_cast<double>(bytes) / static_cast<double>(std::max<uint64_t>(benches.triangles, 1));
}

std::string ratioText(const std::optional<Quartiles>& q) {
    return q ? fmt::format("{:.3f} ({:.3f}-{:.3f})", q->median, q->q1, q->q3) : "-";
}

/// The part of a name that fits, which for devices is the one that tells them apart.
std::string shortened(const std::string& name, size_t length) {
    return name.substr(0, std::min(name.find(' '), length));
}

void printBuilds(const SceneBenches& benches) {
    fmt::print("{:10} {:24} {:>10} {:>25} {:>12} {:>9}\n", "structure", "walk", "build s", "of Embree's", "bytes/tri",
               "SAH cost");
    for (const BenchBuild& b : benches.report.builds)
        fmt::print("{:10} {:24} {:>10.4f} {:>25} {:>12.1f} {:>9.2f}\n", b.structure, b.walk, b.seconds.median,
                   ratioText(b.toEmbree), perTriangle(b.statistics.bytes, benches), b.statistics.sahCost);
}

void printResult(const BenchResult& r) {
    std::string counted;
    if (r.counters) {
        const auto perRay = [&](uint64_t all) { return static_cast<double>(all) / static_cast<double>(r.count); };
        counted =
            fmt::format(" {:>7.1f} {:>7.1f} {:>6.2f} {:>6.2f}", perRay(r.counters->nodeFetches),
                        perRay(r.counters->boxTests), perRay(r.counters->triangleTests), perRay(r.counters->linkReads));
    }
    fmt::print("  {:8} {:22.22} {:11} {:>8.2f} {:>8} {:>20} {:>8}{}\n", r.structure, r.walk, shortened(r.device, 11),
               r.megaRays.median, r.deviceMegaRays ? fmt::format("{:.2f}", r.deviceMegaRays->median) : "-",
               ratioText(r.toEmbree ? std::optional(r.toEmbree->ratio) : std::nullopt), r.hits, counted);
}

}  // namespace

void addJson(Json& document, const SceneBenches& benches) {
    for (const BenchResult& r : benches.report.results) {
        const auto& embree = r.toEmbree;
        document["results"].push_back({{"scene", benches.scene},
                                       {"triangles", benches.triangles},
                                       {"structure", r.structure},
                                       {"options", isPeer(r.structure) ? r.walk : benches.options},
                                       {"walk", r.walk},
                                       {"device", r.device},
                                       {"threads", threadCount()},
                                       {"rays", r.rays},
                                       {"query", nameOf(r.query)},
                                       {"count", r.count},
                                       {"hits", r.hits},
                                       {"hits_embree", embree ? Json(embree->hits) : Json(nullptr)},
                                       {"mrays_per_s", toJson(r.megaRays)},
                                       {"device_mrays_per_s", toJson(r.deviceMegaRays)},
                                       {"mrays_per_s_embree", embree ? toJson(embree->megaRays) : Json(nullptr)},
                                       {"ratio_to_embree", embree ? toJson(embree->ratio) : Json(nullptr)},
                                       {"counters", r.counters ? toJson(*r.counters) : Json(nullptr)}});
    }
    for (const BenchBuild& b : benches.report.builds)
        document["builds"].push_back({{"scene", benches.scene},
                                      {"structure", b.structure},
                                      {"options", benches.options},
                                      {"threads", threadCount()},
                                      {"seconds", b.seconds.median},
                                      {"ratio_to_embree", toJson(b.toEmbree)},
                                      {"bytes", b.statistics.bytes},
                                      {"bytes_per_triangle", perTriangle(b.statistics.bytes, benches)},
                                      {"sah", b.statistics.sahCost}});
}

void printTables(const SceneBenches& benches) {
    std::vector<const BenchResult*> rows;
    for (const BenchResult& r : benches.report.results) rows.push_back(&r);
    const auto setOf = [&](const BenchResult* r) {  // its place among the first of each set
        return std::ranges::find_if(
                   rows, [&](const BenchResult* other) { return other->rays == r->rays && other->query == r->query; }) -
               rows.begin();
    };
    std::vector<std::pair<std::ptrdiff_t, const BenchResult*>> bySet;
    for (const BenchResult* r : rows) bySet.emplace_back(setOf(r), r);
    std::ranges::stable_sort(bySet, {}, &std::pair<std::ptrdiff_t, const BenchResult*>::first);

    fmt::print("{}, {} triangles, {} threads\n", benches.scene, benches.triangles, threadCount());
    printBuilds(benches);
    fmt::print("\n{:45} {:>8} {:>8} {:>20} {:>8} {:>7} {:>7} {:>6} {:>6}\n", "", "Mrays/s", "its own", "of Embree's", "",
               "visits", "boxes", "tests", "links");
    fmt::print("{:45} {:>8} {:>8} {:>20} {:>8} {:>29}\n", "rays", "by wall", "clock", "single", "hits", "a ray");
    std::ptrdiff_t last = -1;
    for (const auto& [set, r] : bySet) {
        if (set != last) fmt::print("{}, {}: {} rays\n", r->rays, nameOf(r->query), r->count);
        last = set;
        printResult(*r);
    }
    fmt::print("\n");
}

}  // namespace raig
