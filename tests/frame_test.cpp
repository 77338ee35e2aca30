// Pictures: the same bits however the work is cut, on every device; every size and depth; nothing left out.
#include "base/error.hpp"
#include "rays/frame_kernels.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// All that shading knows: smooth and flat glass that absorbs, a mirror, a gloss, a texture, vertex colours, an emitter, and
/// lights of every kind.
Scene variedScene() {
    Scene scene = variedRoom();
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 10, true, tintedGlass());
    addSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, 6, false, metal(vec3(0.9f, 0.8f, 0.5f)));
    Material polished = matte(vec3(0.2f, 0.3f, 0.8f));
    polished.roughness = 0.1f;
    addSphere(scene, {0.3f, 0.5f, 2.0f}, 0.5f, 8, true, polished);
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f), .range = 9.0f},
                    {.type = Light::Type::spot, .position = {-3, 4, 2}, .direction = glm::normalize(vec3(1, -1.2f, -0.6f)),
                     .intensity = vec3(12, 10, 4), .innerConeAngle = 0.3f, .outerConeAngle = 0.6f},
                    {.type = Light::Type::directional, .direction = glm::normalize(vec3(-0.3f, -1, -0.4f)),
                     .intensity = vec3(0.4f)}};
    return scene;
}

/// The same where every mesh but the floor and the wall stands three times, one of them mirrored, and glows and mirrors
/// there, too.
Scene plantedScene() {
    Scene scene = variedScene();
    const std::vector<Instance> once = scene.instances;
    for (size_t i = 2; i < once.size(); ++i) {
        const double turn = 0.7 + static_cast<double>(i);
        dmat4 turned(1.0);
        turned[0] = dvec4(std::cos(turn), 0.1, -std::sin(turn), 0);
        turned[2] = dvec4(std::sin(turn), -0.2, std::cos(turn), 0);
        turned[3] = dvec4(1.5, 0.3, -1.0, 1);
        dmat4 mirrored(1.0);
        mirrored[0] = dvec4(-0.8, 0, 0.1, 0);
        mirrored[1].y = 0.6;
        mirrored[3] = dvec4(-0.9, 0.2, -1.5, 1);
        scene.instances.push_back({once[i].mesh, turned});
        scene.instances.push_back({once[i].mesh, mirrored});
    }
    Mesh balls;
    balls.spheres = {{vec3(0, 0.3f, 1.5f), 0.3f}, {vec3(-1.5f, 0.4f, 2.0f), 0.35f}};
    balls.positions = {vec3(1, 0, 2), vec3(2, 0, 2), vec3(1.5f, 0.8f, 2)};
    balls.triangles = {{0, 1, 2}};
    balls.normals.assign(3, vec3(0, 0, 1));
    const auto first = static_cast<uint32_t>(scene.materials.size());
    scene.materials.insert(scene.materials.end(), {matte(vec3(0.5f)), glass(1.4f), metal(vec3(0.7f, 0.8f, 0.9f))});
    balls.materials = {first, first + 1, first + 2};
    scene.meshes.push_back(balls);
    dmat4 half(0.5);
    half[3] = dvec4(0.4, 1.2, 0.6, 1);
    for (const dmat4& m : {dmat4(1.0), half}) scene.instances.push_back({static_cast<uint32_t>(scene.meshes.size() - 1), m});
    return scene;
}

FrameOptions small(uint32_t width, uint32_t height, uint32_t samples = 2) {
    FrameOptions options;
    options.width = width;
    options.height = height;
    options.samples = samples;
    return options;
}

bool isFinite(const Picture& picture) {
    return std::ranges::all_of(picture.radiance, [](const vec3& c) { return raig::isFinite(c); }) &&
           std::ranges::all_of(picture.discarded, [](float d) { return std::isfinite(d) && d >= 0.0f; });
}

