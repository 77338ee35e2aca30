// Pixel filters: samples lie as densely as the filter says; the same on devices, the CPU and in the reference; and for boxes
// nothing changes.
#include "rays/frame_kernels.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

FrameOptions filteredBy(Filter filter, uint32_t side, uint32_t samples) {
    FrameOptions options = square(side, samples);
    options.filter = filter;
    return options;
}

Scene softScene() {
    Scene scene = variedRoom();
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 8, true, tintedGlass());
    addSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, 6, false, metal(vec3(0.9f, 0.8f, 0.5f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    return scene;
}

// The share of the filter below each sample's place is its number again.
TEST(Filters, PlaceSamplesByTheirCumulatedWeight) {
    shared::FrameKernels kernels;
    double last = -2.0, lastGauss = -2.0;
    constexpr uint32_t steps = 1u << 16;
    for (uint32_t i = 0; i < steps; ++i) {
        const float x = static_cast<float>(i) / steps;
        const double tent = kernels.tentPlace(x), gauss = kernels.gaussPlace(x);
        const double below = tent < 0.0 ? 0.5 * (1 + tent) * (1 + tent) : 1 - 0.5 * (1 - tent) * (1 - tent);
        ASSERT_NEAR(below, x, 1e-7);
        ASSERT_NEAR((0.5 * std::erfc(-gauss * std::sqrt(2.0)) - 0.02425) / 0.9515, x, 3e-7);
        ASSERT_GE(tent, last);
        ASSERT_GE(gauss, lastGauss);
        last = tent;
        lastGauss = gauss;
    }
    const float end = 1.0f - 0x1p-24f;
    EXPECT_EQ(kernels.tentPlace(0.0f), -1.0f);
    EXPECT_LE(kernels.tentPlace(end), 1.0f);
    EXPECT_NEAR(kernels.gaussPlace(0.0f), -0.9864806, 3e-7);
    EXPECT_EQ(kernels.gaussPlace(0.0f), -kernels.gaussPlace(1.0f));
    EXPECT_EQ(kernels.gaussPlace(0.5f), 0.0f);
}

// A wall that is white on one side of an edge: what a pixel has of it is the filter's share on that side.
TEST(Filters, BlurAnEdgeByTheirCumulatedWeight) {
    Scene scene;
    Camera camera = lookAt({0, 0, 4}, {0, 0, 0});
    camera.orthographic = true;
    camera.xmag = camera.ymag = 4.0f;  // a picture of 8 pixels: each is a unit
    scene.cameras.push_back(camera);
    scene.ambient = vec3(1.0f);
    addQuad(scene, {-9, -9, 0}, {9.25f, 0, 0}, {0, 18, 0}, matte(vec3(1.0f)));
    const Stage stage(scene);
    for (const Filter filter : {Filter::box, Filter::tent, Filter::gauss}) {
        const Picture picture = stage.onCpu(filteredBy(filter, 8, 1024));
        for (uint32_t x = 0; x < 8; ++x) {
            const double edge = 0.25 - (x - 3.5);  // from the pixel's middle
            double want = 0.0;
            if (filter == Filter::box) want = std::clamp(edge + 0.5, 0.0, 1.0);
            if (filter == Filter::tent) {
                const double e = std::clamp(edge, -1.0, 1.0);
                want = e < 0.0 ? 0.5 * (1 + e) * (1 + e) : 1 - 0.5 * (1 - e) * (1 - e);
            }
            if (filter == Filter::gauss)
                want = std::clamp((0.5 * std::erfc(-edge * std::sqrt(2.0)) - 0.02425) / 0.9515, 0.0, 1.0);
            EXPECT_NEAR(picture.radiance[8 * 4 + x].x, want, 1.1 / 1024) << "one stratum; pixel " << x;
        }
    }
}

TEST(Filters, ChangeNothingOfASingleSample) {
    const Stage stage(softScene());
    const std::vector<uint32_t> bits = bitsOf(stage.onCpu(filteredBy(Filter::box, 16, 1)));
    EXPECT_EQ(bitsOf(stage.onCpu(filteredBy(Filter::tent, 16, 1))), bits);
    EXPECT_EQ(bitsOf(stage.onCpu(filteredBy(Filter::gauss, 16, 1))), bits);
    EXPECT_NE(bitsOf(stage.onCpu(filteredBy(Filter::gauss, 16, 4))), bitsOf(stage.onCpu(filteredBy(Filter::box, 16, 4))));
}

TEST(Filters, OfTheReferenceAreTheSame) {
    const Scene scene = softScene();
    for (const Filter filter : {Filter::tent, Filter::gauss}) {
        FrameOptions options = filteredBy(filter, 16, 4);
        reference::PictureOptions expected;
        expected.width = expected.height = 16;
        expected.samples = 4;
        expected.filter = filter;
        for (uint32_t sample = 0; sample < 4; ++sample) {
            const std::vector<Ray> rays = cameraRays(scene, options, sample);
            for (uint32_t y = 0; y < 16; ++y)
                for (uint32_t x = 0; x < 16; ++x) {
                    const reference::Ray want = reference::cameraRay(scene.cameras[0], expected, x, y, sample);
                    ASSERT_LT(glm::length(dvec3(rays[y * 16 + x].direction) - want.direction), 1e-6);
                }
        }
    }
}

class FilterOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, FilterOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(FilterOnDevice, HasTheCpusBits) {
    const Stage stage(softScene());
    Device device(info);
    const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    for (const Filter filter : {Filter::tent, Filter::gauss, Filter::box}) {
        const FrameOptions options = filteredBy(filter, 27, 3);
        EXPECT_EQ(bitsOf(frame.render(options)), bitsOf(stage.onCpu(options)));
    }
}

}  // namespace
}  // namespace raig
