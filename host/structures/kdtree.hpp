/// kd-tree: the lecture's BSP with axis-aligned planes, walked without a stack.
///
/// An inner node cuts its cell by a plane; the halves are closed, so both hold the plane. Each triangle, and the surface of
/// each sphere, is referenced in every leaf whose cell holds a part of it; a part in a plane itself is in one of the two.
/// Nodes in depth-first order: both children of node i have higher numbers. In `nodes`:
///     0              (end of the nodes, end of the lists in words, 0, 0)
///     1, the root    (bits of the plane, axis, child below the plane, child above it); and so on for all inner nodes
///     after them     the lists of the leaves, four words to a uvec4: a triangle's place in `triangles`; the top bit ends a
///     list
/// A child's word: the number of a node; or, with the top bit set, a leaf: the place of its list, counted in words from the
/// beginning of `nodes`; or all bits set: a cell with nothing in it, which costs nothing. No triangles, no nodes.
///
/// Builders:
///     sah     planes by the surface area heuristic, over the ends of the triangles' boxes, cut to the cell [Wald, Havran
///             2006, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)"]
///     median  the lecture's: the plane halves the triangles, along the longest axis that it helps on
/// The walk is shaders/structures/kdtree.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::kdtree {

/// Builds in O(n log^2 n), in parallel; the same bytes for any number of threads. At most 2^27 triangles: throws limitError
/// beyond. Cells of at most maxLeaf triangles are not cut; maxTreeDepth is 64 at most. Stops cutting where that does not
/// help, and before it exceeds the memory budget or 15 references a triangle more than there are triangles.
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is listed once, the corners as given; the
/// nodes are one tree, each plane in its cell; lists end; each part of a triangle is in a leaf that refers to it.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

inline constexpr uint32_t rootNode = 1;
/// Words of a child.
inline constexpr uint32_t leafBit = 1u << 31;
inline constexpr uint32_t emptyCell = 0xffffffffu;
/// Words of a leaf's list.
inline constexpr uint32_t lastBit = 1u << 31;

}  // namespace raig::kdtree
