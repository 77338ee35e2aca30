#include "structures/kdtree_tree.hpp"

#include "base/parallel.hpp"
#include "structures/allowance.hpp"
#include "structures/clip.hpp"
#include "structures/kdtree.hpp"

#include <algorithm>

namespace raig::kdtree {

namespace {

constexpr size_t parallelSize = 4096;  // references of cells whose halves are tasks of their own
constexpr uint64_t wordsOfNode = sizeof(Node) / sizeof(uint32_t);

struct Halves {
    std::vector<BoxReference> below, above;
};

void append(const BoxReference& r, const Primitive& triangle, const Box& part, std::vector<BoxReference>& half) {
    const Box box = clippedBounds(triangle, part);
    if (!box.empty()) half.push_back({box.lo, r.id, box.hi, 0});
}

Halves cutByPlane(std::span<const Primitive> triangles, std::span<const BoxReference> references, const Plane& plane) {
    Halves halves;
    for (const BoxReference& r : references) {
        const bool below = plane.cutsBelow(r), above = plane.cutsAbove(r);
        if (!(below && above)) {
            (below ? halves.below : halves.above).push_back(r);
            continue;
        }
        Box low{r.lo, r.hi}, high{r.lo, r.hi};
        low.hi[plane.axis] = high.lo[plane.axis] = plane.at;
        append(r, triangles[r.id], low, halves.below);
        append(r, triangles[r.id], high, halves.above);
    }
    return halves;
}

class TreeBuilder {
public:
    TreeBuilder(std::span<const Primitive> triangles, const TreeParams& params) : triangles_(triangles), params_(params) {}

    /// Appends the subtree of the cell to `tree` and returns its word.
    uint32_t build(std::vector<BoxReference> references, const Box& cell, uint32_t depth, Allowance allowance,
                   Tree& tree) const {
        if (references.empty()) return emptyCell;
        tree.depth = std::max(tree.depth, depth + 1);
        const Plane plane = planeFor(references, cell, depth);
        if (plane.axis < 0) return addLeaf(references, cell, tree);
        Halves halves = cutByPlane(triangles_, references, plane);
        const uint64_t before = references.size(), belowCount = halves.below.size(), aboveCount = halves.above.size();
        const uint64_t after = belowCount + aboveCount, added = after > before ? after - before : 0;
        tree.shortOfMemory |= !allowance.hasWords(added, wordsOfNode);
        if (!allowance.spend(added, wordsOfNode)) return addLeaf(references, cell, tree);
        references = {};

        const auto node = static_cast<uint32_t>(tree.nodes.size());
        tree.nodes.push_back({plane.at, static_cast<uint32_t>(plane.axis), 0, 0});
        tree.cost += double{cell.halfArea()};
        Box low = cell, high = cell;
        low.hi[plane.axis] = high.lo[plane.axis] = plane.at;
        const auto buildBelow = [&](Tree& to) {
            return build(std::move(halves.below), low, depth + 1, allowance.share(belowCount, after), to);
        };
        const auto buildAbove = [&](Tree& to) {
            return build(std::move(halves.above), high, depth + 1, allowance.share(aboveCount, after), to);
        };
        uint32_t below, above;  // words; the node moves while the array grows
        if (before < parallelSize) {
            below = buildBelow(tree);
            above = buildAbove(tree);
        } else {
            Tree other;
            parallelInvoke([&] { below = buildBelow(tree); }, [&] { other.root = buildAbove(other); });
            above = join(other, tree);
        }
        tree.nodes[node].below = below;
        tree.nodes[node].above = above;
        return node;
    }

private:
    Plane planeFor(std::span<const BoxReference> references, const Box& cell, uint32_t depth) const {
        if (references.size() <= params_.maxLeaf || depth >= params_.maxDepth) return {};
        if (params_.builder == Builder::median) return medianPlane(references, cell);
        const Plane plane = cheapestPlane(references, cell, params_.costs, params_.exactSize);
        return plane.cost < params_.costs.triangle * static_cast<double>(references.size()) ? plane : Plane{};
    }

    static uint32_t addLeaf(std::span<const BoxReference> references, const Box& cell, Tree& tree) {
        const auto first = static_cast<uint32_t>(tree.lists.size());
        for (const BoxReference& r : references) tree.lists.push_back(r.id);
        tree.lists.back() |= lastBit;
        ++tree.leaves;
        tree.cost += double{cell.halfArea()} * (1.0 + static_cast<double>(references.size()));
        return leafBit | first;
    }

    /// Appends `other` to `tree` and returns the word of its root there.
    static uint32_t join(const Tree& other, Tree& tree) {
        const auto nodes = static_cast<uint32_t>(tree.nodes.size()), words = static_cast<uint32_t>(tree.lists.size());
        const auto moved = [&](uint32_t word) {
            return word == emptyCell ? word : word + ((word & leafBit) != 0 ? words : nodes);
        };
        for (const Node& n : other.nodes) tree.nodes.push_back({n.plane, n.axis, moved(n.below), moved(n.above)});
        tree.lists.insert(tree.lists.end(), other.lists.begin(), other.lists.end());
        tree.leaves += other.leaves;
        tree.depth = std::max(tree.depth, other.depth);
        tree.cost += other.cost;
        tree.shortOfMemory |= other.shortOfMemory;
        return moved(other.root);
    }

    std::span<const Primitive> triangles_;
    const TreeParams& params_;
};

}  // namespace

Tree buildTree(std::span<const Primitive> triangles, std::vector<BoxReference> references, const Box& cell,
               const TreeParams& params) {
    Tree tree;
    const TreeBuilder builder(triangles, params);
    tree.root = builder.build(std::move(references), cell, 0, {params.mostAdded, params.mostWords}, tree);
    return tree;
}

}  // namespace raig::kdtree
