#include "base/error.hpp"
#include "structures/structure.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"
#include "support/tracing.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <cstring>

namespace raig {
namespace {

using test::sameBits;
using test::Soup;
using test::traceOnCpu;
using test::Variant;

class EveryStructure : public testing::TestWithParam<Variant> {
protected:
    Structure build(const Soup& soup) const { return GetParam().build(soup.triangles); }
};

TEST_P(EveryStructure, KeepsItsInvariants) {
    for (const Soup& soup : test::soups()) {
        const Structure structure = build(soup);
        EXPECT_EQ(structureType(GetParam().structure).findFault(structure, soup.triangles), std::nullopt) << soup.name;
    }
}

// From so far away that rounding there is as large as the scene, a ray meets every box: the walk must end all the same.
TEST_P(EveryStructure, IsWalkedFromVeryFarAway) {
    const Soup soup{"sphere", test::sphere(20, 1.0, dvec3(0), 0.1)};
    const Structure structure = build(soup);
    const Structure brute = structureType("brute").build(soup.triangles, {});
    for (const double distance : {1e3, 1e6, 1e7, 1e9, 1e15}) {
        std::vector<Ray> rays;
        for (uint32_t octant = 0; octant < 8; ++octant) {
            const dvec3 from(octant & 1 ? 1 : -0.7, octant & 2 ? 0.9 : -1, octant & 4 ? 0.8 : -1.1);
            rays.push_back({vec3(from * distance), 0.0f, vec3(-from), std::numeric_limits<float>::infinity()});
        }
        const std::vector<Hit> want = traceOnCpu(brute, rays, Query::closest);
        const std::vector<Hit> got = traceOnCpu(structure, rays, Query::closest);
        for (size_t i = 0; i < rays.size(); ++i) EXPECT_TRUE(sameBits(got[i], want[i])) << distance << " octant " << i;
    }
}

void expectTheSameForAnyNumberOfThreads(const Variant& variant, uint32_t rings) {
    const std::vector<Triangle> triangles = test::sphere(rings, 1.0, dvec3(0), 0.1);
    std::vector<Structure> built;
    for (size_t threads : {1, 2, 5}) {
        if (test::slowdown > 1 && threads == 2) continue;
        const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, threads);
        built.push_back(variant.build(triangles));
        EXPECT_EQ(built.back().nodes, built.front().nodes) << threads;
        EXPECT_EQ(built.back().triangles, built.front().triangles) << threads;
    }
}

TEST_P(EveryStructure, IsTheSameForAnyNumberOfThreads) {
    expectTheSameForAnyNumberOfThreads(GetParam(), /* rings= */ 80);  // 25,600 triangles
}

// From 65,536 primitives on, binned SAH sorts them into bins in parallel, too.
TEST(LargeStructures, AreTheSameForAnyNumberOfThreads) {
    expectTheSameForAnyNumberOfThreads({"bvh", {}}, /* rings= */ 150);
}

TEST_P(EveryStructure, IsNoObstacleToShadowsWhereLightPasses) {
    Soup soup{"two walls",
              {{vec3(-1, -1, 1), vec3(1, -1, 1), vec3(0, 1, 1)}, {vec3(-1, -1, 2), vec3(1, -1, 2), vec3(0, 1, 2)}}};
    const std::vector<Ray> rays = {{vec3(0), 0.0f, vec3(0, 0, 1), 1.5f}, {vec3(0), 0.0f, vec3(0, 0, 1), 3.0f}};
    Structure structure = build(soup);
    structure.markSeeThrough(std::vector<uint8_t>{1, 0});
    std::vector<Hit> hits(2);
    makeCpuTracer(structure)->traceShadows(rays, hits);
    EXPECT_EQ(hits[0].primitive, NO_HIT);
    EXPECT_EQ(hits[1].primitive, 1u);
    makeCpuTracer(structure)->trace(rays, hits, Query::closest);
    EXPECT_EQ(hits[0].primitive, 0u);
}

INSTANTIATE_TEST_SUITE_P(, EveryStructure, testing::ValuesIn(test::allVariants()),
                         [](const auto& info) { return nameOf(info.param); });

TEST(Triangles, AreHitAtTheirEdgesAndVertices) {
    const Soup soup{"one", {{vec3(0, 0, 1), vec3(1, 0, 1), vec3(0, 1, 1)}}};
    const Structure structure = structureType("brute").build(soup.triangles, {});
    for (const vec3 target :
         {vec3(0, 0, 1), vec3(1, 0, 1), vec3(0, 1, 1), vec3(0.5f, 0, 1), vec3(0, 0.5f, 1), vec3(0.5f, 0.5f, 1)}) {
        const Hit hit = traceOnCpu(structure, {{vec3(target.x, target.y, 0), 0.0f, vec3(0, 0, 1), 1.0f}}, Query::closest)[0];
        EXPECT_EQ(hit.primitive, 0u) << target.x << ' ' << target.y;
        EXPECT_EQ(hit.t, 1.0f);
    }
}

TEST(Triangles, AreMissedByRaysThatAreNone) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const Soup soup{"one", {{vec3(-1, -1, 1), vec3(1, -1, 1), vec3(0, 1, 1)}}};
    const vec3 o(0), d(0, 0, 1);
    const std::vector<Ray> rays = {{vec3(nan, 0, 0), 0, d, inf},
                                   {vec3(0, inf, 0), 0, d, inf},
                                   {o, 0, vec3(0, nan, 1), inf},
                                   {o, 0, vec3(0, 0, inf), inf},
                                   {o, 0, vec3(0), inf},
                                   {o, 2, d, 1},
                                   {o, nan, d, inf},
                                   {o, 0, d, nan},
                                   {o, 0, vec3(1e-45f), inf},
                                   {o, 0, d, -1},
                                   {vec3(0, 0, -1e30f), 0, d, inf}};
    for (const StructureType& type : structureTypes())
        for (const Hit& hit : traceOnCpu(type.build(soup.triangles, {}), rays, Query::closest))
            EXPECT_EQ(hit.primitive, NO_HIT);
}

TEST(Structures, RefuseOptionsTheyDoNotOffer) {
    EXPECT_THROW(structureType("bvh").build({}, {.build = "magic"}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.walk = "magic"}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.maxLeaf = 16}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.bound = "blob"}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.walk = "skip", .precision = 16}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.bound = "sphere", .precision = 16}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.bound = "sphere", .precision = 8}), Error);
    EXPECT_THROW(structureType("bvh").build({}, {.walk = "octants", .precision = 8}), Error);
    EXPECT_THROW(structureType("brute").build({}, {.walk = "skip"}), Error);
    EXPECT_THROW(structureType("magic"), Error);
}

}  // namespace
}  // namespace raig
