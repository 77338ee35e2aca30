/// Binary bounding volume hierarchy in depth-first order, walked without a stack.
///
/// The first child of inner node i is node i + 1. Its skip link names the node to go to when a ray misses node i; it is
/// always greater than i, and the node count ends the walk. A leaf is followed by the next node. So the walk is an
/// increasing sequence of indices, whatever the ray: it cannot loop.
///
/// Three layouts (walks) of the same tree:
///     skip       one tree, nodes of 32 bytes: (lo, word) (hi, 0); children in an order that suits no ray in particular
///     octants    eight trees, one for each octant of ray directions, children near first, boxes as (near, far) planes
///     octants16  the same with 16-bit planes on a grid over the scene, rounded outwards: 16 bytes a node
/// Each tree ends in nodes that no ray hits but from very far away, whose words are their own indices: the end of the walk.
/// word: the skip link; or 1 << 31 | first triangle << 4 | count (1 to 15) of a leaf.
///
/// Splits minimise the surface area heuristic over up to 16 bins an axis [Wald 2007, "On fast Construction of SAH-based Bounding
/// Volume Hierarchies"]. Skip links follow [Smits 1998, "Efficiency Issues for Ray Tracing"]. The walk is
/// shaders/structures/bvh.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::bvh {

/// Builds in O(n log n) expected time, in parallel; the same bytes for any number of threads. An empty span gives an empty
/// structure that nothing hits. At most 2^27 triangles: throws limitError beyond.
/// Walk "auto" is octants16, the fastest measured on lavapipe, unless the grid is too coarse for the scene's triangles
/// (more than half the median leaf's extent a step); then octants.
Structure build(std::span<const Triangle> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is in exactly one leaf, the corners as
/// given; every box contains its children's and its triangles'; i < skip <= node count; leaves hold 1 to 15; all copies of
/// the tree have the same leaves.
std::optional<std::string> findFault(const Structure& structure, std::span<const Triangle> triangles);

}  // namespace raig::bvh
