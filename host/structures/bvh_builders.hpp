/// The builders of bvh: binary trees over boxes, each by another way of splitting.
///
/// All are deterministic for any number of threads, and require 1 <= maxLeaf. References whose centroids coincide are halved
/// by order, and so is everything below depth 32: no tree is deeper than 32 + log2(n).
#pragma once

#include "structures/binary_tree.hpp"
#include "structures/structure.hpp"

#include <span>

namespace raig {

/// Surface area heuristic over up to 16 bins an axis of the centroids' bounds, finer ones beside the best split where it
/// pays, and every place where few references are left. O(n log n) expected; 32 n bytes beside the result.
/// Source: Wald 2007, "On fast Construction of SAH-based Bounding Volume Hierarchies".
BinaryTree buildBinnedSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs);

/// Surface area heuristic over every place between two centroids, on all axes: the best that splitting centroids can do,
/// node by node. O(n log^2 n).
/// Source: Goldsmith and Salmon 1987, "Automatic Creation of Object Hierarchies for Ray Tracing"; Wald, Boulos, Shirley
/// 2007, "Ray Tracing Deformable Scenes using Dynamic Bounding Volume Hierarchies".
BinaryTree buildSweepSah(std::vector<BoxReference> references, uint32_t maxLeaf, const SahCosts& costs);

/// Halves the references along the axis on which they spread most, down to maxLeaf. O(n log n).
/// Source: Kay and Kajiya 1986, "Ray Tracing Complex Scenes".
BinaryTree buildMedian(std::vector<BoxReference> references, uint32_t maxLeaf);

/// Sorts the centroids along a Morton curve, 21 bits an axis, and splits where the highest bit changes, down to maxLeaf.
/// O(n log n), the fastest of all.
/// Source: Lauterbach et al. 2009, "Fast BVH Construction on GPUs".
BinaryTree buildMorton(std::vector<BoxReference> references, uint32_t maxLeaf);

/// Binned SAH with spatial splits: where the children of the best split overlap much, references are cut in two at a plane
/// instead, if that is cheaper. At most `budget` references more than triangles in all. O(n log n) expected.
/// `unit` brings coordinates to magnitudes of at most 2. Leaves may share triangles; a node's box bounds the parts in it.
/// Source: Stich, Friedrich, Dietrich 2009, "Spatial Splits in Bounding Volume Hierarchies".
BinaryTree buildSpatialSplits(std::vector<BoxReference> references, std::span<const Primitive> triangles, float unit,
                              uint32_t maxLeaf, const SahCosts& costs, uint64_t budget);

}  // namespace raig
