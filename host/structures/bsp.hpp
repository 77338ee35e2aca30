/// Binary space partition with planes in any direction, walked without a stack.
///
/// Every inner node has a plane n . x = d, in coordinates relative to header.gridOrigin = lo, |nx| + |ny| + |nz| <= 1. What
/// lies on its negative side is below it, the rest above; a triangle on both sides is referenced on both. One that sticks
/// out of a side by no more than 14 * 2^-24 of the largest extent counts as within it, and one within that of the plane
/// itself is on one side only, whichever is cheaper: the walk's slack covers both, so a triangle may lie in its own plane,
/// or be one of a thousand that do. A sphere is referenced on each side that it reaches: it is not cut.
///
/// A node is one uvec4:
///     inner   x: nx, 21 bits, and the low 11 bits of nz; y: ny and the high 11 bits of nz, all in steps of 2^-20 from -1;
///             z: d; w: the first child, the second follows it; bit 30 or 29: there is none below, or none above
///     leaf    up to three references (x, y, z); w: bit 31, and how many in bits 0-1. Bit 30: the leaf goes on in the next
///             node, or (bit 29 too, with two references here) in node z
/// Children and parts of leaves come after what leads to them.
///
/// Planes are chosen by the surface area heuristic among those of a sample of the triangles, those through their edges at
/// right angles to them [Ize, Wald, Parker 2008, "Ray Tracing with the BSP Tree"], and axis-aligned ones at the ends of all
/// of them [Wald, Havran 2006, "On building fast kd-Trees for Ray Tracing, and on doing that in O(N log N)"]. Areas are
/// those of the convex cells themselves. The walk is shaders/structures/bsp.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::bsp {

/// Builds in about O(n log^2 n) time, in parallel; the same bytes for any number of threads. Offers --max-leaf (cells of
/// more triangles are split wherever that separates any; by default, where it pays) and --max-tree-depth (at most 64).
/// Splits no further where there would be more than 16 references a triangle, or the memory budget would be exceeded: only
/// what one leaf of everything takes is always taken. At most 2^27 triangles: throws limitError beyond.
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is stored once, the corners as given;
/// every point of it is in a leaf that references it, up to what the walk allows for; every node but the first has one
/// parent, which comes before it; the tree has at most 64 levels; planes are within the bounds.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig::bsp
