/// What the checks of structures that cut space share: parts of primitives, in double precision, not as builders find them.
#pragma once

#include "structures/structure.hpp"

namespace raig {

/// What a part of a triangle must stick out of a plane to count as on that side of it, in a structure's unit: far above the
/// rounding of cuts, far below that of the corners.
inline constexpr double partThickness = 0x1p-40;

/// What of the convex polygon lies where sign * (x - plane) <= 0 along the axis.
std::vector<dvec3> partOfPolygon(const std::vector<dvec3>& polygon, int axis, double plane, double sign);

/// True if the sphere has points in the box that lie farther than partThickness from its sides: whatever the rounding.
/// Requires a sphere in a structure's unit.
bool isSurelyIn(const Primitive& sphere, const dvec3& lo, const dvec3& hi);

/// Names what is wrong with the list of triangles, if anything: each usable triangle is in it once, with its own corners.
std::optional<std::string> findListFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig
