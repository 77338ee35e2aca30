/// Lights as they are seen from a point, and what is in the way, in double precision.
#pragma once

#include "reference/whitted.hpp"

namespace raig::reference {

/// Surfaces that a ray may pass straight through by their alpha, one after the other.
inline constexpr uint32_t mostPasses = 64;

/// What gets through of light along `shadow`: of each surface in its way the share that is not there by its alpha, and all
/// of one that transmits if `throughGlass`. Triangles `leaving` and `arriving` are none of them. Nothing, beyond mostPasses.
double transmittance(const World& world, Ray shadow, bool throughGlass, uint32_t leaving, uint32_t arriving = noTriangle);

/// Every light of the scene, then a random point of the emitters, if there are any, which is drawn from `candidates`
/// (reference/emitters.hpp), and a random direction of the environment, if it shines, whose dimensions are 2^31 + 2 k and
/// the next.
std::vector<Arriving> lightsSeen(const World& world, const SurfacePoint& p, const SampleId& id, uint32_t k, uint32_t seed,
                                 uint32_t candidates);

/// What gets through of light from `light`: nothing where it is behind the smooth surface or hidden, or behind the face
/// though nothing lies above that. `leaving` is the triangle of p; `key` is of the rounding.
double shareSeen(const World& world, const SurfacePoint& p, const Arriving& light, bool throughGlass, uint32_t leaving,
                 const SampleId& id, uint32_t key);

}  // namespace raig::reference
