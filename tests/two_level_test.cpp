// Scenes kept as instances against the same scenes written out: the same hits, to the bit, from every structure.
#include "structures/two_level.hpp"

#include "base/error.hpp"
#include "base/random.hpp"
#include "rays/lights.hpp"
#include "rays/placed_scene.hpp"
#include "rays/primitives.hpp"
#include "rays/tracer.hpp"
#include "structures/instance_record.hpp"
#include "support/devices.hpp"
#include "support/effort.hpp"
#include "support/groves.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace raig {
namespace {

using test::Grove;

/// A grove with what it is compared with. The truth is brute force over the triangles written out.
struct Case {
    explicit Case(const Grove& grove, size_t rayCount, uint64_t seed = 5)
        : name(grove.name), geometry(gatherInstances(grove.scene)), triangles(primitivesOf(flatten(grove.scene))) {
        if (triangles.empty()) return;
        rays = test::rays(triangles, seed, rayCount);
        closest.resize(rays.size());
        const Structure brute = structureType("brute").build(triangles, {});
        makeCpuTracer(brute)->trace(rays, closest, Query::closest);
    }
    Structure build(const std::string& structure, const BuildParams& params = {}) const {
        return buildTwoLevels(placedScene(geometry, {}), structureType(structure), params);
    }

