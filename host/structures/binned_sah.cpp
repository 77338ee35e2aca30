#include "structures/binned_sah.hpp"

#include "base/parallel.hpp"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <cstring>
#include <limits>

namespace raig {

namespace {

constexpr int mostBins = 16;
constexpr uint32_t maxSahDepth = 64;
constexpr size_t parallelSize = 8192;  // ranges smaller than this are one task

/// Four floats at once; of a point's, the fourth means nothing.
using Lanes = float __attribute__((vector_size(16)));
using WholeLanes = int __attribute__((vector_size(16)));

Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
Lanes greatest(Lanes a, Lanes b) { return a > b ? a : b; }
Lanes every(float value) { return Lanes{value, value, value, value}; }

struct LaneBox {
    Lanes lo = every(std::numeric_limits<float>::infinity());
    Lanes hi = every(-std::numeric_limits<float>::infinity());

    void grow(const LaneBox& box) {
        lo = least(lo, box.lo);
        hi = greatest(hi, box.hi);
    }
    void grow(Lanes point) {
        lo = least(lo, point);
        hi = greatest(hi, point);
    }
    /// Requires that it is not empty.
    float halfArea() const {
        const Lanes e = hi - lo;
        return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    }
    Box box() const { return {vec3(lo[0], lo[1], lo[2]), vec3(hi[0], hi[1], hi[2])}; }
};

LaneBox boxOf(const BoxReference& reference) {
    // The fourth lanes, an id among them, would be denormal numbers, and slow.
    const WholeLanes point = {-1, -1, -1, 0};
    WholeLanes lo, hi;
    std::memcpy(&lo, &reference.lo, sizeof lo);
    std::memcpy(&hi, &reference.hi, sizeof hi);
    return {reinterpret_cast<Lanes>(lo & point), reinterpret_cast<Lanes>(hi & point)};
}
static_assert(sizeof(BoxReference) == 32 && offsetof(BoxReference, hi) == 16, "two times four lanes");

// Twice the centroid: the halving changes nothing, so it is left out.
Lanes centroid2(const LaneBox& box) { return box.lo + box.hi; }

struct RangeBounds {
    LaneBox boxes;
    LaneBox centroids;

    void grow(const BoxReference& reference) {
        const LaneBox box = boxOf(reference);
        boxes.grow(box);
        centroids.grow(centroid2(box));
    }
    void grow(const RangeBounds& other) {
        boxes.grow(other.boxes);
        centroids.grow(other.centroids);
    }
};

/// Which bin a centroid falls into, on all axes at once. NaN-free: an axis without extent has scale 0.
struct Binning {
    Lanes origin;
    Lanes scale{};
    int count;  ///< of bins: few for few references, as each has a cost

    Binning(const LaneBox& centroids, uint32_t references)
        : origin(centroids.lo), count(static_cast<int>(std::min<uint32_t>(mostBins, 4 + references / 4))) {
        const Lanes extent = centroids.hi - centroids.lo;
        for (int axis = 0; axis < 3; ++axis) {
            const float s = static_cast<float>(count) * 0.9999f / extent[axis];
            scale[axis] = extent[axis] > 0.0f && std::isfinite(s) ? s : 0.0f;
        }
    }
    WholeLanes bins(const LaneBox& box) const {
        const Lanes place = (centroid2(box) - origin) * scale;
        const WholeLanes bin = __builtin_convertvector(place, WholeLanes), last = {count - 1, count - 1, count - 1, 0};
        return bin < last ? bin : last;
    }
};

struct Bins {
    struct Bin {
        LaneBox box;
        uint32_t count = 0;
    };
    using Axis = std::array<Bin, mostBins>;
    std::array<Axis, 3> axes;

    void add(const BoxReference& reference, const Binning& binning) {
        const LaneBox box = boxOf(reference);
        const WholeLanes bins = binning.bins(box);
        for (int axis = 0; axis < 3; ++axis) {
            Bin& bin = axes[axis][bins[axis]];
            bin.box.grow(box);
            ++bin.count;
        }
    }
    void add(const Bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int b = 0; b < mostBins; ++b) {
                axes[axis][b].box.grow(other.axes[axis][b].box);
                axes[axis][b].count += other.axes[axis][b].count;
            }
    }
};

struct Split {
    float cost = std::numeric_limits<float>::infinity();  // of the children, area-weighted, not divided by the parent's
    int axis = -1;
    int bin = 0;  // the first of the right side
};

Split bestSplit(const Bins& bins, const Binning& binning, const SahCosts& costs) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (binning.scale[axis] == 0.0f) continue;
        const Bins::Axis& b = bins.axes[axis];
        std::array<float, mostBins> rightCost;
        LaneBox box;
        uint32_t count = 0;
        for (int i = binning.count - 1; i > 0; --i) {
            box.grow(b[i].box);
            count += b[i].count;
            rightCost[i] = count == 0 ? -1.0f : box.halfArea() * static_cast<float>(count);
        }
        box = LaneBox{};
        count = 0;
        for (int i = 1; i < binning.count; ++i) {
            box.grow(b[i - 1].box);
            count += b[i - 1].count;
            if (count == 0 || rightCost[i] < 0.0f) continue;
            const float cost = costs.triangle * (box.halfArea() * static_cast<float>(count) + rightCost[i]);
            if (cost < best.cost) best = {cost, axis, i};
        }
    }
    return best;
}

