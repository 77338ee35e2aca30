#include "structures/binned_sah.hpp"

#include "base/parallel.hpp"

#include <tbb/parallel_invoke.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <array>
#include <limits>

namespace raig {

namespace {

constexpr int binCount = 16;
constexpr uint32_t maxSahDepth = 64;
constexpr size_t parallelSize = 8192;  // ranges smaller than this are one task

// Twice the centroid: the halving changes nothing, so it is left out.
vec3 centroid2(const BoxReference& reference) {
    return reference.lo + reference.hi;
}

struct RangeBounds {
    Box boxes;
    Box centroids;

    void grow(const BoxReference& r) {
        boxes.lo = glm::min(boxes.lo, r.lo);
        boxes.hi = glm::max(boxes.hi, r.hi);
        centroids.grow(centroid2(r));
    }
    void grow(const RangeBounds& other) {
        boxes.grow(other.boxes);
        centroids.grow(other.centroids);
    }
};

struct Bin {
    Box box;
    uint32_t count = 0;
};

using AxisBins = std::array<Bin, binCount>;

/// Which bin a centroid falls into. NaN-free: an axis without extent has scale 0.
struct Binning {
    vec3 origin;
    vec3 scale;

    explicit Binning(const Box& centroids) : origin(centroids.lo) {
        const vec3 extent = centroids.extent();
        for (int axis = 0; axis < 3; ++axis) {
            const float s = static_cast<float>(binCount) * 0.9999f / extent[axis];
            scale[axis] = extent[axis] > 0.0f && std::isfinite(s) ? s : 0.0f;
        }
    }
    int bin(float centroid, int axis) const {
        const int b = static_cast<int>((centroid - origin[axis]) * scale[axis]);
        return b < binCount - 1 ? b : binCount - 1;
    }
};

struct Bins {
    std::array<AxisBins, 3> axes;

    void add(const BoxReference& r, const Binning& binning) {
        const vec3 c = centroid2(r);
        for (int axis = 0; axis < 3; ++axis) {
            Bin& bin = axes[axis][binning.bin(c[axis], axis)];
            bin.box.lo = glm::min(bin.box.lo, r.lo);
            bin.box.hi = glm::max(bin.box.hi, r.hi);
            ++bin.count;
        }
    }
    void add(const Bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int b = 0; b < binCount; ++b) {
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
        const AxisBins& b = bins.axes[axis];
        std::array<float, binCount> rightCost;
        Box box;
        uint32_t count = 0;
        for (int i = binCount - 1; i > 0; --i) {
            box.grow(b[i].box);
            count += b[i].count;
            rightCost[i] = count == 0 ? -1.0f : box.halfArea() * static_cast<float>(count);
        }
        box = Box{};
        count = 0;
        for (int i = 1; i < binCount; ++i) {
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
        result.box = bounds.boxes;
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
        const Binning binning(bounds.centroids);
        Split best;
        if (depth < maxSahDepth) {
            const Bins bins = binsOf(binning, first, count);
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
                return binning.bin(centroid2(r)[best.axis], best.axis) < best.bin;
            });
            return static_cast<uint32_t>(middle - begin);
        }
        return halve(node, bounds, begin, count);
    }

    /// Splits in the middle of the order along the widest axis: where the heuristic finds nothing, or the tree gets deep.
    static uint32_t halve(BinaryNode& node, const RangeBounds& bounds, BoxReference* begin, uint32_t count) {
        const vec3 extent = bounds.centroids.extent();
        const int axis = extent.x >= extent.y && extent.x >= extent.z ? 0 : extent.y >= extent.z ? 1 : 2;
        node.axis = static_cast<uint32_t>(axis);
        std::nth_element(begin, begin + count / 2, begin + count, [axis](const BoxReference& p, const BoxReference& q) {
            const float a = centroid2(p)[axis], b = centroid2(q)[axis];
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

    Bins binsOf(const Binning& binning, uint32_t first, uint32_t count) const {
        const auto over = [&](size_t begin, size_t end, Bins bins) {
            for (size_t i = begin; i < end; ++i) bins.add(tree_.references[i], binning);
            return bins;
        };
        if (count < 8 * parallelSize) return over(first, first + count, {});
        // Minima, maxima and counts do not depend on how the range is cut.
        return tbb::parallel_reduce(
            tbb::blocked_range<size_t>(first, first + count, parallelSize), Bins{},
            [&](const auto& range, const Bins& bins) { return over(range.begin(), range.end(), bins); },
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
