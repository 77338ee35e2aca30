// What is peculiar to grids: cells' faces, rays from far off, uneven scenes, references and memory. Nested ones are in
// grid_nested_test.cpp, damaged and interrupted ones in grid_damage_test.cpp.
#include "structures/grid.hpp"

#include "base/error.hpp"
#include "support/effort.hpp"
#include "support/grids.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using namespace test;

constexpr float inf = std::numeric_limits<float>::infinity();

/// Triangles in the faces of the cells of the grid that is built over them, or up to `ulps` away: hard cases 38 and 39. Two
/// triangles hold the bounds where they are.
std::vector<Triangle> wallsAtFaces(const std::vector<Triangle>& frame, uint32_t levels, int ulps, float density) {
    Random random(41);
    std::vector<Triangle> triangles = frame;
    const Structure first = gridOver(std::vector<Triangle>(300, frame.front()), levels, density);  // any shape near the last
    for (int i = 0; i < 400; ++i) {
        const auto axis = static_cast<int>(random.below(3));
        const vec3 at = vec3(placeOnCell(first, random));
        Triangle wall{at, vec3(placeOnCell(first, random)), vec3(placeOnCell(first, random))};
        for (vec3* corner : {&wall.a, &wall.b, &wall.c}) (*corner)[axis] = at[axis];
        const int by = static_cast<int>(random.below(2 * static_cast<uint32_t>(ulps) + 1)) - ulps;
        for (vec3* corner : {&wall.a, &wall.b, &wall.c})
            for (int k = 0; k < std::abs(by); ++k) (*corner)[axis] = std::nextafter((*corner)[axis], by < 0 ? -inf : inf);
        for (vec3* corner : {&wall.a, &wall.b, &wall.c})
            *corner = glm::clamp(*corner, frame.front().box().lo, frame.front().box().hi);
        triangles.push_back(wall);
    }
    return triangles;
}

TEST(Grid, FindsWhatBruteForceFindsAtFacesOfCells) {
    size_t hits = 0;
    for (const double offset : {0.0, 100.0, 1e5})
        for (const uint32_t levels : {1u, 2u})
            for (const float density : {0.3f, 4.0f}) {
                const vec3 at = vec3(dvec3(offset, -offset, 3.0 * offset));
                const std::vector<Triangle> frame = {{at, at + vec3(7, 7, 7), at + vec3(0, 7, 3)}};
                const std::vector<Triangle> walls = wallsAtFaces(frame, levels, 2, density);
                const Structure structure = gridOver(walls, levels, density);
                EXPECT_EQ(grid::findFault(structure, walls), std::nullopt);
                hits += expectAsBrute(structure, walls, raysAtCells(structure, walls, 5, test::affordable(6000)),
                                      fmt::format("{} levels at {}", levels, offset));
            }
    EXPECT_GT(hits, test::affordable(6000));
}

// Hard cases 32, 33, 34 and 36, among others.
TEST(Grid, FindsWhatBruteForceFindsFromFacesOfCells) {
    for (const test::Soup& soup : test::soups()) {
        if (soup.name == "none" || soup.name == "all unusable") continue;
        for (const uint32_t levels : {1u, 2u}) {
            const Structure structure = gridOver(soup.triangles, levels);
            expectAsBrute(structure, soup.triangles, raysAtCells(structure, soup.triangles, 6, test::affordable(2000)),
                          fmt::format("{}, {} levels", soup.name, levels));
        }
    }
}

// Hard case 37: from as near as the scene's size up to where it is smaller than the roundings. The grid has three ways to
// walk, which depend on the distance.
TEST(Grid, FindsWhatBruteForceFindsFromFarAway) {
    for (const test::Soup& soup : test::soups()) {
        if (soup.name == "none" || soup.name == "all unusable") continue;
        Box box;
        for (const Triangle& t : soup.triangles)
            if (t.usable()) box.grow(t.box());
        const double size = glm::length(dvec3(box.extent()));
        for (const uint32_t levels : {1u, 2u}) {
            const Structure structure = gridOver(soup.triangles, levels);
            Random random(7);
            for (const double distance : {1.0, 3.0, 6.0, 12.0, 25.0, 50.0, 100.0, 400.0, 1e3, 5e3, 1e4, 2e4, 1e5, 1e6}) {
                std::vector<Ray> rays;
                for (size_t i = 0; i < test::affordable(150); ++i) {
                    const Triangle& t = soup.triangles[random.below(static_cast<uint32_t>(soup.triangles.size()))];
                    if (!t.usable()) continue;
                    dvec3 target = i % 3 == 0   ? dvec3(t.a)
                                   : i % 3 == 1 ? glm::mix(dvec3(t.b), dvec3(t.c), random.unit())
                                                : placeOnCell(structure, random);
                    dvec3 direction = random.direction();
                    if (i % 5 == 0) direction = dvec3(i % 2, 1 - i % 2, 0.0);
                    const vec3 origin = vec3(target - direction * size * distance * random.within(0.7, 1.4));
                    rays.push_back({origin, 0.0f, vec3(target - dvec3(origin)), inf});
                    if (i % 7 == 0) rays.back().tMin = 1.0f;  // begins, or ends, at the target
                    if (i % 7 == 1) rays.back().tMax = 1.0f;
                }
                expectAsBrute(structure, soup.triangles, rays,
                              fmt::format("{}, {} levels, from {}", soup.name, levels, distance));
            }
        }
    }
}

// Hard cases 42, 44 and 45 for grids.
TEST(Grid, KeepsReferencesFew) {
    Random random(3);
    const vec3 shared(0.1f, 0.2f, 0.3f);
    std::vector<Triangle> fan, slivers, big;
    for (int i = 0; i < 1000; ++i) {
        fan.push_back({shared, random.inCube(-1, 1), random.inCube(-1, 1)});
        const vec3 a = random.inCube(-1, 1), b = random.inCube(-1, 1);
        slivers.push_back({a, b, vec3(dvec3(b) + 1e-6 * random.direction())});
        big.push_back({random.inCube(-1, 1), random.inCube(-1, 1), random.inCube(-1, 1)});
    }
    const std::vector<test::Soup> soups = {
        {"identical", std::vector<Triangle>(1000, fan[0])}, {"fan", fan}, {"slivers", slivers}, {"big", big}};
    for (const test::Soup& soup : soups)
        for (const uint32_t levels : {0u, 1u, 2u}) {
            const Structure structure = gridOver(soup.triangles, levels);
            EXPECT_LE(structure.statistics.references, 20 * soup.triangles.size()) << soup.name << ' ' << levels;
            EXPECT_EQ(grid::findFault(structure, soup.triangles), std::nullopt) << soup.name << ' ' << levels;
        }
}

TEST(Grid, KeepsWithinTheMemoryBudget) {
    const std::vector<Triangle> sphere = test::sphere(100, 1.0, dvec3(0), 0.1);
    const uint64_t triangleBytes = sphere.size() * 48;
    for (const uint32_t levels : {1u, 2u})
        for (const float density : {0.0f, 1000.0f}) {
            uint64_t previous = 0;
            for (const double share : {1.2, 1.5, 2.0, 4.0, 16.0}) {
                const auto budget = static_cast<uint64_t>(share * static_cast<double>(triangleBytes));
                const Structure structure =
                    grid::build(sphere, {.gridDensity = density, .levels = levels, .memoryBudget = budget});
                EXPECT_LE(structure.statistics.bytes, budget) << share;
                EXPECT_EQ(structure.statistics.bytes, (structure.nodes.size() + structure.triangles.size()) * 16);
                EXPECT_GE(structure.statistics.bytes, previous) << share;
                previous = structure.statistics.bytes;
            }
        }
}

// Hard cases 30 and 43.
TEST(Grid, HoldsFlatScenesAndSingleTriangles) {
    Random random(5);
    for (int axis = -1; axis < 3; ++axis) {  // -1: one triangle
        std::vector<Triangle> triangles;
        for (int i = 0; i < (axis < 0 ? 1 : 2000); ++i) {
            const vec3 at = random.inCube(-1, 1);
            triangles.push_back({at, at + 0.1f * random.inCube(-1, 1), at + 0.1f * random.inCube(-1, 1)});
            if (axis >= 0)
                for (vec3* corner : {&triangles.back().a, &triangles.back().b, &triangles.back().c}) (*corner)[axis] = 0.3f;
        }
        for (const uint32_t levels : {1u, 2u}) {
            const Structure structure = gridOver(triangles, levels);
            EXPECT_EQ(grid::findFault(structure, triangles), std::nullopt);
            std::vector<Ray> rays = raysAtCells(structure, triangles, 8, 1000);
            for (const Ray& ray : test::rays(triangles, 9, 1000)) rays.push_back(ray);
            EXPECT_GT(expectAsBrute(structure, triangles, rays, fmt::format("flat along {}", axis)), 100u);
        }
    }
}

TEST(Grid, RefusesWhatItDoesNotOffer) {
    EXPECT_THROW(grid::build({}, {.levels = 3}), Error);
    EXPECT_THROW(grid::build({}, {.maxLeaf = 4}), Error);
    EXPECT_THROW(grid::build({}, {.build = "sah"}), Error);
}

}  // namespace
}  // namespace raig
