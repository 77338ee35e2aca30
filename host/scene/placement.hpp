/// How an instance puts its mesh into the world: shaders/shared/place.glsl, as C++.
#pragma once

#include "base/shared.hpp"

namespace raig {

namespace shared {
#include "shared/place.glsl"
}  // namespace shared

using shared::NormalPlacement;
using shared::Placement;

/// Rounds a transform, entry by entry. Requires an affine one; what is out of a float's range becomes infinite.
Placement placementOf(const dmat4& toWorld);

/// Its cofactors, scaled; rows of zeros where it leaves no normal a direction.
NormalPlacement normalPlacementOf(const dmat4& toWorld);

/// True if it turns left hands into right ones: then corners 1 and 2 of triangles, and so u and v, change places, so that
/// the front stays the front.
bool mirrors(const dmat4& toWorld);

}  // namespace raig
