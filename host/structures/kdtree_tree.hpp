/// A kd-tree before it is laid out for the walk.
#pragma once

#include "structures/kdtree_split.hpp"
#include "structures/structure.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace raig::kdtree {

/// An inner node. Children: words as in kdtree.hpp, but leaves count from the beginning of Tree::lists.
struct Node {
    float plane = 0.0f;
    uint32_t axis = 0;
    uint32_t below = 0;
    uint32_t above = 0;
};

struct Tree {
    std::vector<Node> nodes;      ///< depth first
    std::vector<uint32_t> lists;  ///< ids of triangles, the last of each leaf with lastBit
    uint32_t root = 0;            ///< word of the root
    uint64_t leaves = 0;          ///< that hold something
    uint32_t depth = 0;           ///< levels, leaves included
    double cost = 0.0;            ///< half areas of the cells of nodes, leaves and references, summed
    bool shortOfMemory = false;   ///< a cell was left whole because of TreeParams::mostWords
};

enum class Builder { sah, median };

struct TreeParams {
    Builder builder = Builder::sah;
    uint32_t maxLeaf = 1;
    uint32_t maxDepth = 64;  ///< levels of inner nodes
    uint64_t mostAdded = 0;  ///< references beyond one a triangle
    uint64_t mostWords = 0;  ///< of nodes and lists, beyond one a triangle
    Costs costs;
    size_t exactSize = 0;  ///< see cheapestPlane()
};

/// Builds top down. Each half of a cell gets a share of what may still be added by its references, so that what comes out
/// does not depend on the order in which tasks run. Requires triangles in the unit of a structure, `references` with their
/// boxes, and `cell` around all of them.
Tree buildTree(std::span<const Primitive> triangles, std::vector<BoxReference> references, const Box& cell,
               const TreeParams& params);

}  // namespace raig::kdtree
