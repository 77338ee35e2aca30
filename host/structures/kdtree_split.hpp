/// Where a kd-tree cuts a cell.
#pragma once

#include "structures/binary_tree.hpp"

#include <limits>
#include <span>

namespace raig::kdtree {

/// A plane across a cell. Triangles flat in it go to one side.
struct Plane {
    int axis = -1;  ///< none, if negative
    float at = 0.0f;
    bool flatsBelow = false;
    double cost = std::numeric_limits<double>::infinity();  ///< expected, of a ray that meets the cell, if it is cut here

    bool cutsBelow(const BoxReference& r) const { return r.lo[axis] < at || (flatsBelow && r.hi[axis] == at); }
    bool cutsAbove(const BoxReference& r) const { return r.hi[axis] > at || (!flatsBelow && r.lo[axis] == at); }
};

/// Costs in units of one node visit.
struct Costs {
    double triangle = 1.0;
    double emptyBonus = 0.8;  ///< a factor for planes that leave nothing on one side
};

/// The plane of least expected cost, by the surface area heuristic, among the ends of the references' boxes. Above
/// `exactSize` references: among those that lie next to one of 128 equidistant planes an axis, with counts that are too high
/// where other boxes end in the very plane. O(n log n) and O(n).
/// Requires references cut to the cell. Deterministic.
Plane cheapestPlane(std::span<const BoxReference> references, const Box& cell, const Costs& costs, size_t exactSize);

/// The plane through the median of the boxes' centres, along the longest axis of the cell on which both halves get fewer
/// references; none if there is no such axis.
Plane medianPlane(std::span<const BoxReference> references, const Box& cell);

}  // namespace raig::kdtree
