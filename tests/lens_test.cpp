// Depth of field: what is in focus stays sharp, what is not has the thin lens's circle; the same on devices, the CPU and in
// the reference; and without a lens nothing of it is there.
#include "rays/frame_kernels.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

FrameOptions withLens(uint32_t side, uint32_t samples, float aperture, float focus) {
    FrameOptions options = square(side, samples);
    options.aperture = aperture;
    options.focus = focus;
    return options;
}

reference::PictureOptions ofReference(const FrameOptions& frame) {
    reference::PictureOptions options;
    options.width = frame.width;
    options.height = frame.height;
    options.samples = frame.samples;
    options.bounds = {frame.maxDepth, frame.minContribution, frame.seed};
    options.aperture = frame.aperture;
    options.focus = frame.focus;
    options.roundings = 0;
    return options;
}

Camera turned(bool orthographic) {
    Camera camera = lookAt({3, -2, 5}, {0.5f, 1, -1}, 0.8f);
    camera.orthographic = orthographic;
    camera.xmag = camera.ymag = 2.0f;
    return camera;
}

TEST(LensPoints, AreThoseOfTheConcentricMapAndNoNumberIsLeftOut) {
    shared::FrameKernels kernels;
    double worst = 0.0;
    constexpr int steps = 256;
    for (int i = 0; i <= steps; ++i)
        for (int k = 0; k <= steps; ++k) {
            const vec2 square(std::min(i / float(steps), 1.0f - 0x1p-24f), std::min(k / float(steps), 1.0f - 0x1p-24f));
            const double a = 2.0 * square.x - 1.0, b = 2.0 * square.y - 1.0;
            const double radius = std::max(std::abs(a), std::abs(b));  // of the circle that this square becomes
            const dvec2 p = kernels.diskOf(square);
            ASSERT_NEAR(glm::length(p), radius, 0x1p-23);
            // Around a square, angles grow evenly with the way along each quarter.
            if (radius == 0.0) continue;
            const double share = std::abs(a) > std::abs(b) ? b / a : a / b;
            const double angle = std::abs(a) > std::abs(b) ? M_PI / 4 * share : M_PI / 2 - M_PI / 4 * share;
            const double sign = (std::abs(a) > std::abs(b) ? a : b) < 0.0 ? -1.0 : 1.0;
            worst = std::max(worst, glm::length(p - sign * radius * dvec2(std::cos(angle), std::sin(angle))));
        }
    EXPECT_LT(worst, 1.5e-7);
    EXPECT_EQ(kernels.diskOf(vec2(0.5f)), vec2(0.0f));
}

TEST(LensPoints, CoverTheDiskEvenly) {
    shared::FrameKernels kernels;
    constexpr uint32_t count = 65536;
    std::vector<uint32_t> cells(64);  // 8 rings of equal area, in 8 sectors
    for (uint32_t i = 0; i < count; ++i) {
        const dvec2 p = kernels.diskOf(kernels.sampleSquare(/* pixel= */ 5, i, 3, 0));
        const auto ring = std::min(7u, static_cast<uint32_t>(8.0 * glm::dot(p, p)));
        const auto sector = static_cast<uint32_t>(4.0 * (1.0 + std::atan2(p.y, p.x) / M_PI)) % 8;
        ++cells[8 * ring + sector];
    }
    for (const uint32_t found : cells) EXPECT_NEAR(found, count / 64.0, 12.0) << "far less than at random";
}

// The rays of one place in the picture start on the lens and meet where the pinhole's is in focus.
TEST(LensRays, StartOnTheLensAndMeetInFocus) {
    for (const bool orthographic : {false, true}) {
        Scene scene;
        scene.cameras = {turned(orthographic)};
        const Camera& camera = scene.cameras.front();
        const FrameOptions options = withLens(7, 64, 0.9f, 4.0f);
        FrameOptions pinhole = options;
        pinhole.aperture = 0.0f;
        double farthest = 0.0;
        for (uint32_t sample = 0; sample < 64; ++sample) {
            const std::vector<Ray> rays = cameraRays(scene, options, sample), sharp = cameraRays(scene, pinhole, sample);
            for (size_t i = 0; i < rays.size(); ++i) {
                const dvec3 origin = rays[i].origin, way = rays[i].direction;
                const dvec3 from = sharp[i].origin, to = sharp[i].direction;
                const dvec3 forward = camera.forward;
                EXPECT_NEAR(glm::dot(origin - from, forward), 0.0, 1e-6) << "across the axis";
                farthest = std::max(farthest, glm::length(origin - from));
                const dvec3 met = origin + 4.0 / glm::dot(way, forward) * way;
                EXPECT_LT(glm::length(met - (from + 4.0 / glm::dot(to, forward) * to)), 4e-6);
                EXPECT_NEAR(glm::length(way), 1.0, 1e-6);
            }
        }
        EXPECT_LE(farthest, 0.45 + 1e-6);
        EXPECT_GT(farthest, 0.44);
    }
}

TEST(LensRays, AreTheReferences) {
    for (const bool orthographic : {false, true})
        for (const float focus : {0.7f, 4.0f, INFINITY}) {
            Scene scene;
            scene.cameras = {turned(orthographic)};
            const FrameOptions options = withLens(9, 8, 0.5f, focus);
            for (uint32_t sample = 0; sample < 8; ++sample) {
                const std::vector<Ray> rays = cameraRays(scene, options, sample);
                for (uint32_t i = 0; i < rays.size(); ++i) {
                    const reference::Ray want = cameraRay(scene.cameras.front(), ofReference(options), i % 9, i / 9, sample);
                    EXPECT_LT(glm::length(dvec3(rays[i].origin) - want.origin), 1e-6);
                    EXPECT_LT(glm::length(dvec3(rays[i].direction) - want.direction), 4e-7);
                }
            }
        }
}

