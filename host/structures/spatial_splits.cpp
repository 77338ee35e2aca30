#include "base/parallel.hpp"
#include "structures/bins.hpp"
#include "structures/bvh_builders.hpp"
#include "structures/clip.hpp"
#include "structures/top_down.hpp"

namespace raig {

namespace {

constexpr int spatialBins = 32;
constexpr float leastOverlap = 1e-5f;  // of the root's area: what makes looking for a spatial split worthwhile

struct Subtree {
    std::vector<BinaryNode> nodes;
    std::vector<BoxReference> references;
};

struct SpatialSplit {
    float cost = std::numeric_limits<float>::infinity();
    int axis = -1;
    float plane = 0.0f;
    uint64_t references = 0;  ///< of both children
};

BoxReference referenceOf(const Box& box, uint32_t id) { return {box.lo, id, box.hi, 0}; }
Box boxIn(const BoxReference& reference) { return {reference.lo, reference.hi}; }

Box common(const Box& a, const Box& b) { return {glm::max(a.lo, b.lo), glm::min(a.hi, b.hi)}; }

Box joined(Box a, const Box& b) {
    a.grow(b);
    return a;
}

/// Everything in the unit space of structures.
class SpatialBuilder {
public:
    SpatialBuilder(std::span<const Primitive> triangles, float unit, uint32_t maxLeaf, const SahCosts& costs,
                   const Box& root)
        : triangles_(triangles), unit_(unit), maxLeaf_(maxLeaf), costs_(costs), rootArea_(root.halfArea()) {}

    Subtree build(std::vector<BoxReference> references, uint32_t depth, uint64_t budget) const {
        const auto count = static_cast<uint32_t>(references.size());
        RangeBounds bounds;
        for (const BoxReference& reference : references) bounds.grow(reference);
        Subtree result;
        result.nodes.emplace_back().box = bounds.boxes.box();
        BinaryNode& node = result.nodes[0];
        std::vector<BoxReference> left, right;
        if (count == 1 || !split(references, bounds, depth, budget, node, left, right)) {
            node.count = count;
            result.references = std::move(references);
            return result;
        }
        const uint64_t added = left.size() + right.size() - count;
        const uint64_t rest = budget - std::min(budget, added);
        const auto leftBudget = static_cast<uint64_t>(static_cast<double>(rest) * static_cast<double>(left.size()) /
                                                      static_cast<double>(left.size() + right.size()));
        references = {};
        Subtree below[2];
        const auto buildLeft = [&] { below[0] = build(std::move(left), depth + 1, leftBudget); };
        const auto buildRight = [&] { below[1] = build(std::move(right), depth + 1, rest - leftBudget); };
        if (count >= 1024) {
            parallelInvoke(buildLeft, buildRight);
        } else {
            buildLeft();
            buildRight();
        }
        join(result, below);
        return result;
    }

private:
    /// Appends both subtrees below the root that `result` holds.
    static void join(Subtree& result, Subtree (&below)[2]) {
        uint32_t* const links[] = {&result.nodes[0].left, &result.nodes[0].right};
        uint32_t place = 1;
        for (int side = 0; side < 2; ++side) {
            *links[side] = place;
            place += static_cast<uint32_t>(below[side].nodes.size());
        }
        result.references = std::move(below[0].references);
        const auto firstRight = static_cast<uint32_t>(result.references.size());
        result.references.insert(result.references.end(), below[1].references.begin(), below[1].references.end());
        result.nodes.reserve(place);
        for (int side = 0; side < 2; ++side) {
            const auto offset = static_cast<uint32_t>(result.nodes.size());
            for (BinaryNode node : below[side].nodes) {
                if (node.count == 0) {
                    node.left += offset;
                    node.right += offset;
                } else if (side == 1) {
                    node.first += firstRight;
                }
                result.nodes.push_back(node);
            }
        }
    }

