// The triangle-box overlap test against points that are known exactly, and against clipping in quadruple precision.
#include "structures/triangle_box.hpp"
#include "base/random.hpp"

#include <gtest/gtest.h>

#include <array>
#include <vector>

namespace raig {
namespace {

struct Cell {
    dvec3 lo, hi;
};

/// A triangle with corners within 1 of `offset` that are multiples of 2^-bits: so the points below are exact.
Triangle gridTriangle(Random& random, double offset, int bits) {
    const double ones = std::ldexp(1.0, bits);
    const auto coordinate = [&] {
        return static_cast<float>(offset + (random.below(static_cast<uint32_t>(2.0 * ones) + 1) - ones) / ones);
    };
    const auto corner = [&] { return vec3(coordinate(), coordinate(), coordinate()); };
    return {corner(), corner(), corner()};
}

/// A corner, a point of an edge or of the inside, with weights that are sixteenths.
dvec3 exactPoint(const Triangle& t, Random& random) {
    const double i = random.below(17), j = random.below(17 - static_cast<uint32_t>(i));
    return (dvec3(t.a) * i + dvec3(t.b) * j + dvec3(t.c) * (16.0 - i - j)) / 16.0;
}

/// A box that has `p` on a face, an edge, at a corner, or inside, by chance for each axis.
Cell cellAt(const dvec3& p, Random& random) {
    Cell cell{p, p};
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t side = random.below(3);
        const double size = std::ldexp(1.0, -static_cast<int>(random.below(9)));
        cell.lo[axis] -= side == 0 ? 0.0 : size;
        cell.hi[axis] += side == 1 ? 0.0 : size;
    }
    return cell;
}

// Touching counts, in whatever way box and triangle do: 0 wrong answers.
TEST(TriangleBox, OverlapsWhereAPointIsSharedExactly) {
    Random random(1);
    for (const auto& [offset, bits] : {std::pair(0.0, 10), std::pair(0.0, 22), std::pair(100.0, 17), std::pair(4000.0, 12)})
        for (int i = 0; i < 200'000; ++i) {
            const Triangle t = gridTriangle(random, offset, bits);
            const Cell cell = cellAt(exactPoint(t, random), random);
            ASSERT_TRUE(PrimitiveBoxTest(t).overlaps(cell.lo, cell.hi)) << i << " at " << offset;
        }
}

/// The triangle cut by the box's six half-spaces: empty where there is no overlap. Sutherland and Hodgman 1974, "Reentrant
/// Polygon Clipping", in quadruple precision, whose roundings are far below the margins used here.
bool overlapsByClipping(const Triangle& t, const Cell& cell) {
    using Quad = __float128;
    using Point = std::array<Quad, 3>;
    std::vector<Point> polygon;
    for (const vec3& p : {t.a, t.b, t.c}) polygon.push_back({p.x, p.y, p.z});
    for (size_t axis = 0; axis < 3; ++axis)
        for (const int sign : {-1, 1}) {
            const Quad plane = sign < 0 ? -cell.lo[static_cast<int>(axis)] : cell.hi[static_cast<int>(axis)];
            const auto depth = [&](const Point& p) { return plane - Quad(sign) * p[axis]; };
            std::vector<Point> kept;
            for (size_t i = 0; i < polygon.size(); ++i) {
                const Point &from = polygon[i], &to = polygon[(i + 1) % polygon.size()];
                const Quad d0 = depth(from), d1 = depth(to);
                if (d0 >= 0) kept.push_back(from);
                if ((d0 < 0) == (d1 < 0)) continue;
                const Quad f = d0 / (d0 - d1);
                Point cut;
                for (size_t k = 0; k < 3; ++k) cut[k] = from[k] + f * (to[k] - from[k]);
                kept.push_back(cut);
            }
            polygon = std::move(kept);
            if (polygon.empty()) return false;
        }
    return true;
}

Triangle anyTriangle(Random& random) {
    const vec3 a = random.inCube(-1, 1);
    const double size = std::pow(10.0, random.within(-4, 0));
    const vec3 b = a + vec3(size * random.direction());
    if (random.below(4) == 0) return {a, b, vec3(dvec3(b) + 1e-6 * random.direction())};  // a sliver
    if (random.below(4) == 0) return {a, vec3(b.x, a.y, b.z), vec3(b.x, a.y, a.z)};       // flat along an axis
    return {a, b, a + vec3(size * random.direction())};
}

// Within one part in 10^9 of what clipping says, on both sides.
TEST(TriangleBox, AgreesWithClipping) {
    Random random(2);
    size_t overlapping = 0, between = 0;
    const int total = 200'000;
    for (int i = 0; i < total; ++i) {
        const Triangle t = anyTriangle(random);
        const double size = std::pow(10.0, random.within(-4, 0));
        const dvec3 centre = dvec3(t.a) + 0.5 * (size + glm::length(dvec3(t.b) - dvec3(t.a))) * dvec3(random.inCube(-1, 1));
        const Cell cell{centre - size * dvec3(random.inCube(0.1, 1)), centre + size * dvec3(random.inCube(0.1, 1))};
        const bool got = PrimitiveBoxTest(t).overlaps(cell.lo, cell.hi);
        const dvec3 margin(1e-9);
        ASSERT_TRUE(got || !overlapsByClipping(t, cell)) << i;
        ASSERT_TRUE(!got || overlapsByClipping(t, {cell.lo - margin, cell.hi + margin})) << i;
        overlapping += got;
        const bool boxesOverlap = glm::all(glm::lessThanEqual(dvec3(t.box().lo), cell.hi)) &&
                                  glm::all(glm::lessThanEqual(cell.lo, dvec3(t.box().hi)));
        between += boxesOverlap && !got;
    }
    // The pairs are of all kinds, those that only the ten further axes tell apart included.
    EXPECT_GT(overlapping, size_t{total} / 5);
    EXPECT_LT(overlapping, size_t{total} * 4 / 5);
    EXPECT_GT(between, size_t{total} / 100);
}

// Each of the ten axes beyond those of the boxes is needed: here only one separates.
TEST(TriangleBox, SeparatesAlongEachAxis) {
    const Cell unit{dvec3(-1), dvec3(1)};
    const Triangle corner{vec3(3.5f, 0, 0), vec3(0, 3.5f, 0),
                          vec3(0, 0, 3.5f)};  // x + y + z = 3.5 passes the corner (1, 1, 1)
    EXPECT_FALSE(PrimitiveBoxTest(corner).overlaps(unit.lo, unit.hi));
    EXPECT_TRUE(PrimitiveBoxTest(corner).overlaps(unit.lo, dvec3(1.25)));
    for (int axis = 0; axis < 3; ++axis)
        for (const float sx : {-1.0f, 1.0f})
            for (const float sy : {-1.0f, 1.0f}) {
                // An edge that passes an edge of the box, the one along `axis`, at a distance; the rest leans away from it.
                const auto turn = [&](float along, float x, float y) {
                    vec3 p;
                    p[axis] = along;
                    p[(axis + 1) % 3] = sx * x;
                    p[(axis + 2) % 3] = sy * y;
                    return p;
                };
                const std::array<vec3, 3> p = {turn(-0.5f, 2.5f, 0.0f), turn(0.5f, 0.0f, 2.5f), turn(0.75f, 2.5f, 2.5f)};
                for (size_t first = 0; first < 3; ++first) {
                    const PrimitiveBoxTest passing({p[first], p[(first + 1) % 3], p[(first + 2) % 3]});
                    EXPECT_FALSE(passing.overlaps(unit.lo, unit.hi));
                    EXPECT_TRUE(passing.overlaps(dvec3(-1.25), dvec3(1.25)));
                }
            }
}

}  // namespace
}  // namespace raig
