#include "support/hard_cases.hpp"

#include "rays/tracer.hpp"
#include "support/effort.hpp"
#include "support/oracle.hpp"
#include "support/soups.hpp"
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

std::vector<Hit> bruteForce(const HardScene& scene) {
    return trace(structureType("brute").build(scene.triangles, {}), scene.rays, Query::closest);
}

/// The scene with no more rays than this build can afford: of every family, as those come in turns of 3, 8 or 10.
HardScene affordableScene(HardScene scene) {
    const size_t count = affordable(scene.rays.size()), stride = slowdown == 1 ? 1 : 7;
    static_assert(slowdown == 1 || slowdown >= 7);
    for (size_t i = 0; i < count; ++i) scene.rays[i] = scene.rays[i * stride];
    scene.rays.resize(count);
    return scene;
}

std::string describe(const Hit& h) {
    return fmt::format("triangle {} t {:.9g} u {:.9g} v {:.9g}", static_cast<int32_t>(h.primitive), h.t, h.u, h.v);
}

}  // namespace

HardCase hardCase(int number) {
    for (const auto& cases : {boxCases(), triangleCases(), cellCases()})
        for (const HardCase& one : cases)
            if (one.number == number) return one;
    throw std::out_of_range("no such case");
}

std::string nameOfCase(int number) {
    return "Case" + std::to_string(number);
}

std::vector<int> numbersOf(const std::vector<HardCase>& cases) {
    std::vector<int> numbers;
    for (const HardCase& one : cases) numbers.push_back(one.number);
    return numbers;
}

void expectBruteForceIsExact(const HardCase& hardCase) {
    for (const HardScene& scene : hardCase.make()) {
        const Oracle oracle(scene.triangles);
        const Tally tally = oracle.judge(scene.rays, bruteForce(scene), scene.exact);
        EXPECT_EQ(tally.failures(), 0u) << hardCase.what << ", " << scene.name << ": " << tally;
        EXPECT_LE(double(tally.open), scene.mostOpen * double(tally.rays)) << scene.name << ": " << tally;
        std::cout << "case " << hardCase.number << ", " << scene.name << ": " << tally << '\n';
    }
}

void expectEveryStructureAnswersAsBruteForce(const HardCase& hardCase) {
    const std::vector<Variant> variants = isLong() ? allVariants() : walkVariants();
    for (const HardScene& all : hardCase.make()) {
        const HardScene scene = affordableScene(all);
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
                    ADD_FAILURE() << hardCase.what << ", " << scene.name << ", " << variant << ": ray " << i << ' '
                                  << test::describe(scene.rays[i]) << "\n got " << describe(got[i]) << "\n any "
                                  << describe(any[i]) << "\nwant " << describe(want[i]);
            }
            EXPECT_EQ(different, 0u) << scene.name << ", " << variant << ", of " << want.size();
        }
    }
}

size_t raysOf(size_t count) {
    return isLong() ? 30 * count : count;
}

std::vector<Triangle> CutBox::triangles() const {
    std::vector<Triangle> result;
    for (int axis = 0; axis < 3; ++axis) {
        const std::vector<float>&p = cuts[(axis + 1) % 3], &q = cuts[(axis + 2) % 3];
        for (const float side : {cuts[axis].front(), cuts[axis].back()})
            for (size_t i = 0; i + 1 < p.size(); ++i)
                for (size_t j = 0; j + 1 < q.size(); ++j) {
                    const auto at = [&](size_t k, size_t l) {
                        vec3 corner;
                        corner[axis] = side;
                        corner[(axis + 1) % 3] = p[k];
                        corner[(axis + 2) % 3] = q[l];
                        return corner;
                    };
                    result.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
                    result.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
                }
    }
    return result;
}

Box CutBox::box() const {
    return {vec3(cuts[0].front(), cuts[1].front(), cuts[2].front()), vec3(cuts[0].back(), cuts[1].back(), cuts[2].back())};
}

CutBox randomCutBox(Random& random, const dvec3& centre, double size, int inner) {
    CutBox result;
    for (int axis = 0; axis < 3; ++axis) {
        const double half = 0.5 * size * random.within(0.6, 1.0);
        std::vector<float>& cuts = result.cuts[axis];
        cuts.push_back(static_cast<float>(centre[axis] - half));
        for (int i = 0; i < inner; ++i)
            cuts.push_back(static_cast<float>(centre[axis] + half * ((i + random.within(0.2, 0.8)) / inner - 0.5)));
        cuts.push_back(static_cast<float>(centre[axis] + half));
    }
    return result;
}

std::vector<Triangle> squares(int axis, float place, int side) {
    std::vector<Triangle> result;
    for (int i = 0; i < side; ++i)
        for (int j = 0; j < side; ++j) {
            const auto at = [&](int k, int l) {
                vec3 corner;
                corner[axis] = place;
                corner[(axis + 1) % 3] = static_cast<float>(k);
                corner[(axis + 2) % 3] = static_cast<float>(l);
                return corner;
            };
            result.push_back({at(i, j), at(i + 1, j), at(i + 1, j + 1)});
            result.push_back({at(i, j), at(i + 1, j + 1), at(i, j + 1)});
        }
    return result;
}

float anyZero(Random& random) {
    return random.below(2) == 0 ? 0.0f : -0.0f;
}

}  // namespace raig::test
