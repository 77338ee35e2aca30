/// What bounds the nodes of bvh other than boxes of the scene's axes: spheres, oriented boxes, k-DOPs.
#pragma once

#include "structures/structure.hpp"

#include <array>
#include <span>

namespace raig::bvh {

/// |p - centre| <= radius. Points are seen from the scene's lower corner here.
struct Sphere {
    vec3 centre;
    float radius;
};

/// lo[i] <= dot(axes[i], p) <= hi[i], in exact arithmetic. The axes are of about unit length and about at right angles.
struct OrientedBox {
    std::array<vec3, 3> axes;
    vec3 lo, hi;
};

/// lo[i] <= dot(direction i, p) <= hi[i]: the axes, and (1, 1, 1), (-1, 1, 1), (1, -1, 1), (1, 1, -1).
struct Kdop {
    static constexpr int slabs = 7;
    std::array<float, slabs> lo, hi;
};

/// What is bounded: a corner of a triangle (radius 0), or a sphere. Seen from the scene's lower corner, too.
struct Ball {
    vec3 centre;
    float radius;
};

/// The four diagonals of Kdop, as signs.
inline constexpr std::array<std::array<int, 3>, 4> diagonals = {{{1, 1, 1}, {-1, 1, 1}, {1, -1, 1}, {1, 1, -1}}};

/// A sphere around all balls, some percent larger than the smallest. Up to 64 looks at each ball.
/// Source: Badoiu and Clarkson 2003, "Smaller Core-Sets for Balls".
Sphere sphereAround(std::span<const Ball> balls);

/// The smaller, by area, of the boxes along the balls' principal axes and along the coordinates' axes. O(balls).
/// Source: Gottschalk, Lin, Manocha 1996, "OBBTree: A Hierarchical Structure for Rapid Interference Detection".
OrientedBox orientedBoxAround(std::span<const Ball> balls);

/// O(balls). Source: Kay and Kajiya 1986, "Ray Tracing Complex Scenes".
Kdop kdopAround(std::span<const Ball> balls);

/// The bounds contain the ball, in double precision (exact to 2^-45 for coordinates up to 2).
bool contains(const Sphere& sphere, const Ball& ball);
bool contains(const OrientedBox& box, const Ball& ball);
bool contains(const Kdop& kdop, const Ball& ball);

}  // namespace raig::bvh
