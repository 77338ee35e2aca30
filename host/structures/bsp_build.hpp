/// The tree of a bsp while it is being built.
#pragma once

#include "structures/bsp_plane.hpp"
#include "structures/structure.hpp"

#include <memory>

namespace raig::bsp {

/// An inner node has one child or two; a leaf has none, but triangles. [0] is below the plane.
struct Node {
    Plane plane;
    std::array<std::unique_ptr<Node>, 2> children;
    std::vector<uint32_t> triangles;
    double area = 0.0;  ///< of the cell
};

/// What a tree may grow to. A cell hands on what it has left to its parts, by how much they hold.
struct BuildLimits {
    uint32_t maxLeaf = 0;     ///< cells of more triangles are split wherever that separates any; 0: where it pays
    uint32_t levels = 1;      ///< inner nodes and the leaf on any way down
    uint64_t references = 0;  ///< in leaves
    uint64_t words = 0;       ///< uvec4 of nodes
};

struct Tree {
    std::unique_ptr<Node> root;
    bool lacksMemory = false;  ///< there were cells that it would have paid to split, had there been words for it
};

/// Splits the bounds until it does not pay, or the limits are reached. `usable` are the indices of the triangles to take;
/// requires at least one. `header` tells the bounds and the unit.
Tree buildTree(std::span<const Primitive> triangles, std::span<const uint32_t> usable, const StructureHeader& header,
               const BuildLimits& limits);

}  // namespace raig::bsp
