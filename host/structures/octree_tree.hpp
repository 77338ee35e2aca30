/// An octree before it is laid out for the walk.
#pragma once

#include "structures/allowance.hpp"
#include "structures/structure.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace raig::octree {

/// A cell with something in it. Children count from the record itself, within Tree::records.
struct Record {
    uint32_t first = 0;  ///< inner: index of the first child; leaf: of its first word in Tree::lists
    uint32_t mask = 0;   ///< inner: octants with something in them; 0 for a leaf
    uint32_t count = 0;  ///< of a leaf's triangles
};

struct Tree {
    std::vector<Record> records;  ///< the root first
    std::vector<uint32_t> lists;  ///< ids of triangles
    uint64_t leaves = 0;
    uint32_t depth = 0;          ///< levels, leaves included
    double cost = 0.0;           ///< areas of the cells of records and references, summed, by that of the root
    bool shortOfMemory = false;  ///< a cell was left whole because of the allowance of words
};

struct TreeParams {
    uint32_t maxLeaf = 1;
    uint32_t maxDepth = 1;    ///< levels below the root
    Allowance allowance;      ///< beyond one reference a triangle and one record
    double recordCost = 1.0;  ///< of a visit, in triangle tests
};

/// Builds top down. Requires triangles in the unit of a structure, and `ids` of those to build over, inside the header's
/// grid.
Tree buildTree(std::span<const Primitive> triangles, std::vector<uint32_t> ids, const StructureHeader& header,
               const TreeParams& params);

}  // namespace raig::octree
