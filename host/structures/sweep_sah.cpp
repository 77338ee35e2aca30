#include "structures/sweep_sah.hpp"

#include "base/parallel.hpp"
#include "structures/bvh_builders.hpp"

namespace raig {

namespace {

struct Sweep {
    float cost = std::numeric_limits<float>::infinity();
    int axis = -1;
    uint32_t left = 0;  ///< how many references
};

void sortAlong(int axis, BoxReference* begin, uint32_t count) {
    const auto before = [axis](const BoxReference& p, const BoxReference& q) {
        const float a = p.lo[axis] + p.hi[axis], b = q.lo[axis] + q.hi[axis];
        return a < b || (a == b && p.id < q.id);
    };
    if (count >= parallelSize)
        parallelSort(begin, begin + count, before);
    else
        std::sort(begin, begin + count, before);
}

/// The best place along one axis, along which the range is sorted.
Sweep sweep(const Range& range, int axis, std::span<float> rightAreas) {
    Sweep best;
    LaneBox box;
    for (uint32_t i = range.count - 1; i > 0; --i) {
        box.grow(boxOf(range.begin[i]));
        rightAreas[i] = box.halfArea();
    }
    box = LaneBox{};
    for (uint32_t i = 1; i < range.count; ++i) {
        box.grow(boxOf(range.begin[i - 1]));
        const float cost = box.halfArea() * static_cast<float>(i) + rightAreas[i] * static_cast<float>(range.count - i);
        if (cost < best.cost) best = {cost, axis, i};
    }
    return best;
}

}  // namespace

uint32_t splitBySweep(const Range& range, BinaryNode& node, uint32_t maxLeaf, const SahCosts& costs,
                      std::span<float> rightAreas) {
    if (range.depth >= deepestChoice) return range.count <= maxLeaf ? 0 : halve(range, node);
    Sweep best;
    int sorted = -1;
    for (int axis = 0; axis < 3; ++axis) {
        if (range.bounds.centroids.lo[axis] == range.bounds.centroids.hi[axis]) continue;
        sortAlong(axis, range.begin, range.count);
        sorted = axis;
        const Sweep found = sweep(range, axis, rightAreas);
        if (found.cost < best.cost) best = found;
    }
    const float area = range.bounds.boxes.halfArea();
    const bool leafIsCheaper =
        costs.triangle * static_cast<float>(range.count) * area <= costs.triangle * best.cost + costs.node * 2.0f * area;
    if (range.count <= maxLeaf && (best.axis < 0 || leafIsCheaper)) return 0;
    if (best.axis < 0) return halve(range, node);
    if (sorted != best.axis) sortAlong(best.axis, range.begin, range.count);
    node.axis = static_cast<uint32_t>(best.axis);
    return best.left;
}

BinaryTree buildSweepSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs) {
    const auto split = [&](const Range& range, BinaryNode& node) {
        std::vector<float> rightAreas(range.count);
        return splitBySweep(range, node, maxLeaf, costs, rightAreas);
    };
    BinaryTree tree{{}, std::move(references)};
    TopDown(tree, split).build();
    return tree;
}

}  // namespace raig
