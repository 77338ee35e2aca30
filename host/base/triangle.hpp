/// Which triangles and spheres rays can meet.
#pragma once

#include "base/box.hpp"
#include "base/vectors.hpp"

namespace raig {

/// The largest magnitude of a coordinate that rays can meet: beyond it a squared distance overflows a float.
inline constexpr float largestCoordinate = 1.844e18f;

/// True if every component's magnitude is at most largestCoordinate; false for NaN.
bool isInRange(const vec3& point);

/// True if a ray can hit the triangle: its corners are in range and do not lie on a line (in exact arithmetic on the float
/// corners, up to a few parts in 2^53).
bool isUsable(const vec3& a, const vec3& b, const vec3& c);

/// True if a ray can hit the sphere: its radius is positive, and its centre and all of it are in range. False for NaN.
bool isUsableSphere(const vec3& centre, float radius);

/// The box of a sphere: no point of it lies outside, and no smaller box of floats does as well.
Box sphereBox(const vec3& centre, float radius);

}  // namespace raig
