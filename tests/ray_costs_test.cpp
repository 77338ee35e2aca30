// What the rays of a pixel cost, and how deep they go: counted alike everywhere, and to the side of the picture.
#include "support/devices.hpp"
#include "support/effort.hpp"
#include "support/rendering.hpp"

#include <algorithm>
#include <numeric>

namespace raig {
namespace {

using namespace test;

FrameOptions counting(FrameOptions options) {
    options.keepsLevels = options.countsCosts = true;
    return options;
}

/// Glass and mirrors between walls, under three lights; small meshes in several places.
Scene manyRays() {
    Scene scene = variedRoom();
    const uint32_t ball = addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 10, true, tintedGlass());
    addTrueSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, metal(vec3(0.9f, 0.8f, 0.5f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    scene.lights = {
        {.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)},
        {.type = Light::Type::directional, .direction = glm::normalize(vec3(-0.3f, -1, -0.4f)), .intensity = vec3(0.4f)}};
    dmat4 moved(0.6);
    moved[3] = dvec4(2.0, 0.8, 2.0, 1);
    scene.instances.push_back({ball, moved});
    return scene;
}

/// Sums what another tracer counts.
class SummingTracer : public Tracer {
public:
    explicit SummingTracer(const Structure& structure) : tracer(makeCpuTracer(structure)) {}
    TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) override {
        return summed(tracer->trace(rays, hits, query));
    }
    TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) override {
        return summed(tracer->traceShadows(rays, hits));
    }
    TraceReport traceCosts(std::span<const Ray>, std::span<Hit>, Query, bool, std::span<uint32_t>) override {
        ADD_FAILURE() << "costs are not asked for";
        return {};
    }
    uint64_t sum = 0;

private:
    TraceReport summed(const TraceReport& report) {
        sum += report.counters.nodeFetches + report.counters.triangleTests;
        return report;
    }
    std::unique_ptr<Tracer> tracer;
};

TEST(Costs, OfAllPixelsAreWhatTheWalksCountInAll) {
    for (const char* accel : {"bvh", "grid", "brute"}) {
        const Stage stage(manyRays(), accel);
        SummingTracer tracer(stage.structure);
        const Picture plain = renderPicture(stage.scene, stage.geometry, tracer, square(24, 2));
        const Picture counted = stage.onCpu(counting(square(24, 2)));
        EXPECT_EQ(std::accumulate(counted.costs.begin(), counted.costs.end(), uint64_t{0}), tracer.sum) << accel;
        EXPECT_EQ(bitsOf(counted), bitsOf(plain)) << accel << ": counting changed the picture";
        EXPECT_TRUE(plain.costs.empty() && plain.levels.empty());
    }
}

// Without a structure each camera ray tries every triangle, and in this scene there are no others.
TEST(Costs, OfBruteForceAreTheSameInEveryPixel) {
    Scene scene;
    addSphere(scene, vec3(0.0f), 1.0f, 6, false, matte(vec3(0.5f)));
    scene.cameras.push_back(lookAt({0, 0, 3}, {0, 0, 0}));
    const Stage stage(scene, "brute");
    const Picture one = stage.onCpu(counting(square(16, 1))), three = stage.onCpu(counting(square(16, 3)));
    EXPECT_GE(one.costs.front(), stage.geometry.triangles.size());
    EXPECT_EQ(std::ranges::count(one.costs, one.costs.front()), std::ssize(one.costs));
    EXPECT_EQ(std::ranges::count(three.costs, 3 * one.costs.front()), std::ssize(three.costs));
}

// A mirror ball under a sky: who sees it sees one reflection.
TEST(Levels, AreOfThePixelsOwnRays) {
    Scene scene = whiteSky();
    addTrueSphere(scene, vec3(0.0f), 1.0f, metal(vec3(0.9f)));
    const Stage stage(scene);
    const FrameOptions options = counting(square(33, 1));
    const Picture picture = stage.onCpu(options);
    const std::vector<Ray> rays = cameraRays(scene, options);
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(stage.structure)->trace(rays, hits, Query::closest);
    for (size_t i = 0; i < hits.size(); ++i) EXPECT_EQ(picture.levels[i], hits[i].primitive == NO_HIT ? 0u : 1u);
    EXPECT_EQ(picture.statistics.deepest, *std::ranges::max_element(picture.levels));
}

class CostsOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, CostsOnDevice, testing::ValuesIn(devicesToTest()), testName);

// The same walk takes the same steps, in one dispatch or in pieces, one ray at a time or two.
TEST_P(CostsOnDevice, AndLevelsAreTheCpus) {
    Device device(info);
    std::vector<const char*> accels = {"bvh", "brute"};  // brute: of walks too long for one dispatch
    if (isLong()) accels.insert(accels.end(), {"kdtree", "octree", "grid", "bsp"});
    for (const char* accel : accels)
        for (const bool keeps : {false, true}) {
            if (keeps && accel == std::string("brute")) continue;
            const Stage stage = keeps ? Stage::kept(manyRays(), accel) : Stage(manyRays(), accel);
            const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
            DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
            FrameOptions options = counting(square(24, 2));
            options.tilePixels = 250;
            const Picture want = stage.onCpu(options), got = frame.render(options);
            EXPECT_EQ(got.costs, want.costs) << accel << (keeps ? ", kept" : "");
            EXPECT_EQ(got.levels, want.levels) << accel;
            EXPECT_EQ(bitsOf(got), bitsOf(want)) << accel;
            options.countsCosts = false;
            EXPECT_EQ(bitsOf(frame.render(options)), bitsOf(want)) << accel << ": counting changed the picture";
        }
}

}  // namespace
}  // namespace raig
