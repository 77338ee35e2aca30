/// Rays and spheres in double precision, and in 113 bits where that is in doubt.
#pragma once

#include "reference/triangle.hpp"

namespace raig::reference {

/// The two points at which a line crosses a sphere's surface: near <= far.
struct SphereCrossing {
    double near;
    double far;
};

/// Where the line of `ray` crosses the sphere; nothing if it passes by. The ray's tMin and tMax play no part.
///
/// Requires  isUsable(ray); radius > 0.
/// Ensures   for floats: each distance errs by some 2^-30 of the larger of both at most, mostly 2^-50; whether there is a
///           crossing is the answer of 113-bit arithmetic.
/// Source    the quadratic equation of school.
std::optional<SphereCrossing> crossSphere(const Ray& ray, const vec3& centre, float radius);

/// The nearest points of `ray` (from tMin to tMax) and the sphere's surface. Requires as crossSphere.
Approach approachSphere(const Ray& ray, const vec3& centre, float radius);

/// The distance of a point from the sphere's surface.
double distanceToSphere(const dvec3& point, const vec3& centre, float radius);

}  // namespace raig::reference
