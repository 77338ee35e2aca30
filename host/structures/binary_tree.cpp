#include "structures/binary_tree.hpp"

#include <algorithm>

namespace raig {

namespace {

/// The index of the inner child with the largest area, or the number of children.
size_t largestInner(const BinaryTree& tree, const std::vector<uint32_t>& children) {
    size_t best = children.size();
    float area = -1.0f;
    for (size_t i = 0; i < children.size(); ++i) {
        const BinaryNode& child = tree.nodes[children[i]];
        if (child.count > 0 || child.box.halfArea() <= area) continue;
        best = i;
        area = child.box.halfArea();
    }
    return best;
}

struct Span {
    uint32_t first, count;
};

/// Prunes below a node; returns the references there. Recursion is as deep as the tree: at most 64 levels.
Span pruneBelow(BinaryTree& tree, uint32_t index, uint32_t maxLeaf) {
    BinaryNode& node = tree.nodes[index];
    if (node.count > 0) return {node.first, node.count};
    const Span left = pruneBelow(tree, node.left, maxLeaf), right = pruneBelow(tree, node.right, maxLeaf);
    const Span all{std::min(left.first, right.first), left.count + right.count};
    if (all.count <= maxLeaf) {
        node.first = all.first;
        node.count = all.count;
    }
    return all;
}

}  // namespace

void widen(BinaryTree& tree, uint32_t arity) {
    std::vector<uint32_t> wide, pending;
    if (!tree.nodes.empty() && tree.nodes[0].count == 0) pending.push_back(0);
    while (!pending.empty()) {
        BinaryNode& node = tree.nodes[pending.back()];
        pending.pop_back();
        std::vector<uint32_t> children{node.left, node.right};
        while (children.size() < arity) {
            const size_t largest = largestInner(tree, children);
            if (largest == children.size()) break;
            BinaryNode& taken = tree.nodes[children[largest]];
            taken.box = Box{};  // not reached any more
            children[largest] = taken.left;
            children.insert(children.begin() + static_cast<std::ptrdiff_t>(largest) + 1, taken.right);
        }
        node.left = static_cast<uint32_t>(wide.size());
        node.right = static_cast<uint32_t>(children.size());
        wide.insert(wide.end(), children.begin(), children.end());
        for (const uint32_t child : children)
            if (tree.nodes[child].count == 0) pending.push_back(child);
    }
    tree.wide = std::move(wide);
}

void compact(BinaryTree& tree) {
    constexpr uint32_t unreached = 0xffffffffu;
    std::vector<uint32_t> places(tree.nodes.size(), unreached), pending;
    if (!tree.nodes.empty()) pending.push_back(0);
    while (!pending.empty()) {
        const uint32_t index = pending.back();
        pending.pop_back();
        places[index] = 0;
        if (tree.nodes[index].count > 0) continue;
        const std::span<const uint32_t> children = tree.childrenOf(tree.nodes[index]);
        pending.insert(pending.end(), children.begin(), children.end());
    }
    uint32_t next = 0;
    for (uint32_t& place : places)
        if (place != unreached) place = next++;
    for (size_t i = 0; i < places.size(); ++i) {
        if (places[i] == unreached) continue;
        BinaryNode node = tree.nodes[i];
        if (node.count == 0 && tree.wide.empty()) {
            node.left = places[node.left];
            node.right = places[node.right];
        }
        tree.nodes[places[i]] = node;
    }
    for (uint32_t& child : tree.wide) child = places[child];
    tree.nodes.resize(next);
    tree.nodes.shrink_to_fit();
}

void prune(BinaryTree& tree, uint32_t maxLeaf) {
    if (!tree.nodes.empty()) pruneBelow(tree, 0, maxLeaf);
}

}  // namespace raig
