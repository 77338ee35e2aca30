/// The binned SAH builder: a binary tree over boxes, before it is laid out for a walk.
#pragma once

#include "base/box.hpp"

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

/// Nodes may have gaps between them: only what is reached from node 0 is part of the tree. No nodes: nothing was given.
struct BinaryTree {
    std::vector<BinaryNode> nodes;
    std::vector<BoxReference> references;  ///< in leaf order
};

/// Costs that decide where to stop, in units of one node visit.
struct SahCosts {
    float node = 1.0f;
    float triangle = 1.0f;
};

/// Builds top down, up to 16 bins an axis over the centroids' bounds. References whose centroids coincide are halved by order, and
/// so is everything below depth 64: no tree is deeper than 64 + log2(n).
/// Requires 1 <= maxLeaf. Deterministic for any number of threads. O(n log n) expected; 32 n bytes beside the result.
/// Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".
BinaryTree buildBinnedSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs);

}  // namespace raig
