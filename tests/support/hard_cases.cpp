#include "support/hard_cases.hpp"

#include "rays/tracer.hpp"
#include "support/effort.hpp"
#include "support/tally.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>
#include <iostream>

namespace raig::test {

namespace {

std::vector<Hit> trace(const Structure& structure, const std::vector<Ray>& rays, Query query) {
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, query);
    return hits;
}

std::vector<Hit> bruteForce(const hard::Scene& scene) {
    return trace(structureType("brute").build(scene.triangles, {}), scene.rays, Query::closest);
}

/// The scene with no more rays than this build can afford: of every family, as those come in turns of 3, 8 or 10.
hard::Scene affordableScene(hard::Scene scene) {
    const size_t count = affordable(scene.rays.size()), stride = slowdown == 1 ? 1 : 7;
    static_assert(slowdown == 1 || slowdown >= 7);
    for (size_t i = 0; i < count; ++i) scene.rays[i] = scene.rays[i * stride];
    scene.rays.resize(count);
    return scene;
}

}  // namespace

std::vector<hard::Scene> hardScenes(uint32_t number) {
    return hard::caseOf(number).make({.seed = 0, .times = isLong() ? 30u : 1u});
}

std::string nameOfCase(uint32_t number) {
    return "Case" + std::to_string(number);
}

std::vector<uint32_t> numbersOf(const std::vector<hard::Case>& cases) {
    std::vector<uint32_t> numbers;
    for (const hard::Case& one : cases) numbers.push_back(one.number);
    return numbers;
}

void expectBruteForceIsExact(uint32_t number) {
    for (const hard::Scene& scene : hardScenes(number)) {
        const hard::Oracle oracle(scene.triangles);
        const std::vector<Hit> hits = bruteForce(scene);
        const Tally tally = judge(oracle, scene.rays, hits, scene.exact);
        for (size_t i = 0; i < scene.meets.size(); ++i)
            EXPECT_EQ(hits[i].primitive, scene.meets[i]) << "case " << number << ", " << scene.name << ": ray " << i;
        EXPECT_EQ(tally.failures(), 0u) << "case " << number << ", " << scene.name << ": " << tally;
        EXPECT_LE(double(tally.open), scene.mostOpen * double(tally.rays)) << scene.name << ": " << tally;
        std::cout << "case " << number << ", " << scene.name << ": " << tally << '\n';
    }
}

void expectEveryStructureAnswersAsBruteForce(uint32_t number) {
    const std::vector<Variant> variants = isLong() ? allVariants() : walkVariants();
    for (const hard::Scene& all : hardScenes(number)) {
        const hard::Scene scene = affordableScene(all);
        const std::vector<Hit> want = bruteForce(scene);
        for (const Variant& variant : variants) {
            const Structure structure = variant.build(scene.triangles);
            const std::vector<Hit> got = trace(structure, scene.rays, Query::closest);
            const std::vector<Hit> any = trace(structure, scene.rays, Query::any);
            size_t different = 0;
            for (size_t i = 0; i < want.size(); ++i) {
                const bool same = std::memcmp(&got[i], &want[i], sizeof(Hit)) == 0 &&
                                  (any[i].primitive == NO_HIT) == (want[i].primitive == NO_HIT);
                if (!same && different++ == 0)
                    ADD_FAILURE() << "case " << number << ", " << scene.name << ", " << variant << ": ray " << i << ' '
                                  << hard::describe(scene.rays[i]) << "\n got " << hard::describe(got[i]) << "\n any "
                                  << hard::describe(any[i]) << "\nwant " << hard::describe(want[i]);
            }
            EXPECT_EQ(different, 0u) << scene.name << ", " << variant << ", of " << want.size();
        }
    }
}

}  // namespace raig::test
