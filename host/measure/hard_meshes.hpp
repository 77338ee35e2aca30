/// Meshes that hard cases and tests are made of.
#pragma once

#include "base/random.hpp"
#include "scene/scene.hpp"
#include "structures/structure.hpp"

#include <array>
#include <vector>

namespace raig::hard {

/// A closed box: six faces, cut at the coordinates given along each axis (the first and the last are its sides), two
/// triangles a rectangle.
struct CutBox {
    std::array<std::vector<float>, 3> cuts;

    std::vector<Triangle> triangles() const;
    Box box() const;
};

/// A box with `inner` random cuts along each axis, that lie in its middle half.
CutBox randomCutBox(Random& random, const dvec3& centre, double size, int inner);

/// A wall of squares between the whole numbers 0 and `side`, across `axis` at `place`.
std::vector<Triangle> squares(int axis, float place, int side);

/// A zero of either sign.
float anyZero(Random& random);

/// A closed triangle mesh of a bumpy sphere: `rings` x 2 `rings`, the vertices shared exactly.
std::vector<Triangle> sphere(uint32_t rings, double radius, dvec3 centre, double bumps = 0.0);

/// Each triangle with corners of its own, of material 0.
Mesh meshOf(const std::vector<Triangle>& triangles);

}  // namespace raig::hard
