/// Splitting at the best of all places between two centroids.
#pragma once

#include "structures/top_down.hpp"

#include <span>

namespace raig {

/// Splits the range where the surface area heuristic's cost is least, over all places along all axes. As TopDown wants it:
/// orders the range, sets the node's axis, and returns how many references go left; 0 if a leaf is cheaper and may hold
/// them. Requires rightAreas.size() >= range.count. Sorts three or four times.
uint32_t splitBySweep(const Range& range, BinaryNode& node, uint32_t maxLeaf, const SahCosts& costs,
                      std::span<float> rightAreas);

}  // namespace raig
