#include "structures/bins.hpp"
#include "structures/bvh_builders.hpp"
#include "structures/sweep_sah.hpp"

#include <optional>

namespace raig {

namespace {

// Up to so many references, trying every place is as fast as filling bins.
constexpr uint32_t mostForSweep = 16;

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

/// A closer look at the best split, where most of its cost is that of the bins beside it: these two are cut into finer ones
/// along the axis, time and again. Few large triangles in a bin with many small ones, as the ground under a room, are parted
/// from them so, where coarse bins would take one more node as large as the ground for each look.
class FineSplit {
public:
    FineSplit(const Binning& binning, const Split& split)
        : axis_(split.axis),
          origin_(binning.origin[axis_]),
          scale_(binning.scale[axis_]),
          start_(static_cast<float>(split.bin - 1)) {}

    bool isLeft(const BoxReference& reference) const { return binOf(reference) < bin_; }

    /// Moves the split to where it is cheaper, if it is much; `cost` becomes what it costs.
    void refine(const Bins& bins, const Binning& binning, const Range& range, const SahCosts& costs, Split& split) {
        const Bins::Axis& coarse = bins.axes[axis_];
        Bins::Bin before, behind;
        for (int i = 0; i < split.bin - 1; ++i) add(before, coarse[i]);
        for (int i = split.bin + 1; i < binning.count; ++i) add(behind, coarse[i]);
        const FineSplit first = *this;
        float cost = split.cost;
        for (int look = 0; look < mostLooks && costs.triangle * (costOf(before) + costOf(behind)) < promising * cost;
             ++look) {
            const Bins::Axis fine = fill(range);
            const Split best = bestSplit(fine, before, behind, costs);
            cost = best.cost;
            // The boundary becomes the middle of the next, narrower window.
            for (int i = 0; i < best.bin - 1; ++i) add(before, fine[i]);
            for (int i = best.bin + 1; i < mostBins; ++i) add(behind, fine[i]);
            start_ += static_cast<float>(best.bin - 1) * width_ / mostBins;
            width_ *= 2.0f / mostBins;
        }
        if (cost < clearlyCheaper * split.cost)
            split.cost = cost;
        else
            *this = first;
    }

private:
    static constexpr int mostLooks = 4;
    static constexpr float promising = 0.5f;       // of the cost, what the other bins take at most
    static constexpr float clearlyCheaper = 0.8f;  // of the cost, what a closer look must come down to
    static constexpr int bin_ = mostBins / 2;      ///< the first on the right

    static void add(Bins::Bin& to, const Bins::Bin& bin) {
        to.box.grow(bin.box);
        to.count += bin.count;
    }
    static float costOf(const Bins::Bin& side) {
        return side.count == 0 ? 0.0f : side.box.halfArea() * static_cast<float>(side.count);
    }

    /// -1 before the window, mostBins behind it. Windows begin at multiples of 2^-15, so the difference is exact: a
    /// reference is in the same window of any width.
    int binOf(const BoxReference& reference) const {
        const float place = (centroid2(boxOf(reference))[axis_] - origin_) * scale_ - start_;
        return place < 0.0f ? -1 : place >= width_ ? mostBins : static_cast<int>(place * (mostBins / width_));
    }

    static Split bestSplit(const Bins::Axis& fine, const Bins::Bin& before, const Bins::Bin& behind, const SahCosts& costs) {
        std::array<float, mostBins> rightCost;
        Bins::Bin side = behind;
        for (int i = mostBins - 1; i > 0; --i) {
            add(side, fine[i]);
            rightCost[i] = side.count == 0 ? -1.0f : costOf(side);
        }
        Split best;
        side = before;
        for (int i = 1; i < mostBins; ++i) {
            add(side, fine[i - 1]);
            const float cost = costs.triangle * (costOf(side) + rightCost[i]);
            if (side.count > 0 && rightCost[i] >= 0.0f && cost < best.cost) best = {cost, 0, i};
        }
        return best;
    }

    Bins::Axis fill(const Range& range) const {
        const auto over = [&](size_t begin, size_t end, Bins::Axis fine) {
            for (size_t i = begin; i < end; ++i) {
                const int bin = binOf(range.begin[i]);
                if (bin < 0 || bin == mostBins) continue;
                fine[bin].box.grow(boxOf(range.begin[i]));
                ++fine[bin].count;
            }
            return fine;
        };
        if (range.count < 8 * parallelSize) return over(0, range.count, {});
        return parallelReduce(range.count, parallelSize, Bins::Axis{}, over, [](Bins::Axis a, const Bins::Axis& b) {
            for (int i = 0; i < mostBins; ++i) add(a[i], b[i]);
            return a;
        });
    }

    int axis_;
    float origin_, scale_;
    float start_;  ///< of the window, in coarse bins
    float width_ = 2.0f;
};

}  // namespace

BinaryTree buildBinnedSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs) {
    const auto split = [&](const Range& range, BinaryNode& node) -> uint32_t {
        if (range.count <= mostForSweep) {
            std::array<float, mostForSweep> rightAreas;
            return splitBySweep(range, node, maxLeaf, costs, rightAreas);
        }
        const Binning binning(range.bounds.centroids, range.count);
        Split best;
        std::optional<FineSplit> fine;
        if (range.depth < deepestChoice) {
            Bins bins;
            fill(bins, binning, range);
            best = bestSplit(bins, binning, costs);
            if (best.found()) fine.emplace(binning, best).refine(bins, binning, range, costs, best);
        }
        const float area = range.bounds.boxes.halfArea();
        const bool leafIsCheaper =
            costs.triangle * static_cast<float>(range.count) * area <= best.cost + costs.node * 2.0f * area;
        if (range.count <= maxLeaf && (best.axis < 0 || leafIsCheaper)) return 0;
        if (best.axis < 0) return halve(range, node);
        node.axis = static_cast<uint32_t>(best.axis);
        const BoxReference* middle =
            std::partition(range.begin, range.begin + range.count, [&](const BoxReference& r) { return fine->isLeft(r); });
        return static_cast<uint32_t>(middle - range.begin);
    };
    BinaryTree tree{{}, std::move(references)};
    TopDown(tree, split).build();
    return tree;
}

}  // namespace raig
