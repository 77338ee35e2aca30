// What is wrong with structures of two levels, wherever they come from: nothing with what was built, and each damage is
// found.
#include "structures/structure_fault.hpp"

#include "rays/placed_scene.hpp"
#include "structures/upper_level.hpp"
#include "support/groves.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <functional>

namespace raig {
namespace {

using test::Grove;

std::string nothingOr(const std::optional<std::string>& fault) {
    return fault.value_or("nothing");
}

TEST(TwoLevelFaults, AreNoneInWhatWasBuilt) {
    size_t kept = 0;
    for (const Grove& grove : test::groves()) {
        const Geometry geometry = gatherInstances(grove.scene);
        const PlacedScene scene = placedScene(geometry, {});
        for (const test::Variant& variant : test::allVariants()) {
            const StructureType& type = structureType(variant.structure);
            const Structure structure = buildTwoLevels(scene, type, variant.params);
            kept += structure.isInstanced();
            ASSERT_EQ(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing") << grove.name << ' ' << variant;
        }
    }
    EXPECT_GT(kept, 10 * test::allVariants().size());
}

/// A small structure of two levels, of which the first is written out, and a copy to damage.
class DamagedTwoLevels : public testing::Test {
protected:
    const StructureType& type_ = structureType("bvh");
    const Grove grove_ = test::groves().front();
    const Geometry geometry_ = gatherInstances(grove_.scene);
    const PlacedScene scene_ = placedScene(geometry_, {});
    const Structure built_ = buildTwoLevels(scene_, type_, {.walk = "skip"});
    const UpperPlaces places_ = upperPlaces(built_.instances, built_.bottoms.size());
    Structure damaged_ = built_;

    void SetUp() override {
        ASSERT_EQ(built_.bottoms.size(), 3u);
        ASSERT_EQ(built_.bottoms.front().mesh, Bottom::writtenOut);
    }
    /// What is found of the damage that is done, which is then mended.
    std::string foundIn(const std::function<void(Structure&)>& damage) {
        damaged_ = built_;
        damage(damaged_);
        return nothingOr(findTwoLevelFault(damaged_, scene_, type_));
    }
    void expectFound(const char* what, const char* name, const std::function<void(Structure&)>& damage) {
        const std::string found = foundIn(damage);
        EXPECT_NE(found.find(name), std::string::npos) << what << ": found was " << found;
    }
    uvec4* top(Structure& s, size_t node) const { return &s.nodes[2 * node]; }
    uvec4* instance(Structure& s, size_t i) const { return &s.nodes[places_.instances + i * shared::INSTANCE_STRIDE]; }
    uvec4* bottom(Structure& s, size_t i) const { return &s.nodes[places_.bottoms + i * shared::BOTTOM_STRIDE]; }
    size_t leafNode() const {
        for (size_t i = 0;; ++i)
            if ((built_.nodes[2 * i].w & shared::TOP_LEAF) != 0) return i;
    }
};

TEST_F(DamagedTwoLevels, AreFoundByTheirTopTree) {
    expectFound("a skip link", "top tree: node 0 ", [&](Structure& s) { top(s, 0)->w = 1; });
    expectFound("a skip link", "top tree: node 0 ", [&](Structure& s) { top(s, 0)->w += 1; });
    expectFound("another instance", "top tree", [&](Structure& s) { top(s, leafNode())->w ^= 1; });
    expectFound("no instance", "top tree", [&](Structure& s) { top(s, leafNode())->w = shared::TOP_LEAF | s.instances; });
    expectFound("a box", "top tree: node 0 ", [&](Structure& s) { top(s, 0)[1].y -= 1; });
    expectFound("no number", "top tree: node 3 ", [&](Structure& s) { top(s, 3)->x = 0x7fc00000; });
    expectFound("the last copy", "top tree", [&](Structure& s) { s.nodes[places_.topTreeEnd - 1].z ^= 1; });
    expectFound("padding", "between", [&](Structure& s) { s.nodes[places_.instances - 1].w = 1; });
}

TEST_F(DamagedTwoLevels, AreFoundByTheRecordsOfInstances) {
    for (int texel = 0; texel < 8; ++texel)
        for (int word = 0; word < 4; ++word)
            for (const uint32_t change : {1u, 0x80000000u, 0x7fffffffu})
                expectFound("a record", "record of instance 5 ",
                            [&](Structure& s) { instance(s, 5)[texel][word] ^= change; });
    expectFound("no slack", "record of instance 0 ", [&](Structure& s) { instance(s, 0)[7].w = 0; });
    expectFound("too much of it", "record of instance 1 ", [&](Structure& s) { instance(s, 1)[7].z = 0x7f800000; });
    expectFound("the last", "record of instance", [&](Structure& s) { instance(s, s.instances - 1)[6].w += 1; });
}

TEST_F(DamagedTwoLevels, AreFoundByTheRecordsOfBottoms) {
    for (const uint32_t i : {0u, 1u, 2u}) {
        const std::string named = fmt::format("bottom {}", i);
        expectFound("nodes", "out of place", [&](Structure& s) { bottom(s, i)[4].x = 0xffffffff; });
        expectFound("nodes", "bottom", [&](Structure& s) { bottom(s, i)[4].x += 1; });
        expectFound("triangles", named.c_str(), [&](Structure& s) { bottom(s, i)[4].y += 3; });
        expectFound("nothing", named.c_str(), [&](Structure& s) { bottom(s, i)[4].w = 1; });
        expectFound("bounds", named.c_str(), [&](Structure& s) { bottom(s, i)[0].x ^= 1; });
        expectFound("bounds", named.c_str(), [&](Structure& s) { bottom(s, i)[1].z = 0x7fc00000; });
        expectFound("nodes", named.c_str(), [&](Structure& s) { bottom(s, i)[0].w -= 1; });
        expectFound("triangles", named.c_str(), [&](Structure& s) { bottom(s, i)[1].w += 1; });
        expectFound("the walk", named.c_str(), [&](Structure& s) { bottom(s, i)[2].w = shared::WALK_TRAIL; });
        expectFound("the unit", named.c_str(), [&](Structure& s) { bottom(s, i)[3].w = std::bit_cast<uint32_t>(0.0f); });
    }
    expectFound("all walks", "bottom 0", [&](Structure& s) {
        for (const uint32_t i : {0u, 1u, 2u}) bottom(s, i)[2].w = shared::MAX_WALKS;
    });
}

TEST_F(DamagedTwoLevels, AreFoundByTheTableOfBottoms) {
    expectFound("none", "0 bottoms", [](Structure& s) { s.bottoms.clear(); });
    expectFound("one less", "2 bottoms", [](Structure& s) { s.bottoms.pop_back(); });
    expectFound("one more", "4 bottoms", [](Structure& s) { s.bottoms.push_back(s.bottoms.back()); });
    expectFound("a mesh", "another mesh", [](Structure& s) { std::swap(s.bottoms[1].mesh, s.bottoms[2].mesh); });
    expectFound("a mesh", "another mesh", [](Structure& s) { s.bottoms[2].mesh = 0xfffffffe; });
    expectFound("a start", "out of place", [](Structure& s) { s.bottoms[1].firstReference += 1; });
    expectFound("a start", "out of place", [](Structure& s) { s.bottoms[0].firstReference = ~uint64_t{0}; });
    expectFound("a size", "out of place", [](Structure& s) { s.bottoms[1].references -= 1; });
    expectFound("a size", "out of place", [](Structure& s) { s.bottoms[2].references = ~uint64_t{0}; });
    expectFound("a size", "of no bottom", [](Structure& s) { s.bottoms[2].references = 0; });
    expectFound("a cut", "bottom 0", [](Structure& s) {
        s.bottoms[0].references -= 1;
        s.bottoms[1].firstReference -= 1;
        s.bottoms[1].references += 1;
    });
    expectFound("instances", "instances", [](Structure& s) { s.instances = 0; });
    expectFound("instances", "instances", [](Structure& s) { s.instances += 1; });
}

TEST_F(DamagedTwoLevels, AreFoundByTheHeader) {
    const float nan = std::numeric_limits<float>::quiet_NaN();
    expectFound("copies", "its header", [](Structure& s) { s.header.gridStep.x = 0; });
    expectFound("instances", "its header", [](Structure& s) { s.header.gridStep.y += 1; });
    expectFound("nothing", "its header", [](Structure& s) { s.header.gridStep.z = 1; });
    expectFound("nothing", "its header", [&](Structure& s) { s.header.gridOrigin.x = nan; });
    expectFound("nodes", "its header", [](Structure& s) { s.header.nodeCount += 1; });
    expectFound("nodes", "its header", [](Structure& s) { s.header.nodeCount = 0xffffffff; });
    expectFound("triangles", "its header", [](Structure& s) { s.header.triangleCount -= 1; });
    expectFound("the unit", "its header", [](Structure& s) { s.header.unit *= 2; });
    expectFound("the walk", "its header", [](Structure& s) { s.header.walk = shared::WALK_OCTANTS; });
    expectFound("bounds", "its header", [&](Structure& s) { s.header.lo.y = nan; });
}

TEST_F(DamagedTwoLevels, AreFoundByTheArraysOfBottoms) {
    const size_t first = places_.end, second = built_.nodes[places_.bottoms + shared::BOTTOM_STRIDE + 4].x;
    expectFound("a node", "bottom 0: ", [&](Structure& s) { s.nodes[first].w = 0; });
    expectFound("a node", "bottom 1: ", [&](Structure& s) { s.nodes[second].w = 0; });
    expectFound("a node", "bottom 2: ", [&](Structure& s) { s.nodes[s.nodes.size() - 2].w ^= 1; });
    const auto reference = [](Structure& s, size_t bottom) -> uvec4* {
        return &s.triangles[(s.bottoms[bottom].firstReference + 2) * shared::TRIANGLE_STRIDE];
    };
    for (const uint32_t i : {0u, 1u, 2u}) {
        const std::string named = fmt::format("bottom {}: ", i);
        expectFound("an id", named.c_str(), [&](Structure& s) { reference(s, i)->w ^= 1; });
        expectFound("an id", named.c_str(), [&](Structure& s) { reference(s, i)->w = 0xffffffff; });
        expectFound("an id of another bottom", named.c_str(),
                    [&](Structure& s) { reference(s, i)->w = reference(s, (i + 1) % 3)->w; });
        expectFound("a corner", named.c_str(), [&](Structure& s) { reference(s, i)[2].y ^= 1; });
        expectFound("a kind", named.c_str(), [&](Structure& s) { reference(s, i)[1].w = shared::TRIANGLE_SPHERE; });
    }
    for (auto array : {&Structure::nodes, &Structure::triangles}) {
        EXPECT_NE(foundIn([&](Structure& s) { (s.*array).push_back(uvec4(0)); }), "nothing");
        for (size_t size = 0; size < (built_.*array).size(); size += 1 + size / 16)
            EXPECT_NE(foundIn([&](Structure& s) { (s.*array).resize(size); }), "nothing") << size;
        EXPECT_NE(foundIn([&](Structure& s) { (s.*array).resize((s.*array).size() + 3); }), "nothing");
    }
}

// Where nothing is kept there is one level, ids being the scene's.
TEST(TwoLevelFaults, AreFoundInOneLevelToo) {
    Scene lonely = test::groves().front().scene;
    lonely.instances.resize(1);
    const Geometry geometry = gatherInstances(lonely);
    const PlacedScene scene = placedScene(geometry, {});
    const StructureType& type = structureType("bvh");
    Structure structure = buildTwoLevels(scene, type, {});
    ASSERT_FALSE(structure.isInstanced());
    EXPECT_EQ(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing");
    structure.instances = 1;
    EXPECT_NE(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing");
    structure.instances = 0;
    structure.bottoms.resize(1);
    EXPECT_NE(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing");
    structure.bottoms.clear();
    structure.triangles[0].w ^= 1;
    EXPECT_NE(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing");
    structure.triangles.resize(1);
    EXPECT_NE(nothingOr(findTwoLevelFault(structure, scene, type)), "nothing");
}

// The same arrays over a scene that differs in one place, or in one corner.
TEST_F(DamagedTwoLevels, AreThoseOfOtherScenes) {
    Scene moved = grove_.scene;
    moved.instances[2].toWorld[3].x += 1e-3;
    Geometry other = gatherInstances(moved);
    EXPECT_NE(nothingOr(findTwoLevelFault(built_, placedScene(other, {}), type_)), "nothing");
    other = gatherInstances(grove_.scene);
    other.placed[3].mirrored = !other.placed[3].mirrored;
    EXPECT_NE(nothingOr(findTwoLevelFault(built_, placedScene(other, {}), type_)), "nothing");
    other = gatherInstances(grove_.scene);
    other.positions[5].y += 1e-4f;
    EXPECT_NE(nothingOr(findTwoLevelFault(built_, placedScene(other, {}), type_)), "nothing");
    EXPECT_NE(nothingOr(findTwoLevelFault(built_, placedScene(geometry_, {.leastTriangles = 40}), type_)), "nothing");
}

}  // namespace
}  // namespace raig