// A pixel left out, or done twice, would be seen nowhere else.
TEST(PixelOrder, VisitsEachPixelOnce) {
    for (const uvec2 size :
         {uvec2(1, 1), uvec2(1, 17), uvec2(17, 1), uvec2(8, 8), uvec2(7, 9), uvec2(9, 7), uvec2(65, 33)}) {
        shared::FrameKernels kernels;
        kernels.frame.width = kernels.frame.partWidth = size.x;
        kernels.frame.height = kernels.frame.partHeight = size.y;
        std::vector<uint32_t> visits(size_t{size.x} * size.y);
        for (uint32_t i = 0; i < visits.size(); ++i) ++visits.at(kernels.pixelOf(i));
        EXPECT_EQ(std::ranges::count(visits, 1u), std::ssize(visits)) << size.x << " x " << size.y;
    }
}

TEST(CpuFrame, HasTheSameBitsWhateverTilesThreadsAndRuns) {
    const Stage stage(variedScene());
    FrameOptions options = small(37, 29);
    const std::vector<uint32_t> bits = bitsOf(stage.onCpu(options));
    for (const uint32_t tile : {1u, 7u, 256u, 1000u}) {
        options.tilePixels = tile;
        EXPECT_EQ(bitsOf(stage.onCpu(options)), bits) << "tiles of " << tile;
    }
    tbb::task_arena(1).execute([&] { EXPECT_EQ(bitsOf(stage.onCpu(options)), bits) << "one thread"; });
}

TEST(CpuFrame, HasTheSameBitsWithInstancesKeptAsWithAllWrittenOut) {
    const FrameOptions options = small(48, 36);
    const Stage written(plantedScene());
    const Picture want = written.onCpu(options);
    for (const char* accel : {"bvh", "octree"}) {
        const Stage kept = Stage::kept(plantedScene(), accel);
        EXPECT_TRUE(kept.structure.isInstanced());
        EXPECT_LT(kept.geometry.positions.size(), written.geometry.positions.size() / 2);
        EXPECT_LT(kept.structure.triangles.size(), written.structure.triangles.size() / 2);
        const Picture got = kept.onCpu(options);
        EXPECT_EQ(countDifferent(got, want), 0u) << accel;
        EXPECT_EQ(bitsOf(got), bitsOf(want)) << accel;
    }
    const Stage single = Stage::kept(variedScene());
    EXPECT_FALSE(single.structure.isInstanced()) << "every mesh stands once";
    EXPECT_EQ(bitsOf(single.onCpu(options)), bitsOf(Stage(variedScene()).onCpu(options)));
}

TEST(CpuFrame, HasTheSameBitsWhateverTheStructure) {
    const Stage bvh(variedScene()), brute(variedScene(), "brute");
    EXPECT_EQ(bitsOf(bvh.onCpu(small(32, 24))), bitsOf(brute.onCpu(small(32, 24))));
}

// One row, one column, one pixel, sides that are no multiple of a block.
TEST(CpuFrame, TakesEverySize) {
    const Stage stage(variedScene());
    for (const uvec2 size : {uvec2(1, 1), uvec2(1, 19), uvec2(19, 1), uvec2(13, 11)}) {
        const Picture picture = stage.onCpu(small(size.x, size.y));
        ASSERT_EQ(picture.radiance.size(), size_t{size.x} * size.y);
        EXPECT_TRUE(isFinite(picture));
        EXPECT_TRUE(std::ranges::all_of(picture.radiance, [](const vec3& c) { return c != vec3(0.0f); }));
        EXPECT_GE(picture.statistics.closestRays, 2ull * size.x * size.y);
    }
}

TEST(CpuFrame, GoesNoDeeperThanToldAndAsDeepAsThereIsWeight) {
    const Stage stage(variedScene());
    FrameOptions options = small(24, 24, 1);
    options.minContribution = 0.0f;
    for (const uint32_t depth : {0u, 1u, 5u}) {
        options.maxDepth = depth;
        const Picture picture = stage.onCpu(options);
        EXPECT_EQ(picture.statistics.deepest, depth);
        EXPECT_GT(*std::ranges::max_element(picture.discarded), 0.0f);
    }
    options.maxDepth = 64;
    options.minContribution = 1.0f / 512.0f;
    const Picture deep = stage.onCpu(options);
    EXPECT_GT(deep.statistics.deepest, 8u);
    EXPECT_LE(deep.statistics.deepest, 64u);
    EXPECT_TRUE(isFinite(deep));
}

