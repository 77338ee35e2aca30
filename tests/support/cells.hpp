/// What tests of structures that cut space into cells have in common: rays aimed at the planes between cells, and walks one
/// loop iteration at a time.
#pragma once

#include "support/soups.hpp"

namespace raig::test {

/// A plane across an axis.
struct AxisPlane {
    int axis;
    float at;
};

/// Rays at the planes, and at the corners that they make: in a plane, with zeros of both signs; from points of a plane, also
/// away from it; through corners of cells; with tMin or tMax on a plane; nearly in a plane; and all that from up to 1e6
/// sizes of the scene away. Requires planes.
std::vector<Ray> raysAtPlanes(const std::vector<Triangle>& triangles, const std::vector<AxisPlane>& planes, uint64_t seed,
                              size_t count);

/// Triangles over which structures that cut space tend to grow without end: 1,000 copies of one, 1,000 that share a vertex
/// (any, and slivers), 1,000 slivers along diagonals.
std::vector<Soup> growingSoups();

/// Overlapping triangles, tilted out of a plane by a few of the smallest steps of a float, and a sphere through them.
Soup nearlyFlatSoup();

}  // namespace raig::test
