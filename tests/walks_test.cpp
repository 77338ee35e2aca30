// The walks on devices against the walks on the CPU, bit for bit; long ones, on real scenes, and at closed meshes. On soups:
// see matrix_test.cpp.
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "rays/primitives.hpp"
#include "rays/tracer.hpp"
#include "scene/geometry.hpp"
#include "scene/import.hpp"
#include "support/devices.hpp"
#include "support/effort.hpp"
#include "support/soups.hpp"
#include "support/variants.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cstring>

namespace raig {
namespace {

namespace fs = std::filesystem;

std::string describe(const Hit& h) {
    return fmt::format("triangle {} t {:.9g} u {:.9g} v {:.9g}", h.primitive, h.t, h.u, h.v);
}

size_t firstDifference(const std::vector<Hit>& a, const std::vector<Hit>& b) {
    for (size_t i = 0; i < a.size(); ++i)
        if (std::memcmp(&a[i], &b[i], sizeof(Hit)) != 0) return i;
    return a.size();
}

std::vector<Hit> trace(Tracer& tracer, const std::vector<Ray>& rays, Query query = Query::closest) {
    std::vector<Hit> hits(rays.size());
    tracer.trace(rays, hits, query);
    return hits;
}

void expectSame(const std::vector<Hit>& got, const std::vector<Hit>& want, const std::vector<Ray>& rays,
                const std::string& what) {
    const size_t i = firstDifference(got, want);
    ASSERT_EQ(i, rays.size()) << what << " ray " << i << ' ' << test::describe(rays[i]) << "\n got " << describe(got[i])
                              << "\nwant " << describe(want[i]);
}

class EveryDevice : public OnEveryDevice {
protected:
    void SetUp() override {
        OnEveryDevice::SetUp();
        if (!IsSkipped()) device_ = std::make_unique<Device>(info);
    }
    void TearDown() override {
        device_.reset();
        OnEveryDevice::TearDown();
    }

