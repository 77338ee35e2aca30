/// Directions drawn at random about a normal, in double precision.
#pragma once

#include "base/vectors.hpp"

namespace raig::reference {

/// The point of the unit disk that the concentric map sends one of the unit square to: the square of half side r goes to the
/// circle of radius r. Source: Shirley and Chiu 1997, "A Low Distortion Map Between Disk and Square".
dvec2 inDisk(const dvec2& square);

/// `local` with its z axis along unit vector n: the frame with columns (3, -6, 2) / 7, (6, 2, -3) / 7 and s = (2, 3, 6) / 7,
/// turned by half a turn about s + n.
dvec3 aboutNormal(const dvec3& n, const dvec3& local);

/// The way back: the components of v along the axes that aboutNormal() has for n.
dvec3 alongNormal(const dvec3& n, const dvec3& v);

/// A unit vector whose density by solid angle is its cosine to n over pi: the point of the disk for `square`, raised to the
/// hemisphere. Source: Malley 1988, "A Shading Method for Computer Generated Images".
dvec3 cosineDirection(const dvec3& n, const dvec2& square);

}  // namespace raig::reference
