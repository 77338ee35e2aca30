#include "measure/trials.hpp"

#include "base/error.hpp"
#include "measure/ray_sets.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

constexpr uint32_t side = 48;
constexpr double slack = 1.25;

RaySets raysFrom(const Camera& camera, const Geometry& geometry, Tracer& tracer) {
    const MeasuringCamera measuring{dvec3(camera.eye), dvec3(camera.forward), dvec3(camera.right), dvec3(camera.up),
                                    std::tan(0.5 * camera.yfov)};
    return makeRaySets(geometry, geometry.bounds, measuring, side, tracer);
}

std::vector<Ray> sampleRays(const Scene& scene, const Geometry& geometry, const Structure& structure) {
    if (geometry.bounds.empty()) return {};
    const std::unique_ptr<Tracer> tracer = makeCpuTracer(structure);
    RaySets sets;
    if (!scene.cameras.front().orthographic) sets = raysFrom(scene.cameras.front(), geometry, *tracer);
    // Rays that see next to nothing predict nothing.
    if (sets.diffuse.size() < size_t{side} * side / 8)
        sets = makeRaySets(geometry, geometry.bounds, measuringCamera(geometry, geometry.bounds), side, *tracer);
    std::vector<Ray> rays = std::move(sets.primary);
    rays.insert(rays.end(), sets.diffuse.begin(), sets.diffuse.end());
    return rays;
}

double weightOf(std::string_view structure) {
    return structure == "bvh" || structure == "brute" ? 1.0 : 2.0;
}

PredictedCost predict(const Structure& structure, const std::vector<Ray>& rays) {
    if (rays.empty()) return {};
    std::vector<Hit> hits(rays.size());
    const WalkCounters counters = makeCpuTracer(structure)->trace(rays, hits, Query::closest).counters;
    const double count = static_cast<double>(rays.size());
    return {static_cast<double>(counters.nodeFetches) / count, static_cast<double>(counters.triangleTests) / count,
            weightOf(structure.name)};
}

}  // namespace

std::vector<Trial> tryStructures(const Scene& scene, const Geometry& geometry, std::span<const Primitive> triangles,
                                 const TrialOptions& options) {
    const BuildParams params{.memoryBudget = options.memoryBudget};
    const std::span<const StructureType> types = structureTypes();
    const double share = 1.0 / static_cast<double>(types.size());
    options.progress("bvh", 0.0);
    Structure bvh = structureType("bvh").build(triangles, params);
    const std::vector<Ray> rays = sampleRays(scene, geometry, bvh);
    std::vector<Trial> trials;
    for (const StructureType& type : types) {
        Trial trial{.name = std::string(type.name), .trouble = "", .structure = {}, .cost = {}};
        options.progress(trial.name, share * static_cast<double>(trials.size()));
        try {
            if (type.name == "brute" && triangles.size() > mostForBrute)
                throw limitError("not tried with more than {} triangles", mostForBrute);
            trial.structure = type.name == "bvh" ? std::move(bvh) : type.build(triangles, params);
            trial.cost = predict(trial.structure, rays);
        } catch (const Error& error) {
            if (error.exitCode != ExitCode::limit) throw;
            trial.trouble = error.what();
        }
        if (!options.keepStructures) trial.structure.nodes = trial.structure.triangles = {};
        trials.push_back(std::move(trial));
    }
    return trials;
}

Choice chooseStructure(uint64_t triangles, std::span<const Trial> trials) {
    if (triangles > mostForTrials)
        return {"bvh",
                fmt::format("{} triangles, more than {}: others would take too long to try", triangles, mostForTrials)};
    const Trial *cheapest = nullptr, *bvh = nullptr;
    for (const Trial& trial : trials) {
        if (!trial.trouble.empty()) continue;
        if (cheapest == nullptr || trial.cost.total() < cheapest->cost.total()) cheapest = &trial;
        if (trial.name == "bvh") bvh = &trial;
    }
    RAIG_CHECK(cheapest != nullptr);
    const double least = cheapest->cost.total();
    if (bvh == nullptr || bvh->cost.total() > slack * least) {
        std::string than = bvh ? fmt::format(", that of bvh is {:.1f}", bvh->cost.total()) : "";
        return {cheapest->name, fmt::format("predicted cost of a ray {:.1f}, the least{}", least, than)};
    }
    if (cheapest == bvh) return {"bvh", fmt::format("predicted cost of a ray {:.1f}, the least", least)};
    return {"bvh", fmt::format("predicted cost of a ray {:.1f}, within {} of the least, {:.1f} of {}", bvh->cost.total(),
                               slack, least, cheapest->name)};
}

}  // namespace raig