    std::unique_ptr<Device> device_;
};

// A walk that one dispatch does not finish goes on in the next: here 40,000 triangles lie on top of each other.
TEST_P(EveryDevice, TakesUpLongWalksWhereTheyStopped) {
    const Triangle one{vec3(-1, -1, 1), vec3(1, -1, 1), vec3(0, 1, 1)};
    std::vector<Triangle> pile(40'000, one);
    pile.back() = {vec3(-1, -1, 0.5f), vec3(1, -1, 0.5f), vec3(0, 1, 0.5f)};
    std::vector<Ray> rays;
    Random random(4);
    for (int i = 0; i < 100; ++i) rays.push_back({random.inCube(-1, 1) * vec3(1, 1, 0), 0.0f, vec3(0, 0, 1), 10.0f});
    std::vector<test::Variant> variants = {{"bvh", {.walk = "trail"}}};
    for (const StructureType& type : structureTypes()) variants.push_back({std::string(type.name), {}});
    for (const test::Variant& variant : variants) {
        const Structure structure = variant.build(pile);
        const auto device = makeDeviceTracer(*device_, structure);
        const std::vector<Hit> hits = trace(*device, rays);
        expectSame(hits, trace(*makeCpuTracer(structure), rays), rays, structure.name);
        for (const Hit& hit : hits) EXPECT_TRUE(hit.primitive == NO_HIT || hit.primitive == 39'999u);
    }
}

/// Those of the rays whose walk is done in one dispatch, whatever it does in one loop iteration: one that is taken up again
/// may read some nodes twice.
std::vector<Ray> ofShortWalks(const std::vector<Ray>& rays, const Structure& structure) {
    const auto tracer = makeCpuTracer(structure);
    std::vector<Ray> result;
    for (const Ray& ray : rays) {
        Hit hit;
        const WalkCounters counters = tracer->trace(std::span(&ray, 1), std::span(&hit, 1), Query::closest).counters;
        const uint64_t all = counters.nodeFetches + counters.boxTests + counters.triangleTests + counters.linkReads;
        if (all <= 400) result.push_back(ray);
    }
    return result;
}

TEST_P(EveryDevice, CountsWhatTheCpuCounts) {
    const std::vector<Triangle> triangles = test::sphere(40, 1.0, dvec3(0), 0.1);
    const std::vector<Ray> all = test::rays(triangles, /* seed= */ 2, /* count= */ 5000);
    for (const test::Variant& variant : test::walkVariants()) {
        const Structure structure = variant.build(triangles);
        const std::vector<Ray> rays = variant.params.walk == "trail" ? ofShortWalks(all, structure) : all;
        ASSERT_GT(rays.size(), 3000u);
        std::vector<Hit> hits(rays.size());
        const std::string walk = nameOf(variant);
        const WalkCounters cpu = makeCpuTracer(structure)->trace(rays, hits, Query::closest).counters;
        const WalkCounters device =
            makeDeviceTracer(*device_, structure, /* counting= */ true)->trace(rays, hits, Query::closest).counters;
        EXPECT_EQ(device.nodeFetches, cpu.nodeFetches) << walk;
        EXPECT_EQ(device.triangleTests, cpu.triangleTests) << walk;
        EXPECT_EQ(device.boxTests, cpu.boxTests) << walk;
        EXPECT_EQ(device.linkReads, cpu.linkReads) << walk;
        const bool isTrail = variant.params.walk == "trail";
        EXPECT_EQ(cpu.boxTests > 0, variant.structure == "bvh") << walk;
        EXPECT_EQ(cpu.boxTests > cpu.nodeFetches, isTrail) << walk;
        EXPECT_EQ(cpu.linkReads > 0, isTrail) << walk;
        EXPECT_GT(cpu.triangleTests, rays.size() / 10) << walk;
    }
}

// Arrays that one binding cannot hold are split, and the walk reads the same: with a pretended limit of 4,096 elements.
TEST_P(EveryDevice, ReadsArraysThatAreSplit) {
    const std::vector<Triangle> triangles = test::sphere(33, 1.0, dvec3(0), 0.1);
    const Structure structure = structureType("bvh").build(triangles, {.walk = "skip"});
    const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 3, /* count= */ 4000);
    for (const bool texel : {false, true}) {
        Device limited(info, {.loadsTexel = texel, .largestBindingElements = 4096});
        expectSame(trace(*makeDeviceTracer(limited, structure), rays), trace(*makeCpuTracer(structure), rays), rays,
                   texel ? "texel" : "storage");
    }
    Device tiny(info, {.largestBindingElements = 16});
    EXPECT_THROW(makeDeviceTracer(tiny, structure), Error);
}

TEST_P(EveryDevice, WalksRealScenesAsTheCpuAndBruteForceDo) {
    const fs::path scenes = fs::path(RAIG_SOURCE_DIR) / "../shared/scenes";
    if (!fs::exists(scenes)) GTEST_SKIP() << "the real scenes (../shared/scenes) are not here";
    for (const char* file : {"meshes/bunny.ply", "rooms/white_room.glb", "stadium/house_and_bunny.glb"}) {
        const std::vector<Triangle> triangles = primitivesOf(flatten(importScene(scenes / file)));
        const Structure structure = structureType("bvh").build(triangles, {});
        EXPECT_EQ(structureType("bvh").findFault(structure, triangles), std::nullopt) << file;
        const size_t count = test::isLong() ? 1'000'000 : test::affordable(50'000);
        const std::vector<Ray> rays = test::rays(triangles, /* seed= */ 21, count);
        const std::vector<Hit> want = trace(*makeCpuTracer(structure), rays);
        expectSame(trace(*makeDeviceTracer(*device_, structure), rays), want, rays, file);
        const auto expectSameOfFirst = [&](Tracer& tracer, size_t count, const std::string& what) {
            const std::vector<Ray> few(rays.begin(), rays.begin() + static_cast<long>(count));
            expectSame(trace(tracer, few), {want.begin(), want.begin() + static_cast<long>(count)}, few, what);
        };
        // Small things in a large place: structures that cut space test up to 100,000 triangles a ray there.
        const bool stadium = std::string_view(file).starts_with("stadium");
        // Sanitizers make some builders take minutes over the larger scenes.
        const bool affordsOthers = test::slowdown == 1 || std::string_view(file).starts_with("meshes");
        for (const StructureType& type : structureTypes()) {
            if (type.name == "bvh" || type.name == "brute" || !affordsOthers) continue;
            const Structure other = type.build(triangles, {});
            EXPECT_EQ(type.findFault(other, triangles), std::nullopt) << file << ' ' << type.name;
            const size_t few = stadium ? 200 : test::isLong() ? count : 5'000;
            expectSameOfFirst(*makeDeviceTracer(*device_, other), std::min(few, count),
                              std::string(file) + ' ' + other.name);
        }
        const Structure brute = structureType("brute").build(triangles, {});
        expectSameOfFirst(*makeCpuTracer(brute), test::isLong() ? 10'000 : 100, std::string(file) + " brute");
    }
}

/// Rays from random places inside a closed mesh at its vertices and at points of its edges: each must hit.
std::vector<Ray> raysAtEdges(const std::vector<Triangle>& mesh, const dvec3& centre, double reach, uint64_t seed,
                             size_t count) {
    std::vector<Ray> rays(count);
    parallelFor(count, 65536, [&](size_t begin, size_t end) {
        Random random(seed + begin);
        for (size_t i = begin; i < end; ++i) {
            const Triangle& t = mesh[random.below(static_cast<uint32_t>(mesh.size()))];
            const double f = i % 2 == 0 ? 0.0 : random.unit();
            const dvec3 target = glm::mix(dvec3(t.a), dvec3(t.b), f);
            const vec3 origin = vec3(centre + reach * dvec3(random.inCube(-1, 1)));
            rays[i] = {origin, 0.0f, vec3(target - dvec3(origin)), std::numeric_limits<float>::infinity()};
        }
    });
    return rays;
}

TEST_P(EveryDevice, LetsNoRayLeakOutOfAClosedMesh) {
    // From the origin to far away, from tiny to huge; the far place is the one that Embree's own watertightness test uses.
    struct Place {
        dvec3 centre;
        double radius;
        uint32_t rings;
    };
    const Place places[] = {{dvec3(0), 2.0, 100},
                            {dvec3(148376, 1234, -223423), 2.0, 50},
                            {dvec3(1e6), 2.0, 12},
                            {dvec3(0), 2e-13, 100},
                            {dvec3(0), 2e9, 100}};
    const size_t total = test::isLong() ? 10'000'000 : test::affordable(200'000);
    for (const Place& place : places) {
        // Coarse enough that rounding the corners leaves every triangle an area: one without is left out, and joins nothing.
        const std::vector<Triangle> mesh = test::sphere(place.rings, place.radius, place.centre, 0.1);
        ASSERT_TRUE(std::all_of(mesh.begin(), mesh.end(), [](const Triangle& t) { return t.usable(); })) << place.radius;
        const Structure structure = structureType("bvh").build(mesh, {});
        const auto tracer = makeDeviceTracer(*device_, structure);
        size_t missed = 0;
        for (size_t first = 0; first < total; first += 1'000'000) {
            const size_t count = std::min<size_t>(1'000'000, total - first);
            const std::vector<Ray> rays = raysAtEdges(mesh, place.centre, 0.3 * place.radius, 77 + first, count);
            const std::vector<Hit> hits = trace(*tracer, rays);
            for (size_t i = 0; i < count; ++i) missed += hits[i].primitive == NO_HIT;
        }
        EXPECT_EQ(missed, 0u) << "of " << total << " at radius " << place.radius << " around " << place.centre.x;
    }
}

INSTANTIATE_TEST_SUITE_P(, EveryDevice, testing::ValuesIn(devicesToTest()), testName);

}  // namespace
}  // namespace raig