class Builder {
public:
    Builder(BinaryTree& tree, uint32_t maxLeaf, const SahCosts& costs) : tree_(tree), maxLeaf_(maxLeaf), costs_(costs) {}

    /// Fills in the node and all below it, over references [first, first + count). The left child's nodes follow the node,
    /// the right child's the largest number that the left can need: so no two tasks ever share an index.
    void build(uint32_t node, uint32_t first, uint32_t count, uint32_t depth) {
        const RangeBounds bounds = boundsOf(first, count);
        BinaryNode& result = tree_.nodes[node];
        result.box = bounds.boxes.box();
        const uint32_t leftCount = count == 1 ? 0 : split(result, bounds, first, count, depth);
        if (leftCount == 0) {
            result.first = first;
            result.count = count;
            return;
        }
        result.left = node + 1;
        result.right = node + 2 * leftCount;
        const auto buildLeft = [&, left = result.left] { build(left, first, leftCount, depth + 1); };
        const auto buildRight = [&, right = result.right] { build(right, first + leftCount, count - leftCount, depth + 1); };
        if (count >= parallelSize) {
            tbb::parallel_invoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
    }

private:
    /// Orders the range by the best split and returns how many go left; 0 for a leaf.
    uint32_t split(BinaryNode& node, const RangeBounds& bounds, uint32_t first, uint32_t count, uint32_t depth) {
        const Binning binning(bounds.centroids, count);
        Split best;
        if (depth < maxSahDepth) {
            Bins bins;
            fill(bins, binning, first, count);
            best = bestSplit(bins, binning, costs_);
        }
        const float area = bounds.boxes.halfArea();
        const bool leafIsCheaper =
            costs_.triangle * static_cast<float>(count) * area <= best.cost + costs_.node * 2.0f * area;
        if (count <= maxLeaf_ && (best.axis < 0 || leafIsCheaper)) return 0;

        BoxReference* begin = tree_.references.data() + first;
        if (best.axis >= 0) {
            node.axis = static_cast<uint32_t>(best.axis);
            BoxReference* middle = std::partition(begin, begin + count, [&](const BoxReference& r) {
                return binning.bins(boxOf(r))[best.axis] < best.bin;
            });
            return static_cast<uint32_t>(middle - begin);
        }
        return halve(node, bounds, begin, count);
    }

    /// Splits in the middle of the order along the widest axis: where the heuristic finds nothing, or the tree gets deep.
    static uint32_t halve(BinaryNode& node, const RangeBounds& bounds, BoxReference* begin, uint32_t count) {
        const Lanes extent = bounds.centroids.hi - bounds.centroids.lo;
        const int axis = extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : extent[1] >= extent[2] ? 1 : 2;
        node.axis = static_cast<uint32_t>(axis);
        std::nth_element(begin, begin + count / 2, begin + count, [axis](const BoxReference& p, const BoxReference& q) {
            const float a = p.lo[axis] + p.hi[axis], b = q.lo[axis] + q.hi[axis];
            return a < b || (a == b && p.id < q.id);
        });
        return count / 2;
    }

    RangeBounds boundsOf(uint32_t first, uint32_t count) const {
        const auto over = [this](size_t begin, size_t end, RangeBounds bounds) {
            for (size_t i = begin; i < end; ++i) bounds.grow(tree_.references[i]);
            return bounds;
        };
        if (count < 8 * parallelSize) return over(first, first + count, {});
        return tbb::parallel_reduce(
            tbb::blocked_range<size_t>(first, first + count, parallelSize), RangeBounds{},
            [&](const auto& range, RangeBounds bounds) { return over(range.begin(), range.end(), bounds); },
            [](RangeBounds a, const RangeBounds& b) {
                a.grow(b);
                return a;
            });
    }

    void fill(Bins& bins, const Binning& binning, uint32_t first, uint32_t count) const {
        if (count < 8 * parallelSize) {
            for (uint32_t i = first; i < first + count; ++i) bins.add(tree_.references[i], binning);
            return;
        }
        // Minima, maxima and counts do not depend on how the range is cut.
        bins = tbb::parallel_reduce(
            tbb::blocked_range<size_t>(first, first + count, parallelSize), Bins{},
            [&](const auto& range, Bins some) {
                for (size_t i = range.begin(); i < range.end(); ++i) some.add(tree_.references[i], binning);
                return some;
            },
            [](Bins a, const Bins& b) {
                a.add(b);
                return a;
            });
    }

    BinaryTree& tree_;
    uint32_t maxLeaf_;
    SahCosts costs_;
};

}  // namespace

BinaryTree buildBinnedSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs) {
    BinaryTree tree;
    tree.references = std::move(references);
    if (tree.references.empty()) return tree;
    tree.nodes.resize(2 * tree.references.size() - 1);
    Builder(tree, maxLeaf, costs).build(0, 0, static_cast<uint32_t>(tree.references.size()), 0);
    return tree;
}

}  // namespace raig
