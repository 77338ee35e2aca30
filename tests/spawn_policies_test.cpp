// Rays that leave surfaces: raig's error bounds neither meet what they left nor pass what is next to it; other ways do.
#include "measure/spawn_policies.hpp"
#include "base/random.hpp"
#include "measure/oracle.hpp"
#include "rays/tracer.hpp"
#include "support/effort.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace raig {
namespace {

const uint64_t rayCount = test::isLong() ? 40'000 : 4'000;

// In exact arithmetic, at every size and place, both next to a surface that can be told apart by eye and at 8 ULP.
TEST(ErrorBounds, HaveNoSelfHitAndNoLeak) {
    for (const double gap : {1e-3, 0.0})
        for (const SpawnScale& scale : spawnScales(gap)) {
            const SpawnFindings found = judgeSpawning(SpawnPolicy::bounds, scale, rayCount, 1);
            EXPECT_EQ(found.rays, rayCount);
            EXPECT_EQ(found.selfHits, 0u) << "size " << scale.size << " at " << scale.place << ", gap " << gap;
            EXPECT_EQ(found.leaks, 0u) << "size " << scale.size << " at " << scale.place << ", gap " << gap;
        }
}

// And so does the walk in single precision.
TEST(ErrorBounds, AreWideEnoughForTheWalk) {
    for (const double gap : {1e-3, 0.0})
        for (const SpawnScale& scale : spawnScales(gap)) {
            const std::vector<SpawnPair> pairs = spawnPairs(scale, rayCount / 40, 2);
            for (uint32_t i = 0; i < pairs.size(); ++i) {
                const std::vector<Ray> rays = spawnRays(SpawnPolicy::bounds, pairs[i], scale, 40, i);
                const std::array<Triangle, 2> two{pairs[i].left, pairs[i].next};
                const Structure structure = structureType("brute").build(two, {});
                std::vector<Hit> hits(rays.size());
                makeCpuTracer(structure)->trace(rays, hits, Query::closest);
                for (const Hit& hit : hits) ASSERT_EQ(hit.primitive, 1u) << "size " << scale.size << " at " << scale.place;
            }
        }
}

double percent(uint64_t part, uint64_t of) {
    return 100.0 * double(part) / double(of);
}

// The others fail where it is known that they do, about as often: else the rays ask nothing.
TEST(OtherPolicies, FailWhereTheyAreKnownTo) {
    const auto judge = [](SpawnPolicy policy, double size, double place) {
        return judgeSpawning(policy, {size, place}, 20'000, 3);
    };
    for (const SpawnScale& scale : spawnScales(1e-3)) {
        const SpawnFindings found = judgeSpawning(SpawnPolicy::none, scale, rayCount, 3);
        EXPECT_NEAR(percent(found.selfHits, found.rays), 55.0, 10.0) << "size " << scale.size << " at " << scale.place;
        EXPECT_EQ(found.leaks, 0u);
    }
    const SpawnFindings small = judge(SpawnPolicy::smallestT, 1e-3, 0.0), far = judge(SpawnPolicy::smallestT, 1.0, 1e4);
    EXPECT_EQ(small.leaks, small.rays);
    EXPECT_EQ(small.selfHits, 0u);
    EXPECT_NEAR(percent(far.selfHits, far.rays), 32.0, 3.0);
    const SpawnFindings tiny = judge(SpawnPolicy::integerSteps, 1e-3, 0.0),
                        large = judge(SpawnPolicy::integerSteps, 1e6, 0.0);
    EXPECT_EQ(tiny.leaks, tiny.rays);
    EXPECT_GT(large.selfHits, 0u);
    EXPECT_LT(percent(large.selfHits, large.rays), 0.3);
    const SpawnFindings moved = judge(SpawnPolicy::alongNormal, 1.0, 1e4);
    EXPECT_GT(percent(moved.selfHits, moved.rays), 30.0);
}

// The second triangle is where it is said to be, and large enough that nothing passes beside it.
TEST(SpawnPairs, AreAsFarApartAsAskedFor) {
    for (const double gap : {1e-3, 0.0})
        for (const SpawnScale& scale : spawnScales(gap))
            for (const SpawnPair& pair : spawnPairs(scale, 50, 4)) {
                const dvec3 a(pair.left.a), ab = dvec3(pair.left.b) - a, ac = dvec3(pair.left.c) - a;
                const dvec3 n = glm::normalize(glm::cross(ab, ac));
                const double side = glm::dot(n, dvec3(pair.side)) > 0.0 ? 1.0 : -1.0;
                double nearest = INFINITY;
                for (const vec3& p : {pair.left.a, pair.left.b, pair.left.c})
                    nearest = std::min(nearest, glm::length(dvec3(p)));
                const auto reach = static_cast<float>(nearest);
                const double eightUlp = 8.0 * (double{std::nextafter(reach, INFINITY)} - double{reach});
                for (const vec3& p : {pair.next.a, pair.next.b, pair.next.c}) {
                    const double height = side * glm::dot(n, dvec3(p) - a);
                    EXPECT_GE(height, eightUlp * (1.0 - 1e-6));
                    EXPECT_GE(height, gap * scale.size * (1.0 - 1e-6));
                }
            }
}

TEST(SpawnRays, AreTheSameEveryTimeAndForEveryPolicyInTheirDirections) {
    const SpawnScale scale{1e3, 1e4};
    const SpawnPair pair = spawnPairs(scale, 1, 5).at(0);
    const std::vector<Ray> rays = spawnRays(SpawnPolicy::bounds, pair, scale, 30, 6);
    for (const SpawnPolicy policy : spawnPolicies) {
        const std::vector<Ray> others = spawnRays(policy, pair, scale, 30, 6);
        ASSERT_EQ(others.size(), rays.size());
        for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(others[i].direction, rays[i].direction) << nameOf(policy);
    }
    const std::vector<Ray> again = spawnRays(SpawnPolicy::bounds, pair, scale, 30, 6);
    for (size_t i = 0; i < rays.size(); ++i) EXPECT_EQ(again[i].origin, rays[i].origin);
}

}  // namespace
}  // namespace raig
