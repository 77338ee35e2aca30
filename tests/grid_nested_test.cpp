// Nested grids: parts of cells that are divided again, where they help and where they do not.
#include "rays/frame.hpp"
#include "rays/tracer.hpp"
#include "scene/import.hpp"
#include "structures/grid.hpp"
#include "structures/grid_shape.hpp"
#include "support/effort.hpp"
#include "support/grids.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <cstring>
#include <filesystem>

namespace raig {
namespace {

using namespace test;

constexpr float inf = std::numeric_limits<float>::infinity();

/// A crowded cell's parts, in the scene's own unit of length, and how far away rays may start that are walked through them.
struct Block {
    dvec3 lo, step;
    uvec3 count;
    double reach;
};

void addBlocks(const Structure& structure, const grid::Shape& shape, uint32_t word, const grid::Place& place,
               std::vector<Block>& blocks) {
    if ((word & grid::crowdedBit) == 0) return;
    const auto wordAt = [&](uint64_t i) { return structure.nodes[i / 4][static_cast<int>(i % 4)]; };
    const uint32_t more = word >> 28 & 7;
    const grid::Lattice parts = shape.parts(place, more);
    const double unit = structure.header.unit;
    blocks.push_back({parts.origin / unit, parts.step / unit, parts.count, shape.reachOf(parts) / unit});
    for (size_t i = 0; i < parts.cells(); ++i)
        addBlocks(structure, shape, wordAt((word & 0x0fffffffu) * uint64_t{8} + grid::firstCell + i),
                  shape.part(place, more, i), blocks);
}

std::vector<Block> blocksOf(const Structure& structure) {
    const grid::Shape shape = grid::shapeOf(structure);
    std::vector<Block> blocks;
    for (size_t i = 0; i < shape.cells.cells(); ++i)
        addBlocks(structure, shape, structure.nodes[(grid::firstCell + i) / 4][static_cast<int>(i % 4)], shape.cell(i),
                  blocks);
    return blocks;
}

/// A corner of a part, or a point of an edge or a face.
dvec3 placeOnPart(const Block& block, Random& random) {
    dvec3 place;
    for (int axis = 0; axis < 3; ++axis)
        place[axis] = block.lo[axis] + block.step[axis] * (random.below(3) == 0 ? random.unit() * block.count[axis]
                                                                                : random.below(block.count[axis] + 1));
    return place;
}

/// Rays at and from such places and corners and edges of triangles; from within them, just inside and outside of their
/// reach, and from anywhere; along axes with zeros of both signs; and along triangles, seen edge-on.
std::vector<Ray> raysAtParts(const std::vector<Block>& blocks, const std::vector<Triangle>& triangles, size_t count) {
    Random random(52);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const Block& block = blocks[random.below(static_cast<uint32_t>(blocks.size()))];
        const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
        const dvec3 extent = block.step * dvec3(block.count), middle = block.lo + 0.5 * extent;
        dvec3 target = placeOnPart(block, random);
        if (rays.size() % 3 == 1) target = glm::mix(dvec3(t.a), dvec3(t.b), random.below(2) == 0 ? 0.0 : random.unit());
        dvec3 origin = placeOnPart(block, random);
        const dvec3 direction = random.direction();
        const double largest = std::max({std::abs(direction.x), std::abs(direction.y), std::abs(direction.z)});
        const double most = std::max({extent.x, extent.y, extent.z});
        if (rays.size() % 4 == 1)
            origin = middle + direction * (block.reach - 0.5 * most) * random.within(0.99, 1.01) / largest;
        if (rays.size() % 4 == 2) origin = target + direction * most * std::exp2(random.within(-12.0, 12.0));
        if (rays.size() % 4 == 3) origin = target + (dvec3(t.b) - dvec3(t.a)) * std::exp2(random.within(-2.0, 6.0));
        Ray ray{vec3(origin), 0.0f, vec3(target - dvec3(vec3(origin))), inf};
        if (rays.size() % 5 == 0) {
            const auto axis = static_cast<int>(random.below(3));
            for (int k = 0; k < 3; ++k)
                if (k != axis) ray.direction[k] = random.below(2) == 0 ? 0.0f : -0.0f;
            if (ray.direction[axis] == 0.0f) ray.direction[axis] = 1.0f;
        }
        rays.push_back(ray);
    }
    return rays;
}

TEST(Grid, FindsWhatBruteForceFindsInPartsOfParts) {
    for (const dvec3& centre : {dvec3(0.0), dvec3(3.0, 0.1, -5.0), dvec3(700.0, 0.3, 800.0)}) {
        const std::vector<Triangle> triangles = stadium(centre.x > 100 ? 0.5 : 0.05, centre);
        const Structure structure = gridOver(triangles, 2);
        ASSERT_EQ(structure.header.walk, grid::nestedWalk);
        EXPECT_EQ(grid::findFault(structure, triangles), std::nullopt);
        const std::vector<Ray> rays = raysAtParts(blocksOf(structure), triangles, test::isLong() ? 200'000 : 4'000);
        EXPECT_GT(expectAsBrute(structure, triangles, rays, fmt::format("stadium at {}", centre.x)), rays.size() / 4);
        std::vector<Hit> want(rays.size());
        makeCpuTracer(structure)->trace(rays, want, Query::closest);
        for (const uint32_t maxSteps : {1u, 5u}) {
            const std::vector<Hit> got = walkInPieces(structure, rays, maxSteps);
            EXPECT_EQ(std::memcmp(got.data(), want.data(), want.size() * sizeof(Hit)), 0) << maxSteps;
        }
    }
}

// As they are in instances, where one kernel walks all.
TEST(Grid, FindsWhatBruteForceFindsWhereItNestsForNothing) {
    for (const test::Soup& soup : test::soups()) {
        if (soup.name == "none" || soup.name == "all unusable") continue;
        const Structure structure = grid::build(soup.triangles, {.levels = 2, .nestsGrids = true});
        ASSERT_EQ(structure.header.walk, grid::nestedWalk);
        EXPECT_EQ(grid::findFault(structure, soup.triangles), std::nullopt) << soup.name;
        std::vector<Ray> rays = raysAtCells(structure, soup.triangles, 8, 700);
        for (const Ray& ray : test::rays(soup.triangles, 9, 700)) rays.push_back(ray);
        const std::vector<Block> blocks = blocksOf(structure);
        if (!blocks.empty())
            for (const Ray& ray : raysAtParts(blocks, soup.triangles, 700)) rays.push_back(ray);
        expectAsBrute(structure, soup.triangles, rays, soup.name + ", nested");
    }
}

/// Triangles tested a ray.
double testsOf(const Structure& structure, const std::vector<Ray>& rays) {
    std::vector<Hit> hits(rays.size());
    const TraceReport report = makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    return static_cast<double>(report.counters.triangleTests) / static_cast<double>(rays.size());
}

// Hard case 41, the real one: a bunny of 70,000 triangles in a house in a field of 1800 m, where a triangle is half a
// millimetre long and roundings are several.
TEST(Grid, TestsFewTrianglesOfABunnyInAHouseInAField) {
    const std::filesystem::path file =
        std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/stadium/house_and_bunny.glb";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no scene at " << file;
    const Scene scene = importScene(file);
    const Geometry geometry = flatten(scene);
    std::vector<Triangle> triangles;
    for (const uvec3& t : geometry.triangles)
        triangles.push_back({geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]});
    const Structure structure = gridOver(triangles, 2);
    const std::vector<Ray> camera = cameraRays(scene, {.width = 512, .height = 512});
    Random random(53);
    std::vector<Ray> near, far;  // at the bunny
    const uint32_t first = geometry.firstTriangle[1], count = geometry.firstTriangle[2] - first;
    while (near.size() < 10'000) {
        const Triangle& t = triangles[first + random.below(count)];
        const dvec3 target = 0.5 * dvec3(t.a) + 0.3 * dvec3(t.b) + 0.2 * dvec3(t.c), direction = random.direction();
        for (const double distance : {random.within(0.001, 0.3), random.within(0.3, 5.0)}) {
            const vec3 origin = vec3(target - distance * direction);
            (distance < 0.3 ? near : far).push_back({origin, 0.0f, vec3(target - dvec3(origin)), inf});
        }
    }
    std::vector<Ray> some;
    for (size_t i = 0; i < camera.size(); i += 13) some.push_back(camera[i]);
    EXPECT_LE(testsOf(structure, some), 20.0) << "of the file's camera";
    EXPECT_LE(testsOf(structure, near), 20.0) << "at the bunny from up to 0.3";
    EXPECT_LE(testsOf(structure, far), 20.0) << "at the bunny from up to 5";
    // All structures' hits are brute force's; trying every triangle takes long.
    const Structure other = structureType("bvh").build(triangles, {});
    for (const std::vector<Ray>* rays : {&some, &near, &far}) {
        const std::vector<Ray> few(rays->begin(), rays->begin() + 2000);
        std::vector<Hit> want(few.size()), got(few.size());
        makeCpuTracer(other)->trace(few, want, Query::closest);
        makeCpuTracer(structure)->trace(few, got, Query::closest);
        EXPECT_EQ(std::memcmp(got.data(), want.data(), want.size() * sizeof(Hit)), 0);
    }
}

}  // namespace
}  // namespace raig
