/// Which triangles rays can meet.
#pragma once

#include "base/vectors.hpp"

namespace raig {

/// The largest magnitude of a coordinate that rays can meet: beyond it a squared distance overflows a float.
inline constexpr float largestCoordinate = 1.844e18f;

/// True if every component's magnitude is at most largestCoordinate; false for NaN.
bool isInRange(const vec3& point);

/// True if a ray can hit the triangle: its corners are in range and do not lie on a line (in exact arithmetic on the float
/// corners, up to a few parts in 2^53).
bool isUsable(const vec3& a, const vec3& b, const vec3& c);

}  // namespace raig
