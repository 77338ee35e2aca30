/// The upper of two levels: a tree over the boxes of instances.
#pragma once

#include "structures/binary_tree.hpp"
#include "structures/structure.hpp"

namespace raig {

/// As it lies in memory (shaders/shared/structure.glsl).
struct TopTree {
    std::vector<uvec4> nodes;
    uint32_t nodeCount = 0;   ///< of one copy
    uint32_t apart = 0;       ///< copies are that many nodes apart; 0: there is one
    uint32_t depth = 0;
    double sahCost = 0.0;     ///< of its nodes
    std::vector<double> visits;  ///< of each box: how likely a random ray through the scene meets it
};

/// Builds over boxes in the world, `unit` being the scene's. Eight copies, one for each octant of directions, up to 2^16
/// boxes. Requires at least one box, none of them empty. O(n log^2 n), beyond 4096 boxes O(n log n).
TopTree buildTopTree(std::span<const Box> boxes, float unit);

/// Bytes of the nodes that buildTopTree makes of so many boxes.
uint64_t topTreeBytes(uint64_t boxes);

}  // namespace raig
