#include "structures/bins.hpp"
#include "structures/bvh_builders.hpp"
#include "structures/top_down.hpp"

namespace raig {

namespace {

void fill(Bins& bins, const Binning& binning, const Range& range) {
    if (range.count < 8 * parallelSize) {
        for (uint32_t i = 0; i < range.count; ++i) bins.add(range.begin[i], binning);
        return;
    }
    // Minima, maxima and counts do not depend on how the range is cut.
    bins = parallelReduce(
        range.count, parallelSize, Bins{},
        [&](size_t begin, size_t end, Bins some) {
            for (size_t i = begin; i < end; ++i) some.add(range.begin[i], binning);
            return some;
        },
        [](Bins a, const Bins& b) {
            a.add(b);
            return a;
        });
}

}  // namespace

BinaryTree buildBinnedSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs) {
    const auto split = [&](const Range& range, BinaryNode& node) -> uint32_t {
        const Binning binning(range.bounds.centroids, range.count);
        Split best;
        if (range.depth < deepestChoice) {
            Bins bins;
            fill(bins, binning, range);
            best = bestSplit(bins, binning, costs);
        }
        const float area = range.bounds.boxes.halfArea();
        const bool leafIsCheaper =
            costs.triangle * static_cast<float>(range.count) * area <= best.cost + costs.node * 2.0f * area;
        if (range.count <= maxLeaf && (best.axis < 0 || leafIsCheaper)) return 0;
        if (best.axis < 0) return halve(range, node);
        node.axis = static_cast<uint32_t>(best.axis);
        const BoxReference* middle = std::partition(range.begin, range.begin + range.count, [&](const BoxReference& r) {
            return binning.bins(boxOf(r))[best.axis] < best.bin;
        });
        return static_cast<uint32_t>(middle - range.begin);
    };
    BinaryTree tree{{}, std::move(references)};
    TopDown(tree, split).build();
    return tree;
}

}  // namespace raig
