// The hard cases are hard: textbook methods fail on their very rays, most of them about as often as the catalogue says.
#include "measure/naive.hpp"
#include "measure/oracle.hpp"
#include "support/hard_cases.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

namespace raig {
namespace {

using hard::Oracle;
using hard::Tally;
using hard::naive::Dda;
using hard::naive::Slab;
using hard::naive::Tester;

/// A rate in percent that is within a factor of two of the catalogue's; it has ranges, too.
void expectAbout(double percent, double least, double most, const std::string& what) {
    EXPECT_GE(percent, least / 2.0) << what;
    EXPECT_LE(percent, std::min(2.0 * most, 100.0)) << what;
}
void expectAbout(double percent, double catalogued, const std::string& what) {
    expectAbout(percent, catalogued, catalogued, what);
}

/// In how many of a hundred rays that hit something, in exact arithmetic, `fails(scene, ray, hit)`.
template <class Fails>
double rateOf(const hard::Scene& scene, const Fails& fails) {
    const Oracle oracle(scene.triangles);
    size_t hits = 0, failed = 0;
    for (const Ray& ray : scene.rays) {
        const uint32_t hit = oracle.closest(ray).primitive;
        if (hit == NO_HIT) continue;
        ++hits;
        failed += fails(scene, ray, hit);
    }
    EXPECT_GT(hits, scene.rays.size() / 50) << scene.name;
    return 100.0 * double(failed) / double(std::max<size_t>(hits, 1));
}

hard::Scene sceneOf(uint32_t number, size_t index = 0) {
    return test::hardScenes(number).at(index);
}

/// How often the formula misses the box of the triangle that is hit.
double missRate(uint32_t number, Slab slab) {
    return rateOf(sceneOf(number), [slab](const hard::Scene& scene, const Ray& ray, uint32_t hit) {
        return !hard::naive::meets(slab, scene.triangles[hit].box(), ray);
    });
}

/// How often no triangle is hit where one is.
double missRate(const hard::Scene& scene, Tester tester) {
    return rateOf(scene, [tester](const hard::Scene& s, const Ray& ray, uint32_t) {
        return std::none_of(s.triangles.begin(), s.triangles.end(), [&](const Triangle& t) {
            const auto at = hard::naive::meets(tester, t, ray);
            return at && *at >= ray.tMin && *at <= ray.tMax;
        });
    });
}

TEST(HardCaseControls, BoxesAreMissedByTextbookSlabs) {
    expectAbout(missRate(1, Slab::glsl), 50.0, "case 1, min and max");
    expectAbout(missRate(2, Slab::glsl), 75.0, "case 2, min and max");
    expectAbout(missRate(3, Slab::signOfValue), 50.0, "case 3, the sign of the component");
    expectAbout(missRate(4, Slab::signOfValue), 100.0, "case 4, the sign of the component");
    expectAbout(missRate(5, Slab::glsl), 12.3, "case 5, min and max");
    expectAbout(missRate(5, Slab::fused), 19.8, "case 5, fused");
    expectAbout(missRate(6, Slab::glsl), 6.6, 8.0, "case 6, min and max");
    expectAbout(missRate(6, Slab::fused), 53.0, "case 6, fused");
    expectAbout(missRate(7, Slab::clamped5), 100.0, "case 7, clamped to 1e-5");
    expectAbout(missRate(8, Slab::clamped5), 89.0, "case 8, clamped to 1e-5");
    expectAbout(missRate(8, Slab::clamped12), 96.0, "case 8, clamped to 1e-12");
    expectAbout(missRate(9, Slab::strict), 100.0, "case 9, strict");
    EXPECT_GT(missRate(10, Slab::glsl), 1.0) << "case 10, min and max";
    expectAbout(missRate(11, Slab::largest), 95.8, 100.0, "case 11, 1 / 0 = FLT_MAX");
    EXPECT_GT(missRate(12, Slab::glsl), 1.0) << "case 12, min and max";
}

// Ize's formula passes them all: so the boxes and rays are right, and it is the others that fail.
TEST(HardCaseControls, BoxesAreMetByAFormulaWithSlack) {
    for (const uint32_t number : {1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 11, 12})
        EXPECT_EQ(missRate(number, Slab::slack), 0.0) << "case " << number;
}

TEST(HardCaseControls, MeshesLeakWithTextbookTriangles) {
    expectAbout(missRate(sceneOf(13), Tester::moellerTrumbore), 9.46, "case 13, Moeller-Trumbore");
    expectAbout(missRate(sceneOf(14), Tester::moellerTrumbore), 11.42, "case 14, Moeller-Trumbore");
    expectAbout(missRate(sceneOf(15, 0), Tester::moellerTrumboreFused), 23.8, "case 15, vertices, fused");
    expectAbout(missRate(sceneOf(15, 1), Tester::moellerTrumboreFused), 17.5, "case 15, edges, fused");
    EXPECT_GT(missRate(sceneOf(16, 1), Tester::moellerTrumbore), 0.0) << "case 16";
    EXPECT_GT(missRate(sceneOf(16, 1), Tester::watertightFused), 0.0) << "case 16, watertight but fused";
    EXPECT_GT(missRate(sceneOf(17, 1), Tester::watertightFused), 0.0) << "case 17, watertight but fused";
    expectAbout(missRate(sceneOf(18), Tester::moellerTrumboreCull), 100.0, "case 18, |det| < 1e-7");
    expectAbout(missRate(sceneOf(19), Tester::moellerTrumbore), 100.0, "case 19, Moeller-Trumbore");
    expectAbout(missRate(sceneOf(20), Tester::sameSigns), 100.0, "case 20, sign(0) = 0");
}

// Case 24: hits that are nowhere near their slivers.
TEST(HardCaseControls, SliversAreHitWhereTheyAreNot) {
    const hard::Scene scene = sceneOf(24);
    const Oracle oracle(scene.triangles);
    size_t unsound = 0;
    for (const Ray& ray : scene.rays)
        for (uint32_t i = 0; i < scene.triangles.size(); ++i) {
            const auto t = hard::naive::meets(Tester::moellerTrumbore, scene.triangles[i], ray);
            if (!t || *t < 0.0f) continue;
            unsound += oracle.judge(std::span(&ray, 1), std::vector<Hit>{{*t, 0.0f, 0.0f, i}}, false).unsound;
        }
    EXPECT_GT(unsound, 0u);
}

/// What a walk from cell to cell loses, in percent of the rays that meet the grid.
struct Losses {
    double nothing = 0.0;  ///< no cell is visited
    double skips = 0.0;    ///< a cell that the ray is in is not, or the walk does not end
};

Losses lossesOf(const hard::Scene& scene, Dda dda, uint32_t n = 24, double side = 0.0) {
    Box box;
    for (const Triangle& t : scene.triangles) box.grow(t.box());
    if (side > 0.0) box.hi = box.lo + vec3(static_cast<float>(side));
    size_t rays = 0, nothing = 0, skips = 0;
    for (const Ray& ray : scene.rays) {
        const auto want = hard::naive::cellsOf(Dda::sound, box, n, ray);
        if (!want || want->empty()) continue;
        ++rays;
        const auto got = hard::naive::cellsOf(dda, box, n, ray);
        std::set<uint32_t> visited;
        if (got)
            for (const auto& visit : *got) visited.insert(visit.cell);
        nothing += visited.empty();
        skips += std::any_of(want->begin(), want->end(), [&](const auto& visit) { return !visited.contains(visit.cell); });
    }
    const double per = 100.0 / double(std::max<size_t>(rays, 1));
    return {double(nothing) * per, double(skips) * per};
}

TEST(HardCaseControls, GridsLoseCellsWithATextbookWalk) {
    expectAbout(lossesOf(sceneOf(32, 0), Dda::unclamped).nothing, 33.0, 34.0, "case 32, unclamped");
    expectAbout(lossesOf(sceneOf(32, 1), Dda::unclamped).nothing, 100.0, "case 32, from the farthest faces, unclamped");
    expectAbout(lossesOf(sceneOf(33), Dda::noZeros).skips, 48.0, "case 33, zeros not handled");
    expectAbout(lossesOf(sceneOf(34), Dda::noZeros).skips, 74.0, 88.0, "case 34, zeros not handled");
    expectAbout(lossesOf(sceneOf(37, 0), Dda::reorigin).skips, 3.3, "case 37, from 1e3");
    expectAbout(lossesOf(sceneOf(37, 1), Dda::reorigin).skips, 43.9, "case 37, from 1e4");
    expectAbout(lossesOf(sceneOf(37, 2), Dda::reorigin).skips, 91.8, "case 37, from 1e5");
    expectAbout(lossesOf(sceneOf(38), Dda::single, 32, 0.5).skips, 25.0, "case 38, cells of a 64th");
}

TEST(HardCaseControls, GridsLoseWallsWithoutAMargin) {
    double worst = 0.0;
    const std::array<uint32_t, 4> cells{3, 5, 7, 12};
    for (size_t i = 0; i < cells.size(); ++i) {
        const hard::Scene scene = sceneOf(39, i);
        const hard::naive::Grid grid(scene.triangles, cells[i]);
        worst = std::max(worst, rateOf(scene, [&](const hard::Scene&, const Ray& ray, uint32_t hit) {
                             const uint32_t got = grid.closest(ray, /* first= */ false);
                             return got != hit && got != NO_HIT ? false : got == NO_HIT;
                         }));
    }
    expectAbout(worst, 13.3, "case 39, no margin");
}

TEST(HardCaseControls, GridsFindTheWrongTriangleOutsideTheCell) {
    const hard::Scene scene = sceneOf(40);
    const hard::naive::Grid grid(scene.triangles, 12);
    const auto wrongRate = [&](bool first) {
        return rateOf(scene,
                      [&](const hard::Scene&, const Ray& ray, uint32_t hit) { return grid.closest(ray, first) != hit; });
    };
    EXPECT_GT(wrongRate(/* first= */ true), 1.0);
    EXPECT_LT(wrongRate(/* first= */ false), 1.0);
}

TEST(HardCaseControls, KdTreesLoseWallsInTheirPlanes) {
    const Box box{vec3(0), vec3(4)};
    for (const uint32_t number : {47, 48, 49})
        EXPECT_GT(rateOf(sceneOf(number),
                         [&](const hard::Scene& scene, const Ray& ray, uint32_t) {
                             return hard::naive::closestByKdTree(scene.triangles, box, ray) == NO_HIT;
                         }),
                  1.0)
            << "case " << number;
}

// The judge sees what it is for: hits that are left out, invented, of another triangle, or in the wrong place.
TEST(HardCaseControls, TheOracleNoticesEachKindOfFailure) {
    const hard::Scene scene = sceneOf(13);
    const Oracle oracle(scene.triangles);
    std::vector<Hit> exact;
    for (const Ray& ray : scene.rays) exact.push_back(oracle.closest(ray));
    const auto judge = [&](auto spoil) {
        std::vector<Hit> hits = exact;
        for (size_t i = 0; i < hits.size(); i += 10) spoil(hits[i], i);
        return oracle.judge(scene.rays, hits, false);
    };
    const size_t spoiled = (exact.size() + 9) / 10;
    EXPECT_EQ(judge([](Hit&, size_t) {}).failures(), 0u);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.primitive = NO_HIT; }).of(hard::Verdict::missed), spoiled);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.t *= 1.001f; }).of(hard::Verdict::wrong), spoiled);
    EXPECT_EQ(judge([](Hit& hit, size_t) { hit.t *= 1.001f; }).unsound, spoiled);
    const Tally moved = judge([&](Hit& hit, size_t i) { hit.primitive = exact[(i + 5) % exact.size()].primitive; });
    EXPECT_GE(moved.unsound, spoiled * 9 / 10);  // a few are neighbours
    std::vector<Ray> outwards = scene.rays;
    for (Ray& ray : outwards) ray.tMax = 1e-3f;
    EXPECT_EQ(oracle.judge(outwards, exact, false).of(hard::Verdict::phantom), exact.size());
}

}  // namespace
}  // namespace raig
