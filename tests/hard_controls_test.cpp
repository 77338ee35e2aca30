// The hard cases are hard: textbook methods fail on their very rays, most of them about as often as the catalogue says.
#include "measure/controls.hpp"
#include "measure/hard_meshes.hpp"
#include "measure/naive.hpp"
#include "measure/oracle.hpp"
#include "support/effort.hpp"
#include "support/hard_cases.hpp"
#include "support/tally.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace raig {
namespace {

using hard::Oracle;
using hard::naive::Slab;

/// With the rays of the tests, and with others.
class HardCaseControls : public testing::TestWithParam<uint32_t> {};

TEST_P(HardCaseControls, EachFailsAsOftenAsTheCatalogueSays) {
    size_t withRate = 0;
    for (const Control& control : allControls()) {
        const ControlResult result = runControl(control, /* seed= */ GetParam());
        EXPECT_TRUE(result.fails) << "case " << control.number << ", " << control.method << ": " << result.findings.percent()
                                  << " % instead of " << control.low << " to " << control.high;
        EXPECT_GT(result.findings.rays, 100u) << "case " << control.number << ", " << control.method;
        withRate += control.hasRate();
    }
    EXPECT_GT(withRate, 25u);
}

std::vector<uint32_t> seeds() {
    if (test::slowdown > 1) return {0};
    return {0, 4'000'000'000};
}

INSTANTIATE_TEST_SUITE_P(Seeds, HardCaseControls, testing::ValuesIn(seeds()));

TEST(HardCaseControl, OfWhichTheCatalogueGivesARateFailsByAFactorOfTwoOfIt) {
    const auto fails = [](double low, double high, uint64_t missed) {
        return Control{1, "", low, high, nullptr}.failsAsItShould({.rays = 1000, .missed = missed});
    };
    EXPECT_FALSE(fails(10, 12, 49));
    EXPECT_TRUE(fails(10, 12, 50));
    EXPECT_TRUE(fails(10, 12, 240));
    EXPECT_FALSE(fails(10, 12, 241));
    EXPECT_TRUE(fails(95, 100, 1000));
    EXPECT_FALSE(fails(0, 0, 0)) << "not at all";
    EXPECT_TRUE(fails(0, 0, 1));
}

// Ize's formula passes them all: so the boxes and rays are right, and it is the others that fail.
TEST(HardCaseControl, OfBoxesIsMetByAFormulaWithSlack) {
    for (const uint32_t number : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12}) {
        const hard::Scene scene = test::hardScenes(number).at(0);
        const Oracle oracle(scene.triangles);
        size_t hits = 0;
        for (const Ray& ray : scene.rays)
            for (const uint32_t hit : oracle.allClosest(ray)) {
                EXPECT_TRUE(hard::naive::meets(Slab::slack, scene.triangles[hit].box(), ray)) << "case " << number;
                ++hits;
            }
        EXPECT_GT(hits, scene.rays.size() / 50) << scene.name;
    }
}

// A grid that heeds where its cells end finds what is there: it is not its lists that are wrong.
TEST(HardCaseControl, OfGridsIsRightWhereHitsMustLieInTheCell) {
    const hard::Scene scene = test::hardScenes(40).at(0);
    const hard::naive::Grid grid(scene.triangles, 12);
    const Oracle oracle(scene.triangles);
    size_t hits = 0, wrong = 0;
    for (const Ray& ray : scene.rays) {
        const uint32_t hit = oracle.closest(ray).primitive;
        hits += hit != NO_HIT;
        wrong += hit != NO_HIT && grid.closest(ray, /* first= */ false) != hit;
    }
    EXPECT_LT(wrong, hits / 100);
}

TEST(Oracle, KnowsAllTrianglesAtThePointThatIsHit) {
    const hard::Oracle oracle(hard::squares(2, 1.0f, 2));
    EXPECT_EQ(oracle.allClosest({vec3(1, 1, 0), 0.0f, vec3(0, 0, 1), 10.0f}).size(), 6u);
    EXPECT_EQ(oracle.allClosest({vec3(0.5f, 0.5f, 0), 0.0f, vec3(0, 0, 1), 10.0f}).size(), 2u);
    EXPECT_EQ(oracle.allClosest({vec3(0.75f, 0.5f, 0), 0.0f, vec3(0, 0, 1), 10.0f}).size(), 1u);
    EXPECT_EQ(oracle.allClosest({vec3(3, 3, 0), 0.0f, vec3(0, 0, 1), 10.0f}).size(), 0u);
}

TEST(Oracle, MeetsSpheresFromOutsideAndInsideAndWhereRaysOnlyTouchThem) {
    const std::vector<Primitive> two{Primitive::sphere(vec3(0), 2.0f), Primitive::sphere(vec3(0, 0, 8), 1.0f)};
    const Oracle oracle(two);
    const auto closest = [&](const vec3& origin, const vec3& direction, float tMin = 0.0f) {
        return oracle.closest({origin, tMin, direction, INFINITY});
    };
    EXPECT_EQ(closest(vec3(0, 0, -5), vec3(0, 0, 1)).t, 3.0f);
    EXPECT_EQ(closest(vec3(0), vec3(0, 0, 0.5f)).t, 4.0f) << "from inside, by a longer way";
    EXPECT_EQ(closest(vec3(0, 0, -5), vec3(0, 0, 1), 3.5f).t, 7.0f)
        << "the far side counts where tMin is beyond the near one";
    EXPECT_EQ(closest(vec3(0, 0, -5), vec3(0, 0, 1), 7.5f).primitive, 1u);
    EXPECT_EQ(closest(vec3(2, 0, -5), vec3(0, 0, 1)).t, 5.0f) << "touches it";
    EXPECT_EQ(closest(vec3(std::nextafter(2.0f, 3.0f), 0, -5), vec3(0, 0, 1)).primitive, NO_HIT);
    EXPECT_EQ(closest(vec3(0, 0, 2), vec3(0, 0, 1)).t, 0.0f) << "starts on it";
    EXPECT_EQ(closest(vec3(0, 0, 20), vec3(0, 0, 1)).primitive, NO_HIT) << "behind";
    const Oracle none(std::vector<Primitive>{Primitive::sphere(vec3(0), 0.0f), Primitive::sphere(vec3(1.8e18f), 1e17f)});
    EXPECT_EQ(none.closest({vec3(0, 0, -5), 0.0f, vec3(0, 0, 1), INFINITY}).primitive, NO_HIT);
}

// Of spheres, too: the other side of the same one, its neighbour 4e-5 away, and a place off the surface are all wrong.
TEST(Oracle, NoticesEachKindOfFailureOfSpheres) {
    const hard::Scene scene = test::hardScenes(51).at(0);
    const Oracle oracle(scene.triangles);
    size_t hits = 0;
    for (const Ray& ray : scene.rays) {
        const Hit exact = oracle.closest(ray);
        if (exact.primitive == NO_HIT || oracle.isOpen(ray)) continue;
        ++hits;
        const auto verdict = [&](float t, uint32_t primitive) {
            return oracle.judge(ray, {t, 0.0f, 0.0f, primitive}, false);
        };
        EXPECT_FALSE(verdict(exact.t, exact.primitive).isFault());
        EXPECT_EQ(verdict(0.0f, NO_HIT).verdict, hard::Verdict::missed);
        EXPECT_TRUE(verdict(exact.t * 1.0005f, exact.primitive).isFault());
        const Hit next = oracle.closest({ray.origin, std::nextafter(exact.t, INFINITY), ray.direction, INFINITY});
        if (next.primitive != NO_HIT && next.t > exact.t * 1.0005f) {
            EXPECT_TRUE(verdict(next.t, next.primitive).isFault());
        }
    }
    EXPECT_GT(hits, 400u);
}

// The judge sees what it is for: hits that are left out, invented, of another triangle, or in the wrong place.
TEST(Oracle, NoticesEachKindOfFailure) {
    const hard::Scene scene = test::hardScenes(13).at(0);
    const Oracle oracle(scene.triangles);
    std::vector<Hit> exact;
    for (const Ray& ray : scene.rays) exact.push_back(oracle.closest(ray));
    const auto judge = [&](auto spoil) {
        std::vector<Hit> hits = exact;
        for (size_t i = 0; i < hits.size(); i += 10) spoil(hits[i], i);
        return test::judge(oracle, scene.rays, hits, false);
    };
    const size_t spoiled = (exact.size() + 9) / 10;
    EXPECT_EQ(judge([](Hit&, size_t) {}).failures(), 0u);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.primitive = NO_HIT; }).of(hard::Verdict::missed), spoiled);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.t *= 1.001f; }).of(hard::Verdict::wrong), spoiled);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.t *= 1.001f; }).unsound, spoiled);
    const test::Tally moved = judge([&](Hit& hit, size_t i) { hit.primitive = exact[(i + 5) % exact.size()].primitive; });
    EXPECT_GE(moved.unsound, spoiled * 9 / 10);  // a few are neighbours
    std::vector<Ray> outwards = scene.rays;
    for (Ray& ray : outwards) ray.tMax = 1e-3f;
    EXPECT_EQ(test::judge(oracle, outwards, exact, false).of(hard::Verdict::phantom), exact.size());
}

}  // namespace
}  // namespace raig
