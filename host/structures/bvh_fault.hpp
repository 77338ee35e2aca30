/// What checks of all layouts of bvh have in common.
#pragma once

#include "structures/bvh_layout.hpp"

#include <map>
#include <optional>
#include <span>
#include <string>
#include <vector>

namespace raig::bvh {

/// Where parts of triangles that are cut lie: boxes with each, by id.
using Parts = std::map<uint32_t, std::vector<LaidNode::Extent>>;

inline bool contains(const LaidNode::Extent& outer, const dvec3& lo, const dvec3& hi) {
    return glm::all(glm::lessThanEqual(outer.lo, lo)) && glm::all(glm::lessThanEqual(hi, outer.hi));
}

/// Primitives that no leaf's box holds as a whole must lie in their leaves' boxes together: looked at in places spread over
/// them.
std::optional<std::string> findUncovered(const Parts& parts, std::span<const Primitive> triangles, float unit);

/// True if the grid of 16-bit planes is that over the scene.
bool hasSceneGrid(const StructureHeader& header);

}  // namespace raig::bvh
