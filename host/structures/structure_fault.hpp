/// What is wrong with a structure that may come from anywhere, as from a file.
#pragma once

#include "structures/two_level.hpp"

namespace raig {

/// Of one level, over `primitives`, ids being indices: what all structures share, and then what type.findFault finds. If
/// that is nothing, every walk ends, reads only what is there, and finds what it should. Stands any values in the arrays and
/// the header. Cost as type.findFault's.
std::optional<std::string> findOneLevelFault(const Structure& structure, std::span<const Primitive> primitives,
                                             const StructureType& type);

/// The same of what buildTwoLevels made over `scene`, of one level or two: each bottom is checked over what it was built
/// over, and all else made again and compared, to the bit. Stands any values, in Structure::bottoms and instances, too.
/// Memory for the upper level, the primitives written out, and the largest bottom. O(triangles, all places counted) and what
/// type.findFault takes.
std::optional<std::string> findTwoLevelFault(const Structure& structure, const PlacedScene& scene,
                                             const StructureType& type);

}  // namespace raig
