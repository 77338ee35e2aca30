/// Every triangle, in order: no structure at all, and the ground truth of the walks. The walk is
/// shaders/structures/brute.glsl.
#pragma once

#include "structures/structure.hpp"

namespace raig::brute {

/// Lists the usable triangles. O(n).
Structure build(std::span<const Primitive> triangles, const BuildParams& params);

/// Each usable triangle is listed once, in order, with its own corners.
std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig::brute
