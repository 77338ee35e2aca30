#include "rays/item_draws.hpp"

#include "base/parallel.hpp"

#include <algorithm>
#include <bit>
#include <map>

namespace raig {

using namespace shared;

namespace {

constexpr uint32_t groupSize = 1024;

vec3 floatsOf(const uvec4& t) {
    return {std::bit_cast<float>(t.x), std::bit_cast<float>(t.y), std::bit_cast<float>(t.z)};
}
vec4 rowOf(const uvec4& t) { return {floatsOf(t), std::bit_cast<float>(t.w)}; }

/// The box as the placement puts it.
Box placed(const Placement& placement, const Box& box) {
    Box result;
    for (uint32_t i = 0; i < 8; ++i)
        result.grow(placePoint(placement, {(i & 1) ? box.hi.x : box.lo.x, (i & 2) ? box.hi.y : box.lo.y,
                                           (i & 4) ? box.hi.z : box.lo.z}));
    return result;
}

}  // namespace

DrawnGroups::DrawnGroups(const Structure& structure) {
    if (structure.isInstanced())
        addInstances(structure);
    else
        addGroups(structure);
}

void DrawnGroups::addGroups(const Structure& structure) {
    const uint32_t references = structure.header.triangleCount;
    groups_.resize((references + groupSize - 1) / groupSize);
    parallelFor(groups_.size(), 16, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            Group& group = groups_[i];
            group.first = static_cast<uint32_t>(i) * groupSize;
            group.count = std::min(groupSize, references - group.first);
            for (uint32_t k = 0; k < group.count; ++k)
                group.box.grow(referencedPrimitive(structure, group.first + k).box());
        }
    });
}

void DrawnGroups::addInstances(const Structure& structure) {
    instancesAt_ = static_cast<uint32_t>(structure.header.gridStep.y) * INSTANCES_UNIT;
    std::map<uint32_t, uint32_t> bottomAt;  // where its record lies -> its place in bottoms_
    for (uint32_t i = 0; i < structure.instances; ++i) {
        const uvec4* record = &structure.nodes[instancesAt_ + size_t{i} * INSTANCE_STRIDE];
        const uint32_t at = record[7].x;
        const auto [known, isNew] = bottomAt.try_emplace(at, static_cast<uint32_t>(bottoms_.size()));
        if (isNew) bottoms_.push_back({structure.nodes[at + 4].y, structure.nodes[at + 1].w});
        const Box inner{floatsOf(structure.nodes[at]), floatsOf(structure.nodes[at + 1])};
        const Placement placement{rowOf(record[0]), rowOf(record[1]), rowOf(record[2])};
        placed_.push_back({placed(placement, inner), known->second});
    }
}

ItemDraws DrawnGroups::seenBy(const ItemProjection& projection, uint64_t mostTriangles) const {
    ItemDraws result;
    for (const Group& group : groups_) {
        if (!projection.mayShow(group.box)) continue;
        if (!result.draws.empty() && result.draws.back().words[0] + result.draws.back().triangles == group.first)
            result.draws.back().triangles += group.count;
        else
            result.draws.push_back({.triangles = group.count, .instances = 1, .words = {group.first, 0, 0, 0}});
    }

    std::vector<uint32_t> seen;
    uint64_t triangles = 0;
    for (uint32_t i = 0; i < placed_.size(); ++i)
        if (projection.itemsAcross(placed_[i].box) >= 1.0 && projection.mayShow(placed_[i].box)) {
            seen.push_back(i);
            triangles += bottoms_[placed_[i].bottom].count;
        }
    if (triangles > mostTriangles) {
        std::vector<double> depth(placed_.size());
        for (const uint32_t i : seen) depth[i] = projection.depthOf(placed_[i].box);
        std::stable_sort(seen.begin(), seen.end(), [&](uint32_t a, uint32_t b) { return depth[a] < depth[b]; });
        triangles = 0;
        size_t kept = 0;
        while (kept < seen.size() && triangles <= mostTriangles) triangles += bottoms_[placed_[seen[kept++]].bottom].count;
        seen.resize(kept);
    }
    std::stable_sort(seen.begin(), seen.end(),
                     [&](uint32_t a, uint32_t b) { return placed_[a].bottom < placed_[b].bottom; });
    for (uint32_t i = 0; i < seen.size(); ++i) {
        const uint32_t bottom = placed_[seen[i]].bottom;
        if (i > 0 && bottom == placed_[seen[i - 1]].bottom)
            ++result.draws.back().instances;
        else
            result.draws.push_back({.triangles = bottoms_[bottom].count,
                                    .instances = 1,
                                    .words = {0, bottoms_[bottom].referencesAt, i, 0}});
    }
    result.instances = std::move(seen);
    return result;
}

std::vector<Draw> piecesOf(std::span<const Draw> draws, uint32_t mostTriangles) {
    std::vector<Draw> pieces;
    for (const Draw& draw : draws) {
        const uint32_t together = std::max(1u, mostTriangles / std::max(1u, draw.triangles));  // instances
        for (uint32_t instance = 0; instance < draw.instances; instance += together)
            for (uint32_t first = 0; first < draw.triangles; first += mostTriangles) {
                Draw piece = draw;
                piece.triangles = std::min(mostTriangles, draw.triangles - first);
                piece.instances = std::min(together, draw.instances - instance);
                piece.words[0] += first;
                piece.words[2] += instance;
                pieces.push_back(piece);
            }
    }
    return pieces;
}

}  // namespace raig
