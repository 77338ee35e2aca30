/// The four standard sets of rays, made a second time from their definition, with nothing of what it judges: in long double,
/// by trying all triangles.
#pragma once

#include <array>
#include <cstdint>
#include <vector>

namespace raig::test {

using Real = long double;
using Vector = std::array<Real, 3>;
using Corners = std::array<Vector, 3>;

struct ExactRay {
    Vector origin, direction;
    Real tMax;
};

struct ExactSets {
    std::vector<ExactRay> primary, shadow, diffuse, specular;
    Vector eye;
    size_t frontal = 0, averted = 0;  ///< hits on surfaces whose normal's z is positive, or not
};

/// For a picture of side x side pixels of triangles, of which the box [low, high] is framed.
ExactSets exactSets(const std::vector<Corners>& triangles, const Vector& low, const Vector& high, uint32_t side);

}  // namespace raig::test
