/// Uniform grid, at one level or two, walked cell by cell.
///
/// The scene's bounds are cut into about `--grid-density` cells a triangle, roughly cubic, at most 1023 along an axis. Every
/// cell lists the triangles and spheres that overlap it (PrimitiveBoxTest), grown by a margin: so much may rounding misplace
/// a hit for rays that start not too far away, and those from farther are walked in another way, slower
/// (shaders/structures/grid.glsl, where the layout of nodes[] is described, too).
///
/// At two levels cells are larger, and those with many triangles are divided once more, by a power of two along each axis;
/// and so again are parts that hold very many still, as where there are small things in a large place: two uniform divisions
/// alone do not get from a stadium to the triangles of a teapot. What is in a part is grown by a margin that is fit for rays
/// that start within a certain reach of it, others test the cell's list: so the margin is in proportion to the part, not to
/// the scene.
///
/// All planes are float numbers without rounding: gridOrigin and gridStep over 2^k, the finest division, are multiples of a
/// power of two q of which no plane's coordinate is more than 2^24. So builder and walk mean the same planes.
///
/// Triangles lie in memory once each, in Morton order of their centres; lists hold their numbers.
///
/// Sources: Amanatides, Woo 1987, "A Fast Voxel Traversal Algorithm for Ray Tracing"; Kalojanov, Billeter, Slusallek 2011,
/// "Two-Level Grids for Ray Tracing on GPUs".
#pragma once

#include "structures/structure.hpp"

namespace raig::grid {

/// Builds in parallel, the same bytes for any number of threads. Reads gridDensity, levels and memoryBudget. Without
/// gridDensity, cells become fewer until references are at most 20 times the triangles; with it or not, until the structure
/// is within the budget. O(triangles + cells + references).
/// Throws limitError beyond 2^27 triangles.
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is there once, the corners as given;
/// planes are exact and increase, and the grid holds the scene with a margin around it; every list is in order, without
/// repetition, inside the lists, and ends; crowded cells' parts lie apart and inside, and their reach is theirs; every cell
/// and part lists each triangle that clipping says comes near it, and none that stays away from it along an axis.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig::grid