    std::string name;
    Geometry geometry;
    std::vector<Triangle> triangles;
    std::vector<Ray> rays;
    std::vector<Hit> closest;
};

std::string describe(const Hit& h) {
    return fmt::format("triangle {} t {:.9g} u {:.9g} v {:.9g}", h.primitive, h.t, h.u, h.v);
}

void expectTheTruth(Tracer& tracer, const Case& c, const std::string& what) {
    std::vector<Hit> hits(c.rays.size());
    tracer.trace(c.rays, hits, Query::closest);
    for (size_t i = 0; i < hits.size(); ++i)
        ASSERT_EQ(std::memcmp(&hits[i], &c.closest[i], sizeof(Hit)), 0)
            << what << " ray " << i << ' ' << test::describe(c.rays[i]) << "\n got " << describe(hits[i]) << "\nwant "
            << describe(c.closest[i]);
    tracer.trace(c.rays, hits, Query::any);
    for (size_t i = 0; i < hits.size(); ++i)
        ASSERT_EQ(hits[i].primitive == NO_HIT, c.closest[i].primitive == NO_HIT)
            << what << " any, ray " << i << ' ' << test::describe(c.rays[i]);
}

struct Variant {
    std::string structure;
    BuildParams params;
};

std::vector<Variant> variants() {
    std::vector<Variant> result;
    for (const StructureType& type : structureTypes()) result.push_back({std::string(type.name), {}});
    result.push_back({"bvh", {.walk = "skip"}});
    result.push_back({"bvh", {.precision = 16}});
    result.push_back({"bvh", {.precision = 32}});
    result.push_back({"bvh", {.build = "sbvh", .maxLeaf = 1}});
    for (const char* bound : {"sphere", "obb", "kdop"}) result.push_back({"bvh", {.bound = bound}});
    result.push_back({"bvh", {.walk = "trail"}});
    for (const uint32_t arity : {2, 8}) result.push_back({"bvh", {.walk = "trail", .arity = arity, .precision = 8}});
    result.push_back({"kdtree", {.walk = "restart"}});
    result.push_back({"kdtree", {.build = "median"}});
    result.push_back({"grid", {.levels = 1}});
    result.push_back({"grid", {.gridDensity = 20.0f}});
    result.push_back({"octree", {.maxLeaf = 1}});
    return result;
}

/// The record of instance `i` of a structure of two levels.
uvec4* recordOf(Structure& structure, uint32_t i) {
    const auto at = static_cast<size_t>(structure.header.gridStep.y) * shared::INSTANCES_UNIT;
    return &structure.nodes[at + size_t{i} * shared::INSTANCE_STRIDE];
}

size_t countKept(const Structure& structure) {
    return structure.instances - std::count_if(structure.bottoms.begin(), structure.bottoms.end(), [](const Bottom& bottom) {
               return bottom.mesh == Bottom::writtenOut;
           });
}

TEST(TwoLevels, HaveTheHitsOfTheSceneWrittenOutToTheBit) {
    size_t instances = 0, rays = 0;
    for (const Grove& grove : test::groves()) {
        const Case c(grove, test::isLong() ? 100'000 : test::affordable(1'500));
        for (const Variant& variant : variants()) {
            const Structure structure = c.build(variant.structure, variant.params);
            const std::string what = c.name + ' ' + variant.structure + ' ' + describeOptions(variant.params);
            instances += structure.instances;
            rays += c.rays.size();
            expectTheTruth(*makeCpuTracer(structure), c, what);
            if (HasFatalFailure()) return;
        }
    }
    EXPECT_GT(instances, 100u * variants().size()) << "next to nothing was kept";
    EXPECT_GE(rays, test::affordable(100'000));
}

// Were a mesh's own space walked with the slack of its own distances only, rays at vertices and edges would slip past boxes.
TEST(TwoLevels, NeedTheSlackThatPlacingTakes) {
    size_t different = 0;
    for (const Grove& grove : test::groves()) {
        if (grove.name != "sizes" && grove.name != "displaced" && grove.name != "away") continue;
        const Case c(grove, 8'000);
        Structure structure = c.build("bvh", {.precision = 32, .maxLeaf = 1});
        for (uint32_t i = 0; i < structure.instances; ++i) recordOf(structure, i)[7].z = recordOf(structure, i)[7].w = 0;
        std::vector<Hit> hits(c.rays.size());
        makeCpuTracer(structure)->trace(c.rays, hits, Query::closest);
        for (size_t i = 0; i < hits.size(); ++i) different += std::memcmp(&hits[i], &c.closest[i], sizeof(Hit)) != 0;
    }
    EXPECT_GT(different, 0u) << "the rays are too tame to tell";
}

// From far away, where a ray's rounding is larger than what it looks at.
TEST(TwoLevels, AreWalkedFromVeryFarAway) {
    Case c(test::groves().front(), 0);
    for (const double distance : {1e3, 1e6, 1e9, 1e15})
        for (uint32_t octant = 0; octant < 8; ++octant) {
            const dvec3 from(octant & 1 ? 1 : -0.7, octant & 2 ? 0.9 : -1, octant & 4 ? 0.8 : -1.1);
            c.rays.push_back({vec3(from * distance), 0.0f, vec3(-from), std::numeric_limits<float>::infinity()});
        }
    c.closest.resize(c.rays.size());
    const Structure brute = structureType("brute").build(c.triangles, {});
    makeCpuTracer(brute)->trace(c.rays, c.closest, Query::closest);
    for (const StructureType& type : structureTypes())
        expectTheTruth(*makeCpuTracer(c.build(std::string(type.name))), c, "far away " + std::string(type.name));
}

TEST(TwoLevels, SayThatTheyAreCorruptWhereTheTopTreeLeadsAround) {
    const Case c(test::groves().front(), 200);
    Structure structure = c.build("bvh");
    for (uint32_t octant = 0; octant < 8; ++octant)
        for (uint32_t i = 1; i < structure.header.nodeCount; ++i) {
            uint32_t& word = structure.nodes[2 * (size_t{octant} * structure.header.nodeCount + i)].w;
            if (word < shared::TOP_LEAF) word = 1;
        }
    std::vector<Hit> hits(c.rays.size());
    EXPECT_THROW(makeCpuTracer(structure)->trace(c.rays, hits, Query::closest), CorruptStructure);
}

TEST(TwoLevels, StoreWhatIsKeptOnce) {
    Scene scene = test::groves().front().scene;
    const Structure few = buildTwoLevels(placedScene(gatherInstances(scene), {}), structureType("bvh"), {});
    const std::vector<Instance> once = scene.instances;
    for (int i = 0; i < 20; ++i) scene.instances.insert(scene.instances.end(), once.begin(), once.end() - 1);
    const Geometry geometry = gatherInstances(scene);
    const Structure many = buildTwoLevels(placedScene(geometry, {}), structureType("bvh"), {});
    EXPECT_EQ(many.triangles.size(), few.triangles.size());
    EXPECT_EQ(countKept(many), 21u * countKept(few));
    EXPECT_EQ(geometry.triangleCount(), flatten(scene).triangles.size());
    EXPECT_EQ(geometry.bounds.lo, flatten(scene).bounds.lo);
    EXPECT_EQ(geometry.bounds.hi, flatten(scene).bounds.hi);
    EXPECT_EQ(geometry.dropped.zeroArea, flatten(scene).dropped.zeroArea);
    EXPECT_EQ(geometry.dropped.nonFinite, flatten(scene).dropped.nonFinite);
}

dmat4 scaledBy(const dvec3& s) {
    return dmat4(dvec4(s.x, 0, 0, 0), dvec4(0, s.y, 0, 0), dvec4(0, 0, s.z, 0), dvec4(0, 0, 0, 1));
}

TEST(TwoLevels, KeepWithinTheMemoryBudget) {
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes.push_back(test::groves().front().scene.meshes.front());
    for (int i = 0; i < 20'000; ++i) {
        dmat4 place(1.0);
        place[3] = dvec4(3 * (i % 200), 0, 3 * (i / 200), 1);
        scene.instances.push_back({0, place});
    }
    const Geometry geometry = gatherInstances(scene);
    const PlacedScene placed = placedScene(geometry, {});
    const Structure structure = buildTwoLevels(placed, structureType("bvh"), {});
    const uint64_t bytes = structure.statistics.bytes;
    EXPECT_GT(bytes, uint64_t{20'000} * shared::INSTANCE_STRIDE * sizeof(uvec4));
    EXPECT_LE(buildTwoLevels(placed, structureType("bvh"), {.memoryBudget = bytes + (1 << 16)}).statistics.bytes, bytes);
    EXPECT_THROW(buildTwoLevels(placed, structureType("bvh"), {.memoryBudget = bytes / 2}), Error);
}

TEST(TwoLevels, WriteOutInstancesThatCannotBeWalkedInTheirOwnSpace) {
    const Box box{vec3(-1), vec3(1)};
    const auto isKept = [&](const dmat4& m) { return fits(placementOf(m), box, 2.0f); };
    const double nan = std::numeric_limits<double>::quiet_NaN(), infinity = std::numeric_limits<double>::infinity();
    for (const dvec3 s : {dvec3(1), dvec3(-1, 1, 1), dvec3(1e-3), dvec3(1e-7), dvec3(1e-30), dvec3(1, 8, 3),
                          dvec3(0.2, 1, 1), dvec3(1, 1, 0.01)})
        EXPECT_TRUE(isKept(scaledBy(s))) << s.x << ' ' << s.y << ' ' << s.z;
    for (const dvec3 s : {dvec3(0), dvec3(1, 1, 0), dvec3(1, 1, 1e-8), dvec3(1, 1e-30, 1), dvec3(nan, 1, 1),
                          dvec3(infinity, 1, 1), dvec3(1e-4, 1, 1e4)})
        EXPECT_FALSE(isKept(scaledBy(s))) << s.x << ' ' << s.y << ' ' << s.z;
    EXPECT_FALSE(fits(placementOf(dmat4(1.0)), Box{}, 2.0f)) << "nothing to keep";
    // Very far from the origin vertices are as coarse as the mesh.
    dmat4 far(1.0);
    far[3] = dvec4(1e7, 0, 0, 1);
    EXPECT_FALSE(isKept(far));

    Scene scene = test::groves().front().scene;
    const auto keptOf = [&](const dvec3& s) {
        Scene more = scene;
        more.instances.push_back({0, scaledBy(s)});
        return countKept(buildTwoLevels(placedScene(gatherInstances(more), {}), structureType("brute"), {}));
    };
    const size_t before = countKept(buildTwoLevels(placedScene(gatherInstances(scene), {}), structureType("brute"), {}));
    EXPECT_GT(before, 10u);
    EXPECT_EQ(keptOf(dvec3(1)), before + 1);
    EXPECT_EQ(keptOf(dvec3(1, 1, 0)), before) << "and the others stay";
    EXPECT_EQ(keptOf(dvec3(0)), before);
}

TEST(TwoLevels, AreWorthItWhereWritingOutDoublesTheTriangles) {
    Scene scene;
    scene.meshes.resize(2);
    scene.meshes[0].triangles.resize(100);
    scene.meshes[1].triangles.resize(10);
    const auto worth = [&](const std::vector<uint32_t>& meshes) {
        scene.instances.clear();
        for (const uint32_t mesh : meshes) scene.instances.push_back({mesh, dmat4(1.0)});
        return isWorthKeeping(countTriangles(scene, worthwhile));
    };
    EXPECT_FALSE(worth({}));
    EXPECT_FALSE(worth({0, 1}));
    EXPECT_TRUE(worth({0, 0}));
    EXPECT_FALSE(worth({0, 0, 1})) << "210 written out, 110 stored";
    EXPECT_TRUE(worth({0, 0, 0, 1}));
    EXPECT_FALSE(worth({1, 1, 1, 1})) << "too small to be worth a record each";
}

TEST(TwoLevels, LetLightThroughWhereTheSceneWrittenOutDoes) {
    Scene scene = test::groves().front().scene;
    scene.materials.resize(2);
    scene.materials[1].transmission = 1.0f;
    for (Mesh& mesh : scene.meshes)
        for (size_t i = 0; i < mesh.materials.size(); i += 2) mesh.materials[i] = 1;
    const Case c({"light", scene}, 3000);
    const Geometry flat = flatten(scene);
    Structure brute = structureType("brute").build(c.triangles, {});
    markSeeThrough(scene, flat, brute);
    std::vector<Hit> want(c.rays.size()), got(c.rays.size());
    makeCpuTracer(brute)->traceShadows(c.rays, want);
    for (const char* name : {"bvh", "kdtree"}) {
        Structure structure = c.build(name);
        markSeeThrough(scene, c.geometry, structure);
        makeCpuTracer(structure)->traceShadows(c.rays, got);
        size_t different = 0;
        for (size_t i = 0; i < got.size(); ++i) different += (got[i].primitive == NO_HIT) != (want[i].primitive == NO_HIT);
        EXPECT_EQ(different, 0u) << name;
    }
}

class TwoLevelsOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, TwoLevelsOnDevice, testing::ValuesIn(devicesToTest()), testName);

// Compiling a kernel takes far longer than these rays: bvh sees all groves, other structures one; in a long run each sees
// everything.
TEST_P(TwoLevelsOnDevice, HaveTheHitsOfTheSceneWrittenOutToTheBit) {
    Device device(info);
    for (const Grove& grove : test::groves()) {
        const Case c(grove, test::isLong() ? 50'000 : test::affordable(4'000));
        if (c.triangles.empty()) continue;
        for (const Variant& variant : variants()) {
            const bool plain = describeOptions(variant.params).empty(), bvh = plain && variant.structure == "bvh";
            if (!test::isLong() && !bvh && !(plain && c.name == "sizes")) continue;
            const Structure structure = c.build(variant.structure, variant.params);
            const auto tracer = makeDeviceTracer(device, structure);
            expectTheTruth(*tracer, c, c.name + ' ' + variant.structure + ' ' + describeOptions(variant.params));
            if (HasFatalFailure()) return;
        }
    }
}

// Walks that one dispatch does not finish go on in the next, in whichever instance they were: 40 piles of 1,500 triangles
// each, all in the same place but for the last triangle of each pile.
TEST_P(TwoLevelsOnDevice, TakeUpLongWalksWhereTheyStopped) {
    Device device(info);
    Mesh pile;
    pile.positions = {vec3(-1, -1, 1),    vec3(1, -1, 1),    vec3(0, 1, 1),
                      vec3(-1, -1, 0.5f), vec3(1, -1, 0.5f), vec3(0, 1, 0.5f)};
    pile.triangles.assign(1'500, {0, 1, 2});
    pile.triangles.back() = {3, 4, 5};
    pile.materials.assign(1'500, 0);
    Scene scene;
    scene.materials.emplace_back();
    scene.meshes = {pile};
    for (int i = 0; i < 40; ++i) {
        dmat4 turned = scaledBy({1, 1, 1});
        turned[3] = dvec4(0, 0, i == 17 ? -0.125 : 0.0, 1);
        scene.instances.push_back({0, turned});
    }
    Case c({"piles", scene}, 0);
    Random random(4);
    for (int i = 0; i < 60; ++i) c.rays.push_back({random.inCube(-1, 1) * vec3(1, 1, 0), 0.0f, vec3(0, 0, 1), 10.0f});
    c.closest.resize(c.rays.size());
    makeCpuTracer(structureType("bvh").build(c.triangles, {}))->trace(c.rays, c.closest, Query::closest);
    for (const char* name : {"bvh", "brute", "kdtree"}) {
        const Structure structure = c.build(name);
        EXPECT_EQ(countKept(structure), 40u);
        expectTheTruth(*makeDeviceTracer(device, structure), c, std::string("piles ") + name);
        if (HasFatalFailure()) return;
    }
}

TEST_P(TwoLevelsOnDevice, CountWhatTheCpuCounts) {
    Device device(info);
    const Case c(test::groves().front(), 3000);
    std::vector<Hit> hits(c.rays.size());
    for (const char* name : {"bvh", "kdtree"}) {
        const Structure structure = c.build(name);
        const WalkCounters cpu = makeCpuTracer(structure)->trace(c.rays, hits, Query::closest).counters;
        const WalkCounters counted =
            makeDeviceTracer(device, structure, /* counting= */ true)->trace(c.rays, hits, Query::closest).counters;
        EXPECT_EQ(counted.nodeFetches, cpu.nodeFetches) << name;
        EXPECT_EQ(counted.triangleTests, cpu.triangleTests) << name;
        EXPECT_EQ(counted.boxTests, cpu.boxTests) << name;
    }
}

}  // namespace
}  // namespace raig
