/// What builders that split ranges of references from the root down have in common.
#pragma once

#include "base/parallel.hpp"
#include "structures/lanes.hpp"

#include <algorithm>
#include <utility>

namespace raig {

/// A range of references to be split, and where it is in the tree.
struct Range {
    BoxReference* begin;
    uint32_t count;
    uint32_t depth;
    const RangeBounds& bounds;
};

inline constexpr size_t parallelSize = 8192;  ///< ranges smaller than this are one task

/// Splits in the middle of the order along the widest axis, ties by id. Returns how many go left: half, rounded down.
inline uint32_t halve(const Range& range, BinaryNode& node) {
    const int axis = widestAxis(range.bounds);
    node.axis = static_cast<uint32_t>(axis);
    const auto before = [axis](const BoxReference& p, const BoxReference& q) {
        const float a = p.lo[axis] + p.hi[axis], b = q.lo[axis] + q.hi[axis];
        return a < b || (a == b && p.id < q.id);
    };
    std::nth_element(range.begin, range.begin + range.count / 2, range.begin + range.count, before);
    return range.count / 2;
}

/// Builds a tree by `split(range, node)`, which orders the range, sets the node's axis, and returns how many references go
/// left: 0 makes a leaf. It is called from several threads, for ranges that do not overlap.
template <class Split>
class TopDown {
public:
    TopDown(BinaryTree& tree, const Split& split) : tree_(tree), split_(split) {
        if (!tree.references.empty()) tree.nodes.resize(2 * tree.references.size() - 1);
    }

    void build() {
        if (!tree_.references.empty()) build(0, 0, static_cast<uint32_t>(tree_.references.size()), 0);
    }

private:
    /// Fills in the node and all below it, over references [first, first + count). The left child's nodes follow the node,
    /// the right child's the largest number that the left can need: so no two tasks ever share an index.
    void build(uint32_t node, uint32_t first, uint32_t count, uint32_t depth) {
        const RangeBounds bounds = boundsOf(first, count);
        BinaryNode& result = tree_.nodes[node];
        result.box = bounds.boxes.box();
        const uint32_t leftCount =
            count == 1 ? 0 : split_(Range{tree_.references.data() + first, count, depth, bounds}, result);
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
            parallelInvoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
    }

    RangeBounds boundsOf(uint32_t first, uint32_t count) const {
        const auto over = [this](size_t begin, size_t end, RangeBounds bounds) {
            for (size_t i = begin; i < end; ++i) bounds.grow(tree_.references[i]);
            return bounds;
        };
        if (count < 8 * parallelSize) return over(first, first + count, {});
        return parallelReduce(
            count, parallelSize, RangeBounds{},
            [&](size_t begin, size_t end, const RangeBounds& bounds) { return over(first + begin, first + end, bounds); },
            [](RangeBounds a, const RangeBounds& b) {
                a.grow(b);
                return a;
            });
    }

    BinaryTree& tree_;
    const Split& split_;
};

}  // namespace raig