    /// Divides the references in two; false if they are to be a leaf.
    bool split(std::vector<BoxReference>& references, const RangeBounds& bounds, uint32_t depth, uint64_t budget,
               BinaryNode& node, std::vector<BoxReference>& left, std::vector<BoxReference>& right) const {
        const auto count = static_cast<uint32_t>(references.size());
        const Binning binning(bounds.centroids, count);
        Split object;
        SpatialSplit spatial;
        if (depth < deepestChoice) {
            Bins bins;
            for (const BoxReference& reference : references) bins.add(reference, binning);
            object = bestSplit(bins, binning, costs_);
            if (budget > 0 && overlaps(bins, binning, object)) spatial = bestSpatialSplit(references, node.box);
            if (spatial.references > count + budget) spatial = {};
        }
        const float cheapest = std::min(object.cost, spatial.cost);
        const float area = bounds.boxes.halfArea();
        const bool leafIsCheaper =
            costs_.triangle * static_cast<float>(count) * area <= cheapest + costs_.node * 2.0f * area;
        const bool found = object.found() || spatial.axis >= 0;
        if (count <= maxLeaf_ && (!found || leafIsCheaper)) return false;
        if (spatial.cost < object.cost && cut(references, spatial, left, right)) {
            node.axis = static_cast<uint32_t>(spatial.axis);
            return true;
        }
        auto middle = references.begin();
        if (object.found()) {
            node.axis = static_cast<uint32_t>(object.axis);
            middle = std::stable_partition(references.begin(), references.end(), [&](const BoxReference& r) {
                return binning.bins(boxOf(r))[object.axis] < object.bin;
            });
        } else {
            middle += halve(Range{references.data(), count, depth, bounds}, node);
        }
        left.assign(references.begin(), middle);
        right.assign(middle, references.end());
        return true;
    }

    /// True if the children of the split, or of halving where none is found, overlap by more than very little.
    bool overlaps(const Bins& bins, const Binning& binning, const Split& split) const {
        if (!split.found()) return true;
        Box sides[2];
        for (int i = 0; i < binning.count; ++i) {
            const Bins::Bin& bin = bins.axes[split.axis][i];
            if (bin.count > 0) sides[i < split.bin ? 0 : 1].grow(bin.box.box());
        }
        return common(sides[0], sides[1]).halfArea() > leastOverlap * rootArea_;
    }

    Primitive scaled(uint32_t id) const { return triangles_[id].scaled(unit_); }

    SpatialSplit bestSpatialSplit(const std::vector<BoxReference>& references, const Box& node) const {
        SpatialSplit found[3];
        const auto along = [&](int axis) { found[axis] = bestSpatialSplit(references, node, axis); };
        if (references.size() >= parallelSize)
            parallelFor(3, 1, [&](size_t begin, size_t end) {
                for (size_t axis = begin; axis < end; ++axis) along(static_cast<int>(axis));
            });
        else
            for (int axis = 0; axis < 3; ++axis) along(axis);
        SpatialSplit best;
        for (const SpatialSplit& one : found)
            if (one.cost < best.cost) best = one;
        return best;
    }

    SpatialSplit bestSpatialSplit(const std::vector<BoxReference>& references, const Box& node, int axis) const {
        struct Bin {
            Box box;
            uint64_t entries = 0, exits = 0;
        };
        const float lo = node.lo[axis], step = (node.hi[axis] - lo) / spatialBins;
        SpatialSplit best;
        if (!(step > 0.0f)) return best;
        std::array<float, spatialBins + 1> planes;
        for (int i = 0; i <= spatialBins; ++i)
            planes[i] = i == spatialBins ? node.hi[axis] : lo + step * static_cast<float>(i);
        const auto binOf = [&](float x) { return std::clamp(static_cast<int>((x - lo) / step), 0, spatialBins - 1); };
        std::array<Bin, spatialBins> bins;
        for (const BoxReference& reference : references) {
            const int first = binOf(reference.lo[axis]), last = binOf(reference.hi[axis]);
            ++bins[first].entries;
            ++bins[last].exits;
            if (first == last) {
                bins[first].box.grow(boxIn(reference));
                continue;
            }
            const Primitive triangle = scaled(reference.id);
            for (int i = first; i <= last; ++i) {
                Box slab = boxIn(reference);
                slab.lo[axis] = std::max(slab.lo[axis], planes[i]);
                slab.hi[axis] = std::min(slab.hi[axis], planes[i + 1]);
                bins[i].box.grow(clippedBounds(triangle, slab));
            }
        }
        std::array<float, spatialBins> rightCost;
        std::array<uint64_t, spatialBins> rightCount;
        Box box;
        uint64_t count = 0;
        for (int i = spatialBins - 1; i > 0; --i) {
            box.grow(bins[i].box);
            rightCount[i] = count += bins[i].exits;
            rightCost[i] = box.halfArea() * static_cast<float>(count);
        }
        box = Box{};
        count = 0;
        for (int i = 1; i < spatialBins; ++i) {
            box.grow(bins[i - 1].box);
            count += bins[i - 1].entries;
            if (count == 0 || rightCount[i] == 0) continue;
            const float cost = costs_.triangle * (box.halfArea() * static_cast<float>(count) + rightCost[i]);
            if (cost < best.cost) best = {cost, axis, planes[i], count + rightCount[i]};
        }
        return best;
    }

