/// What a structure was built over, in 128 bits: by these, files tell scenes apart (XXH3 [Collet 2019]).
#pragma once

#include "structures/two_level.hpp"

#include <array>

namespace raig {

using SceneHash = std::array<uint64_t, 2>;

/// Of primitives written out: every bit of them, in their order.
SceneHash hashOf(std::span<const Primitive> primitives);

/// Of any bytes.
SceneHash hashOf(std::span<const std::byte> bytes);

/// Of a scene kept as instances: vertices, triangles, which meshes keep, and by which rule; where they stand, mirrored or
/// not; ids; and what is written out in any case. O(what is stored).
SceneHash hashOf(const PlacedScene& scene);

/// Primitives of the scene, all places counted, unusable ones, too.
uint64_t primitiveCount(const PlacedScene& scene);

}  // namespace raig
