/// A binary tree over boxes, as builders make it, before it is laid out for a walk.
#pragma once

#include "base/box.hpp"

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

namespace raig {

/// What is built over: a box and whose it is.
struct BoxReference {
    vec3 lo;
    uint32_t id;
    vec3 hi;
    uint32_t unused;
};

struct BinaryNode {
    Box box;
    uint32_t left = 0;   ///< inner: index of the child with the lower centroids along `axis`
    uint32_t right = 0;  ///< inner: the other child
    uint32_t first = 0;  ///< leaf: of BinaryTree::references
    uint32_t count = 0;  ///< leaf: how many, at least 1; 0 for an inner node
    uint32_t axis = 0;   ///< inner: along which it was split
};
static_assert(offsetof(BinaryNode, right) == offsetof(BinaryNode, left) + sizeof(uint32_t), "an array of two");

/// Nodes may have gaps between them: only what is reached from node 0 is part of the tree. No nodes: nothing was given.
struct BinaryTree {
    std::vector<BinaryNode> nodes;
    std::vector<BoxReference> references;  ///< in leaf order: those of a subtree lie side by side

    /// Not empty if the tree has been made wide: then an inner node's children are `right` indices in here, from `left` on.
    std::vector<uint32_t> wide = {};

    std::span<const uint32_t> childrenOf(const BinaryNode& node) const {
        return wide.empty() ? std::span(&node.left, 2) : std::span(wide).subspan(node.left, node.right);
    }
};

/// Gives every inner node up to `arity` children, by taking in those of the child with the largest area, time and again:
/// what a ray visits least often goes first. O(nodes).
/// Source: Wald, Benthin, Boulos 2008, "Getting Rid of Packets".
void widen(BinaryTree& tree, uint32_t arity);

/// Drops the nodes that are not reached from node 0, and gives back their memory. The others keep their order. O(nodes),
/// with four bytes for each on top.
void compact(BinaryTree& tree);

/// Makes leaves of all subtrees with at most maxLeaf references. O(nodes).
void prune(BinaryTree& tree, uint32_t maxLeaf);

/// Below this depth builders halve what is left, whatever that costs: no tree is deeper than 32 + log2(n).
inline constexpr uint32_t deepestChoice = 32;

/// Costs that decide where to split and where to stop, in units of one node visit.
struct SahCosts {
    float node = 1.0f;
    float triangle = 1.0f;
};

}  // namespace raig
