/// The part of a primitive that lies in a box.
#pragma once

#include "structures/structure.hpp"

namespace raig {

/// A box around what `primitive` and `box` have in common, and inside `box`; an empty one if they have nothing in common.
/// Conservative: no point of the primitive in the box, in exact arithmetic, is left out, at the cost of 2^-45 or one float
/// more than needed on each side that a triangle is cut at; of a sphere, of the corners that the cuts' own sides round off
/// (and 2^-23 where it is nearly missed).
/// Requires coordinates of magnitude at most 2, as all have inside a structure. O(1): six cuts of a polygon.
/// Source: Sutherland, Hodgman 1974, "Reentrant Polygon Clipping"; Wald, Havran 2006, "On building fast kd-Trees for Ray
/// Tracing, and on doing that in O(N log N)", who call splits by it perfect.
Box clippedBounds(const Primitive& primitive, const Box& box);

}  // namespace raig