// Without reflection nothing is cut off.
TEST(CpuFrame, DiscardsNothingWhereNothingReflects) {
    Scene scene;
    addQuad(scene, {-1, -1, 0}, {2, 0, 0}, {0, 2, 0}, matte(vec3(0.5f)));
    scene.cameras.push_back(lookAt({0, 0, 3}, {0, 0, 0}));
    scene.ambient = vec3(1.0f);
    FrameOptions options = small(16, 16);
    options.maxDepth = 0;
    const Picture picture = Stage(scene).onCpu(options);
    EXPECT_EQ(*std::ranges::max_element(picture.discarded), 0.0f);
    EXPECT_EQ(picture.statistics.closestRays, 16u * 16u * 2u);
    EXPECT_EQ(picture.statistics.shadowRays, 0u);
}

TEST(CpuFrame, ReportsProgressThatGrowsToTheEnd) {
    const Stage stage(variedScene());
    FrameOptions options = small(40, 40);
    options.tilePixels = 100;
    double last = 0.0, lastRays = 0.0;
    bool grows = true;
    renderPicture(stage.scene, stage.geometry, *makeCpuTracer(stage.structure), options, [&](double fraction, double rays) {
        grows = grows && fraction >= last && fraction <= 1.0 && rays >= lastRays;
        last = fraction;
        lastRays = rays;
    });
    EXPECT_TRUE(grows);
    EXPECT_EQ(last, 1.0);
}

TEST(CpuFrame, RefusesPicturesAndLightsBeyondReach) {
    Scene scene = variedScene();
    const Stage stage(scene);
    EXPECT_THROW(stage.onCpu(small(65536, 65536)), Error);
    EXPECT_THROW(cameraRays(scene, small(65536, 65536)), Error);
    scene.lights.resize(40000);
    EXPECT_THROW(Stage(scene).onCpu(small(8, 8)), Error);
}

TEST(CameraRays, StartAtTheEyeThroughEachPixelsCentre) {
    Scene scene;
    scene.cameras.push_back(lookAt({1, 2, 3}, {1, 2, 0}, 2.0f * std::atan(0.5f)));
    const std::vector<Ray> rays = cameraRays(scene, small(4, 2, 1));
    ASSERT_EQ(rays.size(), 8u);
    // The upper left pixel's centre, at distance 1: x = -3/4 of half width 1, y = 1/2 of half height 1/2.
    const dvec3 want = glm::normalize(dvec3(-0.75, 0.25, -1.0));
    for (int axis = 0; axis < 3; ++axis) EXPECT_NEAR(rays[0].direction[axis], want[axis], 1e-7);
    EXPECT_EQ(rays[0].origin, vec3(1, 2, 3));
    EXPECT_NEAR(rays[7].direction.x, -rays[0].direction.x, 1e-7f);
    EXPECT_NEAR(rays[7].direction.y, -rays[0].direction.y, 1e-7f);
}

TEST(CameraRays, OfAnOrthographicCameraAreParallelAndKeepTheAspect) {
    Scene scene;
    Camera camera = lookAt({0, 0, 5}, {0, 0, 0});
    camera.orthographic = true;
    camera.xmag = 1.0f;
    camera.ymag = 1.0f;
    scene.cameras.push_back(camera);
    const std::vector<Ray> rays = cameraRays(scene, small(4, 2, 1));
    for (const Ray& ray : rays) EXPECT_EQ(ray.direction, vec3(0, 0, -1));
    EXPECT_NEAR(rays[0].origin.x, -1.5f, 1e-6f);  // widened to 4 : 2
    EXPECT_NEAR(rays[0].origin.y, 0.5f, 1e-6f);
}

/// A device with a scene on it: kernels are compiled once, which takes some devices longer than all the rest.
struct DeviceStage {
    DeviceStage(const DeviceInfo& info, const Stage& stage, const DeviceOptions& options = {})
        : device(info, options), tracer(makeDeviceTracer(device, stage.structure)),
          frame(device, stage.scene, stage.geometry, *tracer) {}
    Device device;
    std::unique_ptr<DeviceTracer> tracer;
    DeviceFrame frame;
};

class FrameOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, FrameOnDevice, testing::ValuesIn(devicesToTest()), testName);

// The same code in the same arithmetic: where + - * / and sqrt are exact no bit may differ, whatever the tiles and the run;
// in sizes that are no multiple of a block, and at any depth.
TEST_P(FrameOnDevice, EqualsTheCpusToTheBitWhateverTheTiles) {
    const Stage stage(variedScene());
    DeviceStage on(info, stage);
    FrameOptions options = small(61, 43, 3);
    const Picture onCpu = stage.onCpu(options), onDevice = on.frame.render(options);
    EXPECT_EQ(countDifferent(onDevice, onCpu), 0u);
    EXPECT_EQ(bitsOf(onDevice), bitsOf(onCpu));
    EXPECT_EQ(onDevice.statistics.deepest, onCpu.statistics.deepest);
    for (const uint32_t tile : {300u, 1000u, 0u}) {
        options.tilePixels = tile;
        EXPECT_EQ(bitsOf(on.frame.render(options)), bitsOf(onCpu)) << "tiles of " << tile;
    }
    for (const uvec2 size : {uvec2(1, 1), uvec2(1, 19), uvec2(19, 1), uvec2(13, 11)})
        EXPECT_EQ(bitsOf(on.frame.render(small(size.x, size.y))), bitsOf(stage.onCpu(small(size.x, size.y))));
    for (const uint32_t depth : {0u, 64u}) {
        options = small(16, 16, 1);
        options.maxDepth = depth;
        EXPECT_EQ(bitsOf(on.frame.render(options)), bitsOf(stage.onCpu(options))) << "depth " << depth;
    }
}

TEST_P(FrameOnDevice, HasTheSameBitsWithInstancesKeptAsWithAllWrittenOut) {
    const FrameOptions options = small(48, 36);
    const Picture want = Stage(plantedScene()).onCpu(options);
    const Stage kept = Stage::kept(plantedScene());
    ASSERT_TRUE(kept.structure.isInstanced());
    DeviceStage on(info, kept);
    const Picture got = on.frame.render(options);
    EXPECT_EQ(countDifferent(got, want), 0u);
    EXPECT_EQ(bitsOf(got), bitsOf(want));
}

TEST_P(FrameOnDevice, HasTheSameBitsFromSplitArrays) {
    const Stage stage(variedScene());
    DeviceStage split(info, stage, {.largestBindingElements = 2048});
    EXPECT_EQ(bitsOf(split.frame.render(small(24, 24))), bitsOf(stage.onCpu(small(24, 24))));
}

TEST_P(FrameOnDevice, HasTheSameBitsFromEitherKindOfLoad) {
    if (!info.prefersTexel) GTEST_SKIP() << info.name << " loads from storage buffers only";
    const Stage stage(variedScene());
    DeviceStage storage(info, stage, {.loadsTexel = false});
    EXPECT_EQ(bitsOf(storage.frame.render(small(24, 24))), bitsOf(stage.onCpu(small(24, 24))));
}

TEST_P(FrameOnDevice, OfAnEmptySceneIsTheSky) {
    Scene scene;
    scene.materials.emplace_back();
    scene.sky = {.zenith = vec3(0.25f), .horizon = vec3(0.25f), .ground = vec3(0.25f)};
    scene.cameras.emplace_back();
    const Stage stage(scene);
    DeviceStage on(info, stage);
    for (const Picture& picture : {on.frame.render(small(9, 5)), stage.onCpu(small(9, 5))})
        for (const vec3& c : picture.radiance) EXPECT_NEAR(c.x, 0.25f, 1e-7f);
}

}  // namespace
}  // namespace raig
