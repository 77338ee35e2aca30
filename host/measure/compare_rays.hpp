/// Rays that ask more of a tracer than a camera's do.
#pragma once

#include "rays/types.hpp"
#include "reference/tree.hpp"

#include <vector>

namespace raig {

/// Rays that go on in a random direction from where `rays` hit, on the side they came from; those that hit nothing have
/// none. Origins are floats, 8 ULP off the surface. The same rays every time. Cost: one closest hit a ray, over all cores.
std::vector<Ray> bounceRays(const reference::Tree& tree, std::span<const Ray> rays);

/// `count` rays from `eye` at corners, at middles of edges and at other points of edges of random usable triangles, in turn,
/// and at centres and silhouettes of usable spheres, or any points of those that it lies in; none if nothing is usable.
/// Rounded to floats, they pass some 2^-24 of the distance beside them: here leaks show.
std::vector<Ray> aimedRays(const Geometry& geometry, const vec3& eye, size_t count);

}  // namespace raig
