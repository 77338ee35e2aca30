/// How a binary tree lies in memory for each of the walks of bvh (see structures/bvh.hpp).
#pragma once

#include "structures/binned_sah.hpp"
#include "structures/structure.hpp"

namespace raig::bvh {

/// Fills in structure.nodes, walk, header.walk and the grid of header, for walk "skip", "octants", "octants16" or "auto".
/// Requires header.lo, hi and nodeCount. Throws usageError for another name. O(nodes), the octants in parallel.
void layOut(const BinaryTree& tree, std::string_view walk, Structure& structure);

/// One node, read back: its box in the structure's unit (of quantised planes: what they stand for, in double) and its word.
struct LaidNode {
    dvec3 lo, hi;
    uint32_t word;
};
LaidNode laidNode(const Structure& structure, uint32_t octant, uint32_t index);

/// The number of copies of the tree: 1 or 8.
uint32_t copies(const Structure& structure);

/// Nodes of each copy with those at its end that stop a walk.
inline size_t nodesACopy(const StructureHeader& header) {
    return size_t{header.nodeCount} + shared::BVH_END_NODES;
}

inline constexpr uint32_t leafBit = 0x80000000u;

}  // namespace raig::bvh
