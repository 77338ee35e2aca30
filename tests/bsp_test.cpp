// What is peculiar to the bsp: rays in and along its planes, triangles in their own planes, limits. Damaged and interrupted
// ones are in bsp_damage_test.cpp; the rest is structures_test.cpp, for every structure.
#include "structures/bsp.hpp"

#include "base/error.hpp"
#include "base/random.hpp"
#include "structures/bsp_plane.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"
#include "support/tracing.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace raig {
namespace {

using namespace test;

constexpr float inf = std::numeric_limits<float>::infinity();

void expectBrute(const std::vector<Triangle>& triangles, const std::vector<Ray>& rays, const BuildParams& params,
                 const std::string& what) {
    const std::vector<Hit> want = traceOnCpu(structureType("brute").build(triangles, {}), rays);
    const Structure structure = bsp::build(triangles, params);
    const std::vector<Hit> got = traceOnCpu(structure, rays), any = traceOnCpu(structure, rays, Query::any);
    for (size_t i = 0; i < rays.size(); ++i) {
        ASSERT_EQ(std::memcmp(&got[i], &want[i], sizeof(Hit)), 0)
            << what << " ray " << i << ' ' << test::describe(rays[i]) << "\n got " << got[i].primitive << ' ' << got[i].t
            << "\nwant " << want[i].primitive << ' ' << want[i].t;
        ASSERT_EQ(any[i].primitive == NO_HIT, want[i].primitive == NO_HIT) << what << ' ' << test::describe(rays[i]);
    }
}

/// Rays that lie in the planes of inner nodes, as nearly as floats allow, or start or end on them, or cross them at angles
/// down to 1e-9: from within the bounds or from `away` times their size, at points of the triangles or past them.
std::vector<Ray> raysAlongPlanes(const Structure& structure, size_t count, double away) {
    std::vector<bsp::Plane> planes;
    for (const uvec4& node : structure.nodes)
        if ((node.w & bsp::leafBit) == 0) planes.push_back(bsp::Plane::decoded(node));
    Random random(31);
    std::vector<Ray> rays;
    const dvec3 lo(structure.header.lo), size = dvec3(structure.header.hi) - lo;
    const double extent = std::max({size.x, size.y, size.z});
    for (size_t i = 0; i < count && !planes.empty(); ++i) {
        const bsp::Plane& plane = planes[random.below(static_cast<uint32_t>(planes.size()))];
        const dvec3 n = plane.normal();
        const auto onPlane = [&](dvec3 p) { return p - plane.to(p) / glm::dot(n, n) * n; };
        // A corner of a triangle, brought onto the plane, is a likely place for a hit.
        const uint32_t reference = random.below(structure.header.triangleCount);
        const Triangle t = referencedPrimitive(structure, reference);
        const dvec3 target = onPlane(glm::mix(dvec3(t.a), dvec3(t.b), random.below(2) == 0 ? 0.0 : random.unit()) - lo);
        dvec3 direction = glm::cross(n, random.direction());
        if (random.below(3) == 0) direction += std::pow(10.0, random.within(-9, -3)) * random.direction();
        if (random.below(4) == 0) direction = random.direction();
        const double from = away * extent * random.within(0.1, 1.0) / glm::length(direction);
        const vec3 origin = vec3((target - from * direction + lo) / double{structure.header.unit});
        Ray ray{origin, 0.0f, vec3(direction), inf};
        if (i % 3 == 1) ray = {vec3((target + lo) / double{structure.header.unit}), 0.0f, vec3(direction), inf};
        if (i % 7 == 1) {  // the interval ends, or begins, on the plane
            const double t = from / double{structure.header.unit};
            (random.below(2) == 0 ? ray.tMax : ray.tMin) = static_cast<float>(t);
        }
        rays.push_back(ray);
    }
    return rays;
}

// Hard cases 47, 48, 49: walls in splitting planes, rays in them, and planes where the ray's interval begins or ends.
TEST(Bsp, IsExactForRaysInItsPlanes) {
    for (const char* name : {"walls", "tilted walls", "pages", "fan", "ordinary", "slivers", "sphere", "duplicates", "far"})
        for (const uint32_t maxLeaf : {0u, 1u}) {
            const std::vector<Triangle> triangles = soupNamed(name);
            const BuildParams params{.maxLeaf = maxLeaf};
            for (const double away : {1.0, 30.0, 1e3, 1e6})
                expectBrute(triangles, raysAlongPlanes(bsp::build(triangles, params), test::affordable(2000), away), params,
                            fmt::format("{} from {}", name, away));
        }
}

// Hard case 37: the slack grows with the distance, until everything is tried.
TEST(Bsp, IsExactFromAfar) {
    const std::vector<Triangle> triangles = test::sphere(24, 1.0, dvec3(0.5, 0.25, -0.125), 0.2);
    Random random(5);
    for (const double away : {1e3, 1e4, 1e5, 1e6, 1e9}) {
        std::vector<Ray> rays;
        for (int i = 0; i < 500; ++i) {
            const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
            const dvec3 direction = random.direction();
            rays.push_back({vec3(dvec3(t.a) - away * direction), 0.0f, vec3(direction), inf});
        }
        expectBrute(triangles, rays, {}, fmt::format("from {}", away));
    }
}

// Hard cases 23, 44, 45: splitting stops where it does not help.
TEST(Bsp, ReferencesFewTrianglesMoreThanOnce) {
    const Triangle one{vec3(-0.5f, -0.5f, 0.0f), vec3(0.5f, -0.25f, 0.125f), vec3(0.0f, 0.5f, 0.25f)};
    std::vector<Triangle> sharing;
    Random random(11);
    for (int i = 0; i < 1000; ++i) sharing.push_back({vec3(0.1f, 0.2f, 0.3f), random.inCube(-1, 1), random.inCube(-1, 1)});
    for (const uint32_t maxLeaf : {0u, 1u, 8u})
        for (const auto& [name, triangles] :
             {std::pair{"identical", std::vector<Triangle>(1000, one)}, std::pair{"sharing a vertex", sharing}}) {
            const Structure structure = bsp::build(triangles, {.maxLeaf = maxLeaf});
            EXPECT_LE(structure.statistics.references, 20u * 1000u) << name << ' ' << maxLeaf;
            EXPECT_EQ(bsp::findFault(structure, triangles), std::nullopt) << name << ' ' << maxLeaf;
        }
    EXPECT_EQ(bsp::build(std::vector<Triangle>(1000, one), {}).statistics.references, 1000u);
}

bool isInner(const uvec4& node) {
    return (node.w & bsp::leafBit) == 0;
}

/// The references in the leaves below a node, in order.
std::vector<uint32_t> referencesBelow(const Structure& structure, uint32_t at) {
    std::vector<uint32_t> result;
    const uvec4& node = structure.nodes[at];
    if (isInner(node)) {
        const bool two = (node.w & (bsp::noBelowBit | bsp::noAboveBit)) == 0;
        for (uint32_t child = 0; child < (two ? 2u : 1u); ++child)
            for (const uint32_t reference : referencesBelow(structure, (node.w & bsp::indexBits) + child))
                result.push_back(reference);
    } else {
        for (uint32_t part = at;;) {
            const uvec4& leaf = structure.nodes[part];
            for (uint32_t i = 0; i < (leaf.w & 3); ++i) result.push_back(leaf[static_cast<int>(i)]);
            if ((leaf.w & bsp::moreBit) == 0) break;
            part = (leaf.w & bsp::linkedBit) != 0 ? leaf.z : part + 1;
        }
    }
    std::sort(result.begin(), result.end());
    result.erase(std::unique(result.begin(), result.end()), result.end());
    return result;
}

// A triangle in a splitting plane is on one side of it, tilted planes as well as others: or each would be in two leaves.
TEST(Bsp, PutsTrianglesOnOneSideOfTheirOwnPlane) {
    for (const char* name : {"walls", "tilted walls"}) {
        const std::vector<Triangle> triangles = soupNamed(name);
        const Structure structure = bsp::build(triangles, {.maxLeaf = 1});
        const dvec3 lo(structure.header.lo), size = dvec3(structure.header.hi) - lo;
        const double tolerance = bsp::tolerance * std::max({size.x, size.y, size.z});
        size_t inPlane = 0;
        for (uint32_t i = 0; i < structure.header.nodeCount; ++i) {
            const uvec4& node = structure.nodes[i];
            if (!isInner(node) || (node.w & (bsp::noBelowBit | bsp::noAboveBit)) != 0) continue;
            const bsp::Plane plane = bsp::Plane::decoded(node);
            const std::vector<uint32_t> below = referencesBelow(structure, node.w),
                                        above = referencesBelow(structure, node.w + 1);
            for (uint32_t r = 0; r < structure.header.triangleCount; ++r) {
                const Triangle t = referencedPrimitive(structure, r);
                const auto isIn = [&](const vec3& p) { return std::abs(plane.to(dvec3(p) - lo)) <= tolerance; };
                if (!isIn(t.a) || !isIn(t.b) || !isIn(t.c)) continue;
                const bool isBelow = std::binary_search(below.begin(), below.end(), r);
                const bool isAbove = std::binary_search(above.begin(), above.end(), r);
                EXPECT_FALSE(isBelow && isAbove) << name << " node " << i << " reference " << r;
                inPlane += isBelow || isAbove;
            }
        }
        EXPECT_GT(inPlane, 100u) << name << ": no triangle lies in a plane that has something on both sides";
    }
}

TEST(Bsp, KeepsToItsLimits) {
    const std::vector<Triangle> triangles = test::sphere(30, 1.0, dvec3(0), 0.1);
    const uint64_t least = triangles.size() * 48 + (1 + triangles.size() / 3) * 16;
    uint64_t before = 0;
    for (const uint64_t spare : {0u, 16u, 1000u, 10'000u, 100'000u}) {
        const Structure structure = bsp::build(triangles, {.memoryBudget = least + spare});
        EXPECT_LE(structure.statistics.bytes, least + spare);
        EXPECT_GE(structure.statistics.bytes, before) << spare;
        EXPECT_EQ(structure.remarks.size(), 1u) << spare;
        EXPECT_EQ(bsp::findFault(structure, triangles), std::nullopt) << spare;
        before = structure.statistics.bytes;
    }
    for (const uint32_t levels : {1u, 2u, 5u, 9u}) {
        const Structure structure = bsp::build(triangles, {.maxTreeDepth = levels});
        EXPECT_EQ(structure.statistics.depth, levels);
        EXPECT_EQ(bsp::findFault(structure, triangles), std::nullopt) << levels;
    }
    std::vector<Triangle> apart;
    for (int i = 0; i < 500; ++i)
        for (const Triangle& t : {triangles[7]})
            apart.push_back({t.a + vec3(3.0f * i), t.b + vec3(3.0f * i), t.c + vec3(3.0f * i)});
    for (const uint32_t maxLeaf : {1u, 4u, 100u})
        for (const uvec4& node : bsp::build(apart, {.maxLeaf = maxLeaf}).nodes)
            EXPECT_TRUE((node.w & bsp::leafBit) == 0 || (node.w & 3) <= maxLeaf);
    EXPECT_THROW(bsp::build(triangles, {.maxTreeDepth = 65}), Error);
    EXPECT_THROW(bsp::build(triangles, {.build = "sah"}), Error);
    EXPECT_THROW(bsp::build(triangles, {.levels = 2}), Error);
}

TEST(BspPlane, IsReadAsItIsWritten) {
    Random random(3);
    for (int i = 0; i < 1000; ++i) {
        const std::array<dvec3, 1> point = {random.direction()};
        const dvec3 normal = i < 3 ? dvec3(i == 0, i == 1, i == 2) : random.direction();
        const bsp::Plane plane = bsp::Plane::across(normal, point).value();
        const bsp::Plane read = bsp::Plane::decoded(plane.encoded(7));
        EXPECT_EQ(read.steps, plane.steps);
        EXPECT_EQ(read.distance, plane.distance);
        EXPECT_LE(std::abs(plane.steps[0]) + std::abs(plane.steps[1]) + std::abs(plane.steps[2]), 1 << 20);
        EXPECT_NEAR(plane.to(point[0]), 0.0, 1e-7);
        EXPECT_NEAR(glm::length(glm::cross(glm::normalize(plane.normal()), normal)), 0.0, 4e-6);
    }
    EXPECT_FALSE(bsp::Plane::across(dvec3(0), std::array{dvec3(1)}).has_value());
}

// Areas without the parts are those of the parts; and those of a box cut along its diagonal are known.
TEST(BspCell, HasPartsOfTheAreasForetold) {
    const bsp::Cell box(dvec3(1, 2, 3));
    EXPECT_DOUBLE_EQ(box.area(), 22.0);
    const auto diagonal = bsp::Plane::across(dvec3(2, -1, 0), std::array{dvec3(0), dvec3(1, 2, 3)}).value();
    const std::array<double, 2> halves = box.areas(diagonal);
    EXPECT_NEAR(halves[0], 11.0 + 3.0 * std::sqrt(5.0), 1e-4);
    EXPECT_NEAR(halves[1], 11.0 + 3.0 * std::sqrt(5.0), 1e-4);
    Random random(8);
    for (int round = 0; round < 50; ++round) {
        bsp::Cell cell = box;
        for (int level = 0; level < 12; ++level) {
            const std::array<dvec3, 1> point = {dvec3(random.inCube(0.2, 0.8)) * dvec3(1, 2, 3)};
            const bsp::Plane plane = bsp::Plane::across(random.direction(), point).value();
            const std::array<double, 2> areas = cell.areas(plane);
            const bsp::Cell below = cell.part(plane, -1), above = cell.part(plane, 1);
            EXPECT_NEAR(below.area(), areas[0], 1e-9);
            EXPECT_NEAR(above.area(), areas[1], 1e-9);
            EXPECT_GE(areas[0] + areas[1], cell.area() - 1e-9);
            cell = areas[0] > areas[1] ? below : above;
        }
    }
}

}  // namespace
}  // namespace raig
