/// Octree: space cut into eight equal parts, again and again, where it helps; walked without a stack.
///
/// The root is a cube of 2^22 steps a side; a cell at level l has 2^(22 - l). Its planes are those of the grid of steps, so
/// that builder and walk agree on them to the bit. Each triangle, and the surface of each sphere, is referenced in every
/// leaf whose cell it overlaps or touches. In `nodes`:
///     0            (end of the records, end of the lists in words, 0, 0)
///     1, the root  a record; and so on for all cells with something in them: breadth before depth, children of one cell
///     next
///                  to each other, in the order of octants (bit 0: upper half in x, 1: in y, 2: in z)
///     after them   lists, four words to a uvec4: a triangle's place in `triangles`; the top bit ends a list
/// The record of an inner cell is (number of its first child, mask of the octants that have something in them, 0, 0): empty
/// ones cost nothing. That of a leaf is (leafBit | place of its list in words from the beginning of `nodes`, ...): the next
/// three words of the record itself if they suffice.
///
/// Triangles are tested against cells by their separating axes [Akenine-Möller 2001], spheres by the distances of the cell's
/// nearest and farthest points. The walk is shaders/structures/octree.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::octree {

/// Builds in O(n log n) for evenly sized triangles, in parallel; the same bytes for any number of threads. At most 2^27
/// triangles: throws limitError beyond. Cells of at most maxLeaf triangles (MAX_OBJ) are not cut, nor those at level
/// maxTreeDepth (MAX_DEPTH, 20 at most), nor those where it does not help: a ray that meets a cell meets two of its eight
/// parts, so it would be tested against a quarter of their references. Stops before it exceeds the memory budget, or 19
/// references a triangle more than there are triangles.
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is listed once, the corners as given; the
/// records are one tree; lists end; each part of a triangle is in a leaf that refers to it.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

inline constexpr uint32_t side = 1u << 22;  ///< of the root, in steps
inline constexpr uint32_t mostLevels = 20;  ///< below the root
inline constexpr uint32_t rootRecord = 1;
inline constexpr uint32_t leafBit = 1u << 31;
inline constexpr uint32_t lastBit = 1u << 31;

/// Where the plane of step i lies along the axis: as the walk computes it.
inline float planeAt(const StructureHeader& header, uint32_t i, int axis) {
    return header.gridOrigin[axis] + static_cast<float>(i) * header.gridStep[axis];
}

}  // namespace raig::octree
