#include "base/parallel.hpp"
#include "structures/structure_fault.hpp"
#include "structures/two_level_plan.hpp"
#include "structures/upper_level.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cstring>

namespace raig {

namespace {

/// Whose ids are whose indices, of what is written out.
class IndicesOf {
public:
    explicit IndicesOf(const std::vector<uint32_t>& ids) : sorted_(ids.size()) {
        for (uint32_t i = 0; i < ids.size(); ++i) sorted_[i] = {ids[i], i};
        parallelSort(sorted_.begin(), sorted_.end());
    }
    /// 2^32 - 1 for what is no id.
    uint32_t operator()(uint32_t id) const {
        const auto at = std::lower_bound(sorted_.begin(), sorted_.end(), std::pair(id, uint32_t{0}));
        return at != sorted_.end() && at->first == id ? at->second : 0xffffffffu;
    }

private:
    std::vector<std::pair<uint32_t, uint32_t>> sorted_;
};

/// Makes the ids of references to what is written out indices, as they were when it was built.
void nameByIndex(const std::vector<uint32_t>& ids, std::vector<uvec4>& references) {
    const IndicesOf indexOf(ids);
    parallelFor((references.size() + shared::TRIANGLE_STRIDE - 1) / shared::TRIANGLE_STRIDE, 16384,
                [&](size_t begin, size_t end) {
                    for (size_t i = begin; i < end; ++i) {
                        uint32_t& id = references[i * shared::TRIANGLE_STRIDE].w;
                        id = indexOf(id);
                    }
                });
}

/// Checks two levels, part by part.
class TwoLevelChecker {
public:
    TwoLevelChecker(const Structure& structure, const PlacedScene& scene, const TwoLevelPlan& plan,
                    const StructureType& type)
        : structure_(structure),
          scene_(scene),
          plan_(plan),
          type_(type),
          places_(upperPlaces(plan.instanceCount(), plan.meshes.size())) {}

    std::optional<std::string> findFault() {
        if (auto fault = findTableFault()) return fault;
        if (auto fault = findBaseFault()) return fault;
        for (size_t i = 0; i < plan_.meshes.size(); ++i)
            if (auto fault = findBottomFault(i)) return fmt::format("bottom {}: {}", i, *fault);
        return findUpperFault();
    }

private:
    /// That the table of bottoms cuts the array of references into pieces, without a gap.
    std::optional<std::string> findTableFault() const {
        if (structure_.instances != plan_.instanceCount())
            return fmt::format("it has {} instances, and should have {}", structure_.instances, plan_.instanceCount());
        if (structure_.bottoms.size() != plan_.meshes.size())
            return fmt::format("it has {} bottoms, and should have {}", structure_.bottoms.size(), plan_.meshes.size());
        const uint64_t all = structure_.triangles.size() / shared::TRIANGLE_STRIDE;
        if (structure_.triangles.size() % shared::TRIANGLE_STRIDE != 0) return "a part of a reference";
        uint64_t next = 0;
        for (size_t i = 0; i < structure_.bottoms.size(); ++i) {
            const Bottom& bottom = structure_.bottoms[i];
            if (bottom.mesh != plan_.meshes[i]) return fmt::format("the table of bottoms: bottom {} is of another mesh", i);
            if (bottom.firstReference != next || bottom.references > all - next)
                return fmt::format("the table of bottoms: the references of bottom {} are out of place", i);
            next += bottom.references;
        }
        if (next != all) return "the table of bottoms: there are references of no bottom";
        return std::nullopt;
    }

    /// That the records of bottoms cut the rest of the nodes so, too.
    std::optional<std::string> findBaseFault() {
        const uint64_t all = structure_.nodes.size();
        if (all < places_.end || all > 0xffffffffu || structure_.triangles.size() > 0xffffffffu)
            return "its arrays are too short for its upper level, or too long";
        for (size_t i = 0; i < plan_.meshes.size(); ++i) nodesAt_.push_back(recordOf(i)[4].x);
        nodesAt_.push_back(all);
        if (nodesAt_.front() != places_.end) return "the record of bottom 0: its nodes are out of place";
        for (size_t i = 0; i < plan_.meshes.size(); ++i)
            if (nodesAt_[i] > nodesAt_[i + 1])
                return fmt::format("the record of bottom {}: its nodes are out of place", i);
        return std::nullopt;
    }

    std::optional<std::string> findBottomFault(size_t index) {
        const Bottom& place = structure_.bottoms[index];
        const auto references = structure_.triangles.begin() + place.firstReference * shared::TRIANGLE_STRIDE;
        Structure bottom;
        bottom.name = structure_.name;
        std::memcpy(&bottom.header, recordOf(index), sizeof bottom.header);
        bottom.nodes.assign(structure_.nodes.begin() + nodesAt_[index], structure_.nodes.begin() + nodesAt_[index + 1]);
        bottom.triangles.assign(references, references + place.references * shared::TRIANGLE_STRIDE);
        if (place.mesh == Bottom::writtenOut) nameByIndex(plan_.out.ids, bottom.triangles);
        shapes_.push_back({bottom.header, bottom.nodes.size(), bottom.triangles.size()});
        if (bottom.header.walk != shapes_.front().header.walk) return "it is laid out for another walk than the first one";
        std::vector<Primitive> storage;
        return findOneLevelFault(bottom, primitivesUnder(scene_, plan_, place.mesh, storage), type_);
    }

    /// Requires sound bottoms.
    std::optional<std::string> findUpperFault() const {
        const UpperLevel upper = makeUpperLevel(scene_, plan_, shapes_);
        const auto differing = std::mismatch(upper.nodes.begin(), upper.nodes.end(), structure_.nodes.begin());
        const auto at = static_cast<uint64_t>(differing.first - upper.nodes.begin());
        if (at < places_.topTreeEnd) return fmt::format("the top tree: node {} is not that of the scene", at / 2);
        if (at < places_.instances) return "there is something between the top tree and the instances";
        if (at < places_.bottoms)
            return fmt::format("the record of instance {} is not that of the scene",
                               (at - places_.instances) / shared::INSTANCE_STRIDE);
        if (at < places_.end)
            return fmt::format("the record of bottom {} is not that of its arrays",
                               (at - places_.bottoms) / shared::BOTTOM_STRIDE);
        if (std::memcmp(&upper.header, &structure_.header, sizeof upper.header) != 0)
            return "its header is not that of the scene";
        return std::nullopt;
    }

    /// Requires nodes up to places_.end.
    const uvec4* recordOf(size_t bottom) const {
        return structure_.nodes.data() + places_.bottoms + bottom * shared::BOTTOM_STRIDE;
    }

    const Structure& structure_;
    const PlacedScene& scene_;
    const TwoLevelPlan& plan_;
    const StructureType& type_;
    UpperPlaces places_;
    std::vector<uint64_t> nodesAt_;  ///< of each bottom, and where the last one's end
    std::vector<BottomShape> shapes_;
};

}  // namespace

std::optional<std::string> findTwoLevelFault(const Structure& structure, const PlacedScene& scene,
                                             const StructureType& type) {
    const TwoLevelPlan plan = planTwoLevels(scene);
    if (!plan.isOneLevel()) return TwoLevelChecker(structure, scene, plan, type).findFault();
    if (!structure.bottoms.empty() || structure.instances != 0) return "it has two levels, and nothing that is kept";
    Structure level = structure;
    nameByIndex(plan.out.ids, level.triangles);
    return findOneLevelFault(level, plan.out.primitives, type);
}

}  // namespace raig
