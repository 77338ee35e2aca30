/// Rays and triangles in double precision, decided exactly where double precision is in doubt.
#pragma once

#include "base/vectors.hpp"

#include <cstdint>
#include <limits>
#include <optional>

namespace raig::reference {

/// origin + t * direction for t in [tMin, tMax]. The direction need not be unit length.
struct Ray {
    dvec3 origin{0.0};
    dvec3 direction{0.0, 0.0, 1.0};
    double tMin = 0.0;
    double tMax = std::numeric_limits<double>::infinity();
};

/// True if the ray can hit anything: its origin, direction and tMin are finite, its direction is not zero, tMin <= tMax.
bool isUsable(const Ray& ray);

/// Where a ray's line meets a triangle: the point (1 - u - v) a + u b + v c at t.
struct Crossing {
    double t;
    double u;
    double v;
};

/// Where the line of `ray` crosses triangle (a, b, c), edges and corners included; nothing if it passes by or lies in the
/// triangle's plane. The ray's tMin and tMax play no part.
///
/// Requires  isUsable(ray); corners that make a usable triangle (scene/geometry.hpp).
/// Ensures   for an origin and a direction that are floats: whether there is a crossing is the answer of exact arithmetic on
///           the float corners (as long as their exponents differ by less than 2^30), so a ray through a shared edge or
///           corner meets at least one of the triangles there. t errs by some 2^-30 t at most, mostly 2^-50.
/// Cost      some 60 operations in double; where those cannot tell, the same again in 113-bit arithmetic.
/// Source    the signed volumes of the ray with the three edges; the plane's equation for t.
std::optional<Crossing> cross(const Ray& ray, const vec3& a, const vec3& b, const vec3& c);

/// Where a ray comes nearest to a triangle.
struct Approach {
    double distance;  ///< between the nearest points, in world units; 0 where the ray crosses the triangle
    double t;         ///< of the ray's nearest point, in [ray.tMin, ray.tMax]
};

/// The nearest points of `ray` (from tMin to tMax) and triangle (a, b, c), edges included.
/// Requires as cross. Errs by some 2^-48 of the largest coordinate relative to the ray's origin.
Approach approach(const Ray& ray, const vec3& a, const vec3& b, const vec3& c);

/// The distance of a point from the nearest point of triangle (a, b, c).
/// Source: Ericson 2005, "Real-Time Collision Detection", section 5.1.5 (the Voronoi regions of a triangle).
double distanceToTriangle(const dvec3& point, const vec3& a, const vec3& b, const vec3& c);

}  // namespace raig::reference
