/// Light from where nothing is, in double precision: the sky, or a picture of all directions.
#pragma once

#include "reference/world.hpp"

namespace raig::reference {

/// The radiance in unit direction d: of the environment's texel there if there is one, else of the sky.
dvec3 distantRadiance(const Scene& scene, const dvec3& d);

/// The density, by solid angle, with which arrivingFromEnvironment draws unit direction d. Requires what that does.
double environmentDensity(const Environment& environment, const dvec3& d);

/// A random direction of the environment, as a light: its irradiance is divided by the chance per solid angle.
///
/// Requires  an environment that shines; `rowAndColumn`, in [0, 1)^2 and multiples of 2^-24, choose a texel by its shares,
///           `place` in [0, 1)^2 a point of it, evenly in the unfolded square.
/// Ensures   the mean over uniform choices is the irradiance of the whole environment.
Arriving arrivingFromEnvironment(const Environment& environment, const dvec2& rowAndColumn, const dvec2& place,
                                 const dvec3& shadingNormal);

}  // namespace raig::reference
