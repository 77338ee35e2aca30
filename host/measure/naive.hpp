/// Textbook intersections and walks, with the faults that the hard cases are about: they must fail there, or the cases ask
/// nothing. For the controls of `raig stress` and for tests only: nothing that is rendered or traced comes from here.
#pragma once

#include "rays/types.hpp"
#include "structures/structure.hpp"

#include <optional>
#include <vector>

namespace raig::hard::naive {

/// Whether the ray meets the box at some distance in [tMin, tMax], by one formula or another.
enum class Slab {
    glsl,         ///< min and max of both products, where min(x, y) is y < x ? y : x
    otherOrder,   ///< where it is x < y ? x : y
    numbers,      ///< where NaN is ignored, as in IEEE 754's minNum
    fused,        ///< fma(b, inv, -o * inv)
    signOfValue,  ///< near and far chosen by d >= 0, inv = 1 / d
    clamped5,     ///< components below 1e-5 set to that
    clamped12,    ///< below 1e-12
    largest,      ///< 1 / 0 = FLT_MAX, and b * inv - o * inv
    strict,       ///< enter < leave
    slack,        ///< Ize 2013: two ULP on the far side, NaN-safe order
};
bool meets(Slab slab, const Box& box, const Ray& ray);

/// Whether the ray meets the triangle.
enum class Tester {
    moellerTrumbore,       ///< [Moeller, Trumbore 1997], without an epsilon
    moellerTrumboreFused,  ///< compiled with multiply-adds
    moellerTrumboreCull,   ///< that leaves out |det| < 1e-7
    watertightFused,       ///< [Woop, Benthin, Wald 2013] compiled with multiply-adds
    sameSigns,             ///< edges by sign(u) != sign(det - u), sign(0) = 0
};
std::optional<float> meets(Tester tester, const Triangle& triangle, const Ray& ray);

/// Where the ray meets the sphere, by the quadratic equation as it is taught: b^2 - 4 a c.
std::optional<float> meetsSphere(const Primitive& sphere, const Ray& ray);

/// The cells of an n x n x n grid in the box that a walk visits [Amanatides, Woo 1987].
enum class Dda {
    sound,      ///< in double precision
    single,     ///< in single precision, clamped, zeros handled
    unclamped,  ///< the cell of the entry point as rounded, which may lie outside
    noZeros,    ///< steps forwards where d >= 0, also for zeros
    reorigin,   ///< distances from the entry point, in single precision
};
struct Visit {
    uint32_t cell;
    double leave;  ///< the distance at which the walk leaves it
};
/// Nothing if it does not end within 4 n steps.
std::optional<std::vector<Visit>> cellsOf(Dda dda, const Box& box, uint32_t n, const Ray& ray);

/// A grid whose cells hold the triangles whose boxes meet them, as rounded, walked in single precision. Triangles are met in
/// double precision, and a hit counts if it lies in its cell; or, if `first`, the first one found anywhere.
class Grid {
public:
    Grid(const std::vector<Triangle>& triangles, uint32_t n);
    uint32_t closest(const Ray& ray, bool first) const;

private:
    const std::vector<Triangle>& triangles_;
    uint32_t n_;
    Box box_;
    std::vector<std::vector<uint32_t>> cells_;
};

/// The nearest triangle by a kd-tree that halves the longest axis down to cells of size 1: what lies in a plane belongs to
/// its lower side, and a side is visited only if the ray is in it for longer than a moment. NO_HIT if none is found.
uint32_t closestByKdTree(const std::vector<Triangle>& triangles, const Box& box, const Ray& ray);

}  // namespace raig::hard::naive
