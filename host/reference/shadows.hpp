/// What is in the way of light, in double precision.
#pragma once

#include "reference/world.hpp"

namespace raig::reference {

/// Surfaces that a ray may pass straight through by their alpha, one after the other.
inline constexpr uint32_t mostPasses = 64;

/// What gets through of light along `shadow`: of each surface in its way the share that is not there by its alpha, and all of
/// one that transmits if `throughGlass`. Triangles `leaving` and `arriving` are none of them. Nothing, beyond mostPasses.
double transmittance(const World& world, Ray shadow, bool throughGlass, uint32_t leaving, uint32_t arriving = noTriangle);

}  // namespace raig::reference
