/// What both halves of the oracle, for triangles and for spheres, are made of.
#pragma once

#include "measure/oracle.hpp"

#include <cmath>

namespace raig::hard {

inline constexpr double roundoff = 0x1p-24;
inline constexpr double ofHit = 64.0;   // u M: how far along an axis a hit may lie from its triangle
inline constexpr double ofEdge = 32.0;  // u M: how far off an edge rounding may decide on which side a ray passes it
inline constexpr double farthestCorner = 1.844e18;

inline bool isFinite(const vec3& v) {
    return std::isfinite(v.x) && std::isfinite(v.y) && std::isfinite(v.z);
}

inline bool isWithin(const vec3& v, double limit) {
    return isFinite(v) && std::abs(v.x) <= limit && std::abs(v.y) <= limit && std::abs(v.z) <= limit;
}

inline Exact magnitude(Exact value) {
    return value < 0 ? -value : value;
}

/// The value, or 0 if it is so small a part of its terms that their roundings may have made it.
inline Exact certain(Exact value, Exact terms) {
    return magnitude(value) <= terms * Exact(0x1p-104) ? Exact(0) : value;
}

/// A sphere that can be hit.
bool isSoundSphere(const Primitive& sphere);

}  // namespace raig::hard
