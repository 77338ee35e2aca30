// Grids whose walk is interrupted, or whose arrays are damaged: a walk goes on, stays inside, and damage is found.
#include "rays/tracer.hpp"
#include "structures/grid.hpp"
#include "structures/grid_shape.hpp"
#include "support/effort.hpp"
#include "support/grids.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>

namespace raig {
namespace {

using namespace test;

TEST(Grid, GoesOnWhereItWasStopped) {
    for (const test::Soup& soup : test::soups()) {
        std::vector<Ray> rays = test::rays(soup.triangles, 31, test::affordable(800));
        for (size_t i = 0; i < rays.size(); i += 5)
            rays[i].origin = vec3(dvec3(rays[i].origin) - 300.0 * dvec3(rays[i].direction));  // some from far off
        const Structure one = gridOver(soup.triangles, 1), two = gridOver(soup.triangles, 2);
        std::vector<Hit> want(rays.size());
        makeCpuTracer(one)->trace(rays, want, Query::closest);
        for (const uint32_t maxSteps : {1u, 2u, 7u}) {
            const std::vector<Hit> gotOne = walkInPieces(one, rays, maxSteps);
            const std::vector<Hit> gotTwo = walkInPieces(two, rays, maxSteps);
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
        ASSERT_EQ(one.header.walk, 0u);
        ASSERT_EQ(two.header.walk, 1u);
        ASSERT_EQ(nested.header.walk, grid::nestedWalk);
        for (const Structure* structure : {&one, &two, &nested}) EXPECT_NO_THROW(walkAsFarAsMaybe(*structure, rays));
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

}  // namespace
}  // namespace raig
