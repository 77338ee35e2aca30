#include "structures/two_level.hpp"

#include "base/error.hpp"
#include "structures/two_level_plan.hpp"
#include "structures/upper_level.hpp"

#include <algorithm>
#include <chrono>

namespace raig {

namespace {

/// Bytes of the top tree and of the records of instances and bottoms. Throws limitError if they exceed the budget.
uint64_t topBytes(const TwoLevelPlan& plan, const BuildParams& params) {
    if (plan.isOneLevel()) return 0;
    const uint64_t instances = plan.instanceCount();
    const uint64_t bytes = upperPlaces(instances, plan.meshes.size()).end * sizeof(uvec4);
    if (bytes > params.memoryBudget)
        throw limitError("{} instances need {} MiB and --memory-budget allows {}: raise it", instances, (bytes >> 20) + 1,
                         params.memoryBudget >> 20);
    return bytes;
}

/// All bottoms, in the order of plan.meshes.
std::vector<Structure> buildBottoms(const PlacedScene& scene, const TwoLevelPlan& plan, const StructureType& type,
                                    const BuildParams& params) {
    std::vector<Structure> all;
    BuildParams left = params;
    left.memoryBudget -= topBytes(plan, params);
    for (const uint32_t mesh : plan.meshes) {
        std::vector<Primitive> storage;
        all.push_back(type.build(primitivesUnder(scene, plan, mesh, storage), left));
        left.memoryBudget -= std::min(left.memoryBudget, all.back().statistics.bytes);
        if (mesh != Bottom::writtenOut) continue;
        std::vector<uvec4>& references = all.back().triangles;
        for (size_t i = 0; i < references.size(); i += shared::TRIANGLE_STRIDE)
            references[i].w = plan.out.ids[references[i].w];
    }
    return all;
}

bool sameWalk(const std::vector<Structure>& all) {
    return std::all_of(all.begin(), all.end(),
                       [&](const Structure& bottom) { return bottom.header.walk == all.front().header.walk; });
}

std::vector<BottomShape> shapesOf(const std::vector<Structure>& all, uint64_t upperTexels) {
    std::vector<BottomShape> shapes;
    uint64_t nodes = upperTexels, triangles = 0;
    for (const Structure& bottom : all) {
        nodes += bottom.nodes.size();
        triangles += bottom.triangles.size();
        if (nodes > 0xffffffffu || triangles > 0xffffffffu)
            throw limitError("two levels of {} need more than 2^32 elements; use fewer or simpler meshes", bottom.name);
        shapes.push_back({bottom.header, bottom.nodes.size(), bottom.triangles.size()});
    }
    return shapes;
}

void append(const Structure& bottom, double visits, Structure& result) {
    result.nodes.insert(result.nodes.end(), bottom.nodes.begin(), bottom.nodes.end());
    result.triangles.insert(result.triangles.end(), bottom.triangles.begin(), bottom.triangles.end());
    StructureStatistics& sum = result.statistics;
    sum.nodes += bottom.statistics.nodes;
    sum.leaves += bottom.statistics.leaves;
    sum.references += bottom.statistics.references;
    sum.depth = std::max(sum.depth, bottom.statistics.depth);
    sum.sahCost += visits * bottom.statistics.sahCost;
    for (const std::string& remark : bottom.remarks)
        if (std::find(result.remarks.begin(), result.remarks.end(), remark) == result.remarks.end())
            result.remarks.push_back(remark);
}

/// Puts the parts of two levels into the arrays of one structure.
Structure join(const PlacedScene& scene, const TwoLevelPlan& plan, std::vector<Structure> all) {
    const uint64_t upperTexels = upperPlaces(plan.instanceCount(), all.size()).end;
    UpperLevel upper = makeUpperLevel(scene, plan, shapesOf(all, upperTexels));
    Structure result;
    result.name = all.front().name;
    result.walk = fmt::format("instances, {}", all.front().walk);
    result.header = upper.header;
    result.nodes = std::move(upper.nodes);
    result.bottoms = std::move(upper.bottoms);
    result.instances = upper.instances;
    for (size_t i = 0; i < all.size(); ++i) {
        append(all[i], upper.visits[i], result);
        all[i] = {};
    }
    StructureStatistics& statistics = result.statistics;
    statistics.nodes += upper.nodeCount;
    statistics.depth += upper.depth;
    statistics.sahCost += upper.sahCost;
    statistics.bytes = (result.nodes.size() + result.triangles.size()) * sizeof(uvec4);
    return result;
}

}  // namespace

Structure buildTwoLevels(const PlacedScene& scene, const StructureType& type, const BuildParams& params) {
    const auto start = std::chrono::steady_clock::now();
    const TwoLevelPlan plan = planTwoLevels(scene);
    std::vector<Structure> all = buildBottoms(scene, plan, type, params);
    if (all.empty()) return type.build({}, params);
    if (plan.isOneLevel()) return std::move(all.front());
    if (!sameWalk(all)) {
        // One kernel walks them all. What they differ in is the precision that suits each, or if grids are nested: so all
        // get the higher, or are.
        BuildParams same = params;
        if (type.name == "grid")
            same.nestsGrids = true;
        else
            same.precision = 32;
        all.clear();
        all = buildBottoms(scene, plan, type, same);
        if (!sameWalk(all)) throw limitError("not all meshes can have the same walk within --memory-budget: raise it");
    }
    Structure result = join(scene, plan, std::move(all));
    result.statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return result;
}

}  // namespace raig