    /// Cuts the references at the plane; one whose two parts cost more than it whole goes to one side as it is.
    /// False, and nothing done, if one side gets nothing or all.
    bool cut(const std::vector<BoxReference>& references, const SpatialSplit& split, std::vector<BoxReference>& left,
             std::vector<BoxReference>& right) const {
        Box boxes[2];
        std::vector<std::array<BoxReference, 3>> both;  // left part, right part, whole
        for (const BoxReference& reference : references) {
            if (reference.hi[split.axis] <= split.plane) {
                left.push_back(reference);
                boxes[0].grow(boxIn(reference));
            } else if (reference.lo[split.axis] >= split.plane) {
                right.push_back(reference);
                boxes[1].grow(boxIn(reference));
            } else {
                Box below = boxIn(reference), above = below;
                below.hi[split.axis] = above.lo[split.axis] = split.plane;
                const Primitive triangle = scaled(reference.id);
                below = clippedBounds(triangle, below);
                above = clippedBounds(triangle, above);
                if (below.empty() || above.empty()) {
                    (above.empty() ? left : right).push_back(reference);
                    boxes[above.empty() ? 0 : 1].grow(boxIn(reference));
                    continue;
                }
                both.push_back({referenceOf(below, reference.id), referenceOf(above, reference.id), reference});
                boxes[0].grow(below);
                boxes[1].grow(above);
            }
        }
        auto leftCount = static_cast<float>(left.size() + both.size());
        auto rightCount = static_cast<float>(right.size() + both.size());
        for (const auto& [below, above, whole] : both) {
            const float apart = boxes[0].halfArea() * leftCount + boxes[1].halfArea() * rightCount;
            const Box leftJoined = joined(boxes[0], boxIn(whole)), rightJoined = joined(boxes[1], boxIn(whole));
            const float allLeft = leftJoined.halfArea() * leftCount + boxes[1].halfArea() * (rightCount - 1.0f);
            const float allRight = boxes[0].halfArea() * (leftCount - 1.0f) + rightJoined.halfArea() * rightCount;
            if (allLeft < apart && allLeft <= allRight) {
                left.push_back(whole);
                boxes[0] = leftJoined;
                rightCount -= 1.0f;
            } else if (allRight < apart) {
                right.push_back(whole);
                boxes[1] = rightJoined;
                leftCount -= 1.0f;
            } else {
                left.push_back(below);
                right.push_back(above);
            }
        }
        const bool divided =
            !left.empty() && !right.empty() && left.size() < references.size() && right.size() < references.size();
        if (!divided) {
            left.clear();
            right.clear();
        }
        return divided;
    }

    std::span<const Primitive> triangles_;
    float unit_;
    uint32_t maxLeaf_;
    SahCosts costs_;
    float rootArea_;
};

}  // namespace

BinaryTree buildSpatialSplits(std::vector<BoxReference> references, std::span<const Primitive> triangles, float unit,
                              uint32_t maxLeaf, const SahCosts& costs, uint64_t budget) {
    if (references.empty()) return {};
    Box root;
    for (BoxReference& reference : references) {
        reference.lo *= unit;
        reference.hi *= unit;
        root.grow(boxIn(reference));
    }
    const SpatialBuilder builder(triangles, unit, maxLeaf, costs, root);
    Subtree whole = builder.build(std::move(references), 0, budget);
    BinaryTree tree{std::move(whole.nodes), std::move(whole.references)};
    for (BinaryNode& node : tree.nodes) {
        node.box.lo /= unit;
        node.box.hi /= unit;
    }
    return tree;
}

}  // namespace raig
