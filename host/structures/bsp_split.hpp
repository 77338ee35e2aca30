/// Which plane to split a cell of a bsp by.
#pragma once

#include "structures/bsp_plane.hpp"

#include <cstdint>
#include <vector>

namespace raig::bsp {

/// What a triangle has in a cell: a convex polygon around its part there. Of a sphere, all of it: one corner, the centre.
struct Part {
    uint32_t triangle;
    uint32_t begin, end;  ///< of its corners
    float radius = 0.0f;  ///< of a sphere
};

/// A triangle's corners, relative to the scene's lower bounds. Of a sphere, three times the centre: it suggests no planes
/// but those across the axes.
using Corners = std::array<dvec3, 3>;

/// A cell and what lies in it.
struct Piece {
    Cell cell;
    std::vector<Part> parts;
    std::vector<dvec3> corners;  ///< of all parts

    std::span<const dvec3> polygon(const Part& part) const {
        return std::span(corners).subspan(part.begin, part.end - part.begin);
    }
};

/// Which sides of a plane a part is on. Neither if it lies in the plane.
struct Sides {
    bool below = false, above = false;
};

Sides sidesOf(const Piece& piece, const Part& part, const Plane& plane, double tolerance);

struct Split {
    Plane plane;
    bool planarAbove = false;  ///< where to put what lies in the plane
    double cost = 0.0;         ///< of the cell, split by it: relative to one test of a triangle by each ray in it
};

/// What a step down costs, relative to the test of a triangle.
constexpr double nodeCost = 0.5;

/// The cheapest split found, by the surface area heuristic; nothing if none leaves less than everything on one side, or on
/// both if `dividing`. `triangles` are all of the scene's; one that sticks out of a side by no more than `tolerance` is
/// within it.
std::optional<Split> bestSplit(const Piece& piece, std::span<const Corners> triangles, double tolerance, bool dividing);

}  // namespace raig::bsp
