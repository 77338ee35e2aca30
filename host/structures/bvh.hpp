/// Bounding volume hierarchy in depth-first order, walked without a stack.
///
/// The first child of inner node i is node i + 1. Its skip link names the node to go to when a ray misses node i; it is
/// always greater than i, and the node count ends the walk. A leaf is followed by the next node. So the walk is an
/// increasing sequence of indices, whatever the ray and however many children a node has: it cannot loop.
///
/// Layouts (header.walk, shared/structure.glsl): one copy of the tree, its children in an order that suits no ray in
/// particular (--walk skip); or eight, one for each octant of ray directions, children near first, boxes as (near, far)
/// planes of 32 or 16 bits, or spheres, oriented boxes, k-DOPs (--walk octants). 16-bit planes lie on a grid over the scene,
/// rounded outwards. Each copy ends in nodes that no ray hits but from very far away, whose words are their own indices: the
/// end of the walk. Or one copy whose nodes hold the boxes of all their children, visited near first whatever the ray's
/// octant, with planes of 32, 16 or 8 bits (--walk trail): structures/bvh_trail.hpp. All others:
/// word: the skip link; or 1 << 31 | first triangle << 4 | count (1 to 15) of a leaf.
///
/// Builders are in structures/bvh_builders.hpp, bounds in structures/bvh_bounds.hpp. Skip links follow [Smits 1998,
/// "Efficiency Issues for Ray Tracing"]. The walks are shaders/structures/bvh.glsl and trail.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::bvh {

/// Builds in parallel; the same bytes for any number of threads. An empty span gives an empty structure that nothing hits.
/// Options: --build (binned), --walk, --bound (aabb), --arity (4), --precision, --max-leaf (4, at most 15).
/// At most 2^27 triangles, and no more than the memory budget: one copy of the tree instead of eight where eight exceed it,
/// with a remark; throws limitError beyond. Walk "auto" is octants with 16-bit planes, the fastest measured on lavapipe,
/// unless their grid is too coarse for the scene's triangles (more than half the median leaf's extent a step); then with 32
/// bits.
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Names the first broken invariant, or nothing if all hold: each usable triangle is in a leaf, the corners as given, and no
/// other is; every bound contains its children's boxes and its triangles, those that spatial splits cut by the parts in all
/// their leaves; i < skip <= node count; leaves hold 1 to 15; all copies of the tree have the same leaves.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig::bvh
