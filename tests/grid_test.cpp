// What is peculiar to grids: cells' faces, rays from far off, uneven scenes, and structures that are damaged.
#include "structures/grid.hpp"

#include "base/error.hpp"
#include "rays/frame.hpp"
#include "rays/tracer.hpp"
#include "scene/import.hpp"
#include "structures/grid_shape.hpp"
#include "support/effort.hpp"
#include "support/random.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <filesystem>

namespace raig {
namespace {

using test::Random;

constexpr float inf = std::numeric_limits<float>::infinity();

/// The walk of the grid at so many levels as C++, to be stopped and taken up again at will.
namespace walks {
using namespace glm;
using namespace shared;
#define COUNT_NODE(did)
#define COUNT_TRIANGLE(did)
struct Arrays {
    static constexpr bool HAS_SPHERES = true;
    explicit Arrays(const Structure& structure) : header(structure.header), structure_(structure) {}
    uvec4 nodes_at(uint i) const { return structure_.nodes.at(i); }
    uvec4 triangles_at(uint i) const { return structure_.triangles.at(i); }
    const StructureHeader& header;
    const Structure& structure_;
};

template <uint WALK, bool ANY_HIT, bool SKIP_SEE_THROUGH>
struct Walk : Arrays {
    using Arrays::Arrays;
#include "intersect.glsl"
#include "structures/grid.glsl"
#include "trace.glsl"
#include "triangles.glsl"
};
#undef HAS_WALK

/// The same of nested grids.
template <bool ANY_HIT, bool SKIP_SEE_THROUGH>
struct Walk<2u, ANY_HIT, SKIP_SEE_THROUGH> : Arrays {
    static constexpr uint WALK = 2u;
    using Arrays::Arrays;
#include "intersect.glsl"
#include "structures/grid_nested.glsl"
#include "trace.glsl"
#include "triangles.glsl"
};
}  // namespace walks

Structure gridOver(const std::vector<Triangle>& triangles, uint32_t levels, float density = 0.0f) {
    return grid::build(triangles, {.gridDensity = density, .levels = levels});
}

/// Expects that the grid finds what brute force does, by bits, and returns how many rays hit something.
size_t expectAsBrute(const Structure& structure, const std::vector<Triangle>& triangles, const std::vector<Ray>& rays,
                     const std::string& what) {
    const Structure brute = structureType("brute").build(triangles, {});
    std::vector<Hit> want(rays.size()), got(rays.size()), any(rays.size());
    makeCpuTracer(brute)->trace(rays, want, Query::closest);
    makeCpuTracer(structure)->trace(rays, got, Query::closest);
    makeCpuTracer(structure)->trace(rays, any, Query::any);
    size_t hits = 0, wrong = 0;
    for (size_t i = 0; i < rays.size(); ++i) {
        hits += want[i].primitive != NO_HIT;
        const bool same = std::memcmp(&want[i], &got[i], sizeof(Hit)) == 0 &&
                          (any[i].primitive == NO_HIT) == (want[i].primitive == NO_HIT);
        if (!same && wrong++ == 0)
            ADD_FAILURE() << what << " ray " << i << ' ' << test::describe(rays[i]) << " finds " << got[i].primitive
                          << " at " << got[i].t << " and should find " << want[i].primitive << " at " << want[i].t;
    }
    EXPECT_EQ(wrong, 0u) << what << ", of " << rays.size();
    return hits;
}

/// A corner of a cell of the grid, or of a part that a cell may have, in the scene's unit of length; or a point of such an
/// edge or face.
dvec3 placeOnCell(const Structure& structure, Random& random) {
    const grid::Shape shape = grid::shapeOf(structure);
    const uint32_t parts = structure.header.walk == 0 ? 1 : 4;
    dvec3 place;
    for (int axis = 0; axis < 3; ++axis) {
        const double number = random.below(shape.cells.count[axis] * parts + 1) / double(parts);
        place[axis] = shape.cells.origin[axis] + shape.cells.step[axis] * number;
    }
    for (uint32_t free = random.below(3); free > 0; --free) {
        const auto axis = static_cast<int>(random.below(3));
        place[axis] = shape.cells.origin[axis] + shape.cells.step[axis] * shape.cells.count[axis] * random.unit();
    }
    return place / double(structure.header.unit);
}

/// Rays along faces and edges of cells, through their corners, and from them; with zeros of both signs.
std::vector<Ray> raysAtCells(const Structure& structure, const std::vector<Triangle>& triangles, uint64_t seed,
                             size_t count) {
    Random random(seed);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const vec3 from = vec3(placeOnCell(structure, random)), to = vec3(placeOnCell(structure, random));
        const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
        Ray ray{from, 0.0f, to - from, inf};
        switch (rays.size() % 4) {
            case 0:  // through two places
                ray.origin = vec3(2.0 * dvec3(from) - dvec3(to));
                break;
            case 1:  // from one at a triangle
                ray.direction = t.a + 0.25f * (t.b - t.a) - from;
                break;
            case 2:  // within a face, or along an edge
                for (uint32_t zeros = 1 + random.below(2); zeros > 0; --zeros)
                    ray.direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 0.0f : -0.0f;
                break;
            default:  // along an axis, from a face or outside
                for (int axis = 0; axis < 3; ++axis) ray.direction[axis] = random.below(2) == 0 ? 0.0f : -0.0f;
                ray.direction[static_cast<int>(random.below(3))] = random.below(2) == 0 ? 1.0f : -1.0f;
                if (random.below(2) == 0) ray.origin -= ray.direction * glm::length(to - from);
                break;
        }
        rays.push_back(ray);
    }
    return rays;
}

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

template <uint32_t walkNumber>
std::vector<Hit> walkInPieces(const Structure& structure, const std::vector<Ray>& rays, uint32_t maxSteps) {
    walks::Walk<walkNumber, false, false> walk(structure);
    std::vector<Hit> hits(rays.size(), {0.0f, 0.0f, 0.0f, NO_HIT});
    for (size_t i = 0; i < rays.size(); ++i) {
        uvec4 at(0u);
        uint32_t pieces = 1;
        while (!walk.traceRay(rays[i], at, maxSteps, hits[i]))
            if (++pieces == 1'000'000) {
                ADD_FAILURE() << "does not end: " << test::describe(rays[i]);
                break;
            }
    }
    return hits;
}

/// As far as a walk may go that ends.
template <uint32_t walkNumber>
void walkAsFarAsMaybe(const Structure& structure, const std::vector<Ray>& rays) {
    walks::Walk<walkNumber, false, false> walk(structure);
    for (const Ray& ray : rays) {
        uvec4 at(0u);
        Hit hit{0.0f, 0.0f, 0.0f, NO_HIT};
        walk.traceRay(ray, at, static_cast<uint32_t>(walk.mostSteps()), hit);
    }
}

/// Small things in a large place: a sphere of 6000 triangles of which 10^4 would fit across the scene; around it slivers and
/// triangles of every size, all in one cell.
std::vector<Triangle> stadium(double size, const dvec3& centre) {
    Random random(51);
    std::vector<Triangle> triangles = test::sphere(55, size, centre, 0.1);
    for (const float y : {-0.3f, 2.0f}) {
        triangles.push_back({vec3(-1000, y, -1000), vec3(1000, y, -1000), vec3(1000, y, 1000)});
        triangles.push_back({vec3(-1000, y, -1000), vec3(1000, y, 1000), vec3(-1000, y, 1000)});
    }
    for (int i = 0; i < 600; ++i) {
        const double extent = size * std::exp2(random.within(-8.0, 8.0));
        const dvec3 at = centre + 2.0 * size * dvec3(random.inCube(-1, 1)), a = random.direction(), b = random.direction();
        triangles.push_back({vec3(at), vec3(at + extent * a), vec3(at + extent * (i % 2 == 0 ? 1.001 * a + 1e-6 * b : b))});
    }
    return triangles;
}

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
        addBlocks(structure, shape, structure.nodes[(grid::firstCell + i) / 4][static_cast<int>(i % 4)], shape.cell(i), blocks);
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

/// Rays at and from such places and corners and edges of triangles; from within them, just inside and outside of their reach,
/// and from anywhere; along axes with zeros of both signs; and along triangles, seen edge-on.
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
        if (rays.size() % 4 == 1) origin = middle + direction * (block.reach - 0.5 * most) * random.within(0.99, 1.01) / largest;
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
            const std::vector<Hit> got = walkInPieces<2>(structure, rays, maxSteps);
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
    const std::filesystem::path file = std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/stadium/house_and_bunny.glb";
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

TEST(Grid, GoesOnWhereItWasStopped) {
    for (const test::Soup& soup : test::soups()) {
        std::vector<Ray> rays = test::rays(soup.triangles, 31, test::affordable(800));
        for (size_t i = 0; i < rays.size(); i += 5)
            rays[i].origin = vec3(dvec3(rays[i].origin) - 300.0 * dvec3(rays[i].direction));  // some from far off
        const Structure one = gridOver(soup.triangles, 1), two = gridOver(soup.triangles, 2);
        std::vector<Hit> want(rays.size());
        makeCpuTracer(one)->trace(rays, want, Query::closest);
        for (const uint32_t maxSteps : {1u, 2u, 7u}) {
            const std::vector<Hit> gotOne = walkInPieces<0>(one, rays, maxSteps);
            const std::vector<Hit> gotTwo =
                two.header.walk == 1 ? walkInPieces<1>(two, rays, maxSteps) : walkInPieces<2>(two, rays, maxSteps);
            EXPECT_EQ(std::memcmp(gotOne.data(), want.data(), want.size() * sizeof(Hit)), 0) << soup.name;
            EXPECT_EQ(std::memcmp(gotTwo.data(), want.data(), want.size() * sizeof(Hit)), 0) << soup.name;
        }
    }
}

// Whatever stands in cells and lists, a walk reads nothing outside (nodes.at() would throw), and ends, or goes on beyond
// what any of a sound grid does, which tracers notice.
TEST(Grid, StaysInTheArraysOfADamagedStructure) {
    const std::vector<Triangle> triangles = test::soups()[4].triangles;
    const std::vector<Ray> rays = test::rays(triangles, 32, 200);
    Random random(33);
    for (size_t damage = 0; damage < test::affordable(30); ++damage) {
        Structure one = gridOver(triangles, 1), two = gridOver(triangles, 2);
        Structure nested = grid::build(triangles, {.levels = 2, .nestsGrids = true});
        for (Structure* structure : {&one, &two, &nested})
            for (size_t i = 2; i < structure->nodes.size(); ++i)
                for (int k = 0; k < 4; ++k)
                    if (random.below(damage % 2 == 0 ? 3 : 300) == 0)
                        structure->nodes[i][k] = static_cast<uint32_t>(random.bits() >> random.below(32));
        EXPECT_NO_THROW(walkAsFarAsMaybe<0>(one, rays));
        EXPECT_NO_THROW(walkAsFarAsMaybe<2>(nested, rays));
        ASSERT_EQ(two.header.walk, 1u);
        EXPECT_NO_THROW(walkAsFarAsMaybe<1>(two, rays));
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

class Damaged : public testing::Test {
protected:
    uint32_t& word(uint64_t index) { return structure.nodes[index / 4][static_cast<int>(index % 4)]; }
    uint64_t lists() const { return uint64_t{structure.nodes[1].x} * 4; }
    void expectFault(const std::string& part) {
        const auto fault = grid::findFault(structure, triangles);
        ASSERT_TRUE(fault.has_value()) << part;
        EXPECT_NE(fault->find(part), std::string::npos) << *fault;
        structure = whole;
    }
    /// A crowded cell's word.
    uint64_t crowded(uint32_t after = 0) {
        const uvec4 n = structure.nodes[0];
        for (uint64_t i = 8; i < 8 + uint64_t{n.x} * n.y * n.z; ++i)
            if ((word(i) & grid::crowdedBit) != 0 && after-- == 0) return i;
        ADD_FAILURE() << "no cell is crowded";
        return 8;
    }

    std::vector<Triangle> triangles = test::sphere(40, 1.0, dvec3(0), 0.1);
    const Structure whole = gridOver(triangles, 2, 0.1f);
    Structure structure = whole;
};

TEST_F(Damaged, IsFound) {
    ASSERT_EQ(grid::findFault(structure, triangles), std::nullopt);
    structure.triangles[3] = structure.triangles[0];
    expectFault("twice");
    std::swap(structure.triangles[0].w, structure.triangles[3].w);
    expectFault("other corners");
    structure.triangles.resize(structure.triangles.size() - 3);
    expectFault("triangle count");
    structure.header.hi.z *= 0.5f;
    expectFault("bounds");
    structure.header.gridStep.x *= 1.0000002f;
    expectFault("rounded");
    structure.header.gridOrigin.y += 0.01f;
    expectFault("sticks out");
    structure.nodes[0].w = std::bit_cast<uint32_t>(2.0f * std::bit_cast<float>(structure.nodes[0].w));
    expectFault("");
    structure.nodes[1].y += 8;
    expectFault("differ in size");
    word(lists()) &= ~grid::lastBit;
    word(lists() + 1) = 0;
    expectFault("");
    word(lists()) = triangles.size() + 7u;
    expectFault("not there");
    word(crowded() + 0) = 0;  // all that is in the cell is forgotten
    expectFault("does not list");
    word(crowded()) = word((word(crowded()) & 0x0fffffffu) * 8);  // legitimate: the cell is just not divided
    EXPECT_EQ(grid::findFault(structure, triangles), std::nullopt);
    structure = whole;
    word(crowded()) = word(crowded(1));
    expectFault("");
    word(crowded()) += 0x00100000u;
    expectFault("lie");
    word(crowded()) &= 0x8fffffffu;
    expectFault("divided as it may not be");
    for (uint64_t part = (word(crowded()) & 0x0fffffffu) * uint64_t{8} + 8, done = 0; done == 0; ++part) {
        if (word(part) == 0) continue;
        word(part) = 0;
        done = 1;
    }
    expectFault("does not list");
    word(lists() + structure.nodes[1].y - 1) &= ~grid::lastBit;
    expectFault("does not end");
    for (uint64_t at = lists();; ++at) {  // two references of one list change places
        if ((word(at) & grid::lastBit) != 0 || (word(at + 1) & grid::lastBit) != 0) continue;
        std::swap(word(at), word(at + 1));
        break;
    }
    expectFault("not in order");
}

TEST(Grid, FindsDamageInPartsOfParts) {
    const std::vector<Triangle> triangles = stadium(0.05, dvec3(3.0, 0.1, -5.0));
    const Structure whole = gridOver(triangles, 2);
    ASSERT_EQ(grid::findFault(whole, triangles), std::nullopt);
    Structure structure = whole;
    const auto word = [&](uint64_t i) -> uint32_t& { return structure.nodes[i / 4][static_cast<int>(i % 4)]; };
    const auto crowdedFrom = [&](uint64_t begin) {
        while ((word(begin) & grid::crowdedBit) == 0) ++begin;
        return begin;
    };
    const auto expectFault = [&](const std::string& part) {
        const auto fault = grid::findFault(structure, triangles);
        ASSERT_TRUE(fault.has_value()) << part;
        EXPECT_NE(fault->find(part), std::string::npos) << *fault;
        structure = whole;
    };
    const uint64_t cell = crowdedFrom(grid::firstCell), cells = grid::shapeOf(whole).cells.cells() + grid::firstCell;
    const uint64_t part = crowdedFrom(cells);  // of the first block, or one after it
    ASSERT_LT(part, uint64_t{whole.nodes[1].x} * 4);
    const uint64_t block = (word(part) & 0x0fffffffu) * uint64_t{8};
    word((word(cell) & 0x0fffffffu) * uint64_t{8} + 1) += 1;
    expectFault("reach");
    word(block + 1) = std::bit_cast<uint32_t>(1e30f);
    expectFault("reach");
    for (uint64_t i = block + grid::firstCell; i > 0; ++i)
        if (word(i) != 0) {
            word(i) = 0;
            break;
        }
    expectFault("does not list");
    word(part) = grid::crowdedBit | 1u << 28 | (word(cell) & 0x0fffffffu);  // goes around
    expectFault("");
    word(part) = word(block);  // legitimate: the part is just not divided
    EXPECT_EQ(grid::findFault(structure, triangles), std::nullopt);
}

TEST(Grid, RefusesWhatItDoesNotOffer) {
    EXPECT_THROW(grid::build({}, {.levels = 3}), Error);
    EXPECT_THROW(grid::build({}, {.maxLeaf = 4}), Error);
    EXPECT_THROW(grid::build({}, {.build = "sah"}), Error);
}

}  // namespace
}  // namespace raig
