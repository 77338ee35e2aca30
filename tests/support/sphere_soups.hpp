/// Spheres to build over, and rays to send at them.
#pragma once

#include "base/random.hpp"
#include "support/soups.hpp"

namespace raig::test {

/// One sphere; many of all sizes; concentric ones 4e-5 apart; ones that touch; copies of one; with ones that cannot be hit;
/// among triangles, on a ground that is a sphere; smaller than the last place of their centres; far, tiny, huge.
std::vector<Soup> sphereSoups();

/// A point of the sphere's surface, rounded.
vec3 pointOnSphere(const Primitive& sphere, Random& random);

/// From the surface, from inside, from outside, from up to 1e6 radii away; at the centre, at a point of the surface, or past
/// the silhouette by some units in the last place.
Ray rayAtSphere(const Primitive& sphere, Random& random);

}  // namespace raig::test
