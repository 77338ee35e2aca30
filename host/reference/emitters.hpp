/// Drawing points of emitters for direct light.
#pragma once

#include "reference/whitted.hpp"
#include "reference/world.hpp"

namespace raig::reference {

/// False where light from unit `direction` is behind the smooth surface, or behind the face though nothing lies above that.
bool canReach(const SurfacePoint& p, const dvec3& direction);

/// Of `candidates` random points of emitters one, as a light: picked by how each lies to p (both cosines over the squared
/// distance), and standing for all of them. `key` is that of the ray that found p; numbers are of dimensions 1 + 3 key
/// (which emitter), 2 + 3 key (where on it) and 2^30 + key (which point).
///
/// Requires  at least one emitter.
/// Ensures   the mean over samples is the irradiance of all emitters together, as arrivingFromEmitters(). No light if none
///           of the points lights p.
/// Source    Talbot, Cline and Egbert 2005, "Importance Resampling for Global Illumination".
Arriving drawnFromEmitters(const World& world, const SurfacePoint& p, const SampleId& id, uint32_t key, uint32_t seed,
                           uint32_t candidates);

}  // namespace raig::reference