/// A glowing square of that side across the axis of a camera at the origin that looks along -z, in black.
Scene lampAt(double distance, double side) {
    Scene scene;
    const auto half = static_cast<float>(0.5 * side);
    addQuad(scene, {-half, -half, float(-distance)}, {2 * half, 0, 0}, {0, 2 * half, 0}, glowing(vec3(1.0f)));
    scene.cameras.push_back(lookAt({0, 0, 0}, {0, 0, -1}, 2.0f * std::atan(0.25f)));
    return scene;
}

/// Light, and the mean square of its distance from the middle, in pixels.
struct Spot {
    double light = 0.0;
    double square = 0.0;
    double farthest = 0.0;
};

template <class Colour>
Spot measure(const std::vector<Colour>& radiance, uint32_t side) {
    Spot spot;
    for (size_t i = 0; i < radiance.size(); ++i) {
        if (radiance[i].x == 0) continue;
        const dvec2 place = dvec2(i % side + 0.5, i / side + 0.5) - 0.5 * side;
        spot.light += radiance[i].x;
        spot.square += radiance[i].x * glm::dot(place, place);
        spot.farthest = std::max(spot.farthest, glm::length(place));
    }
    spot.square /= spot.light;
    return spot;
}

// Nearer and farther than what is in focus, on the CPU and in the reference: radius and light of the circle of confusion.
TEST(Lens, BlursWhatIsOutOfFocusToTheThinLensesCircle) {
    constexpr uint32_t side = 40;
    constexpr double focus = 8.0, pixel = 2.0 * 0.25 * focus / side;  // in the plane in focus
    for (const double distance : {5.0, 14.0}) {
        const double aperture = 2.0 * 9.0 * pixel * distance / std::abs(distance - focus);  // for a radius of 9 pixels
        const double lamp = 3.0;                                                            // pixels
        const Stage stage(lampAt(distance, lamp * pixel * distance / focus));
        const FrameOptions options = withLens(side, 256, float(aperture), float(focus));
        const reference::World world(stage.scene, stage.geometry);
        const Spot spots[] = {measure(stage.onCpu(options).radiance, side),
                              measure(render(world, ofReference(options)).radiance, side)};
        for (const Spot& spot : spots) {
            // Of an even disk, half its squared radius; of the lamp, a sixth of its squared side; less what is in a pixel.
            EXPECT_NEAR(spot.square / (81.0 / 2.0 + lamp * lamp / 6.0 - 1.0 / 6.0), 1.0, 0.02) << distance;
            EXPECT_NEAR(spot.light / (lamp * lamp), 1.0, 0.02) << distance;
            EXPECT_LT(spot.farthest, 9.0 + (lamp + 1.0) * std::sqrt(0.5));
            EXPECT_GT(spot.farthest, 9.0);
        }
    }
}

TEST(Lens, LeavesWhatIsInFocusAsSharpAsAPinhole) {
    constexpr double focus = 8.0, pixel = 2.0 * 0.25 * focus / 33;
    const Stage stage(lampAt(focus, 0.4 * pixel));  // within the middle pixel
    FrameOptions options = withLens(33, 256, 1.5f, float(focus));
    const Picture lens = stage.onCpu(options);
    options.aperture = 0.0f;
    const Picture pinhole = stage.onCpu(options);
    EXPECT_NEAR(pinhole.radiance[16 * 33 + 16].x, 0.16, 0.01);
    for (size_t i = 0; i < lens.radiance.size(); ++i)
        EXPECT_NEAR(lens.radiance[i].x, pinhole.radiance[i].x, i == 16 * 33 + 16 ? 1.0 / 256 : 0.0) << i;
}

Scene room() {
    Scene scene = variedRoom();
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 8, true, tintedGlass());
    addTrueSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, metal(vec3(0.9f, 0.8f, 0.5f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    return scene;
}

TEST(Lens, HasTheSameBitsWhateverTheTilesAndThePart) {
    const Stage stage(room());
    FrameOptions options = withLens(31, 3, 0.4f, 6.0f);
    const Picture whole = stage.onCpu(options);
    options.tilePixels = 70;
    EXPECT_EQ(bitsOf(stage.onCpu(options)), bitsOf(whole));
    options.crop = Crop{5, 9, 13, 11};
    const Picture part = stage.onCpu(options);
    for (uint32_t i = 0; i < 13 * 11; ++i) EXPECT_EQ(part.radiance[i], whole.radiance[(9 + i / 13) * 31 + 5 + i % 13]);
}

class LensOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, LensOnDevice, testing::ValuesIn(devicesToTest()), testName);

// A frame is kept for several pictures: with a lens, without, with another.
TEST_P(LensOnDevice, HasTheCpusBitsWithAndWithoutALens) {
    const Stage stage(room());
    Device device(info);
    const auto tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    std::vector<std::vector<uint32_t>> pictures;
    for (const float aperture : {0.0f, 0.4f, 0.0f, 0.05f}) {
        const FrameOptions options = withLens(33, 3, aperture, 6.0f);
        pictures.push_back(bitsOf(frame.render(options)));
        EXPECT_EQ(pictures.back(), bitsOf(stage.onCpu(options))) << aperture;
    }
    EXPECT_NE(pictures[1], pictures[0]);
    EXPECT_EQ(pictures[2], pictures[0]);
    EXPECT_NE(pictures[3], pictures[1]);
}

}  // namespace
}  // namespace raig
