// Cameras moved and turned by hand, and parts of pictures: against the definition of the rays, and the whole picture's bits.
#include "base/error.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// A camera of a file: it rolls, and looks at nothing in particular.
Camera rolled(bool mirrors = false) {
    Camera camera;
    camera.eye = {1, 2, 3};
    camera.forward = vec3(glm::normalize(dvec3(1, -2, -4)));
    camera.up = vec3(glm::normalize(glm::cross(glm::cross(dvec3(1, -2, -4), dvec3(0.3, 1, 0.2)), dvec3(1, -2, -4))));
    camera.right = glm::cross(camera.forward, camera.up) * (mirrors ? -1.0f : 1.0f);
    camera.yfov = 0.9f;
    return camera;
}

/// The ray through the middle of pixel (x, y) of 9 x 5, by the words of the options.
dvec3 definedDirection(const dvec3& eye, const dvec3& at, const dvec3& up, double yfov, uint32_t x, uint32_t y) {
    const dvec3 forward = glm::normalize(at - eye), right = glm::normalize(glm::cross(forward, up));
    const dvec3 upwards = glm::cross(right, forward);
    const double tall = std::tan(0.5 * yfov), wide = tall * 9.0 / 5.0;
    return glm::normalize(forward + ((x + 0.5) / 4.5 - 1.0) * wide * right + (1.0 - (y + 0.5) / 2.5) * tall * upwards);
}

void expectRays(const Camera& camera, const dvec3& eye, const dvec3& at, const dvec3& up, double yfov) {
    Scene scene;
    scene.cameras = {camera};
    FrameOptions options;
    options.width = 9;
    options.height = 5;
    options.samples = 1;
    const std::vector<Ray> rays = cameraRays(scene, options);
    for (uint32_t i = 0; i < rays.size(); ++i) {
        const dvec3 want = definedDirection(eye, at, up, yfov, i % 9, i / 9);
        EXPECT_LT(glm::length(dvec3(rays[i].direction) - want), 4e-7) << "pixel " << i;
        EXPECT_EQ(rays[i].origin, vec3(eye));
    }
}

TEST(ChangedView, IsSeenFromTheEyeTowardsThePointWithUpUpwards) {
    const std::array<vec3, 4> eyes{vec3(0, 0, 5), vec3(-3, 2, 1), vec3(1e4f, -2e4f, 3e3f), vec3(1e-5f, 2e-5f, 0)};
    const std::array<vec3, 3> ups{vec3(0, 1, 0), vec3(0, 0, -7), vec3(1e-3f, 2e-3f, 3e-3f)};
    for (const vec3& eye : eyes)
        for (const vec3& up : ups)
            for (const float yfov : {0.02f, 0.9f, 2.8f}) {
                const vec3 at(2, 0.5f, -1);
                expectRays(changedView(rolled(), {eye, at, up, yfov}), eye, at, up, yfov);
            }
}

TEST(ChangedView, HasWhatIsNotChangedToTheBit) {
    const auto axes = [](const Camera& c) { return std::array{c.forward, c.right, c.up}; };
    const Camera before = rolled();
    const Camera same = changedView(before, {});
    EXPECT_EQ(axes(same), axes(before));
    EXPECT_EQ(same.eye, before.eye);
    EXPECT_EQ(same.yfov, before.yfov);

    const Camera moved = changedView(before, {.eye = vec3(7, 8, 9)});
    EXPECT_EQ(moved.eye, vec3(7, 8, 9));
    EXPECT_EQ(axes(moved), axes(before)) << "a file's camera keeps its direction";
    EXPECT_EQ(moved.yfov, before.yfov);

    const Camera wide = changedView(before, {.yfov = 2.0f});
    EXPECT_EQ(wide.eye, before.eye);
    EXPECT_EQ(axes(wide), axes(before));
    EXPECT_EQ(wide.yfov, 2.0f);

    // --at alone keeps the eye and holds the horizon level; --up alone keeps eye and direction.
    expectRays(changedView(before, {.at = vec3(0, 5, 0)}), {1, 2, 3}, {0, 5, 0}, {0, 1, 0}, double{0.9f});
    const dvec3 ahead = dvec3(before.eye) + dvec3(before.forward);
    expectRays(changedView(before, {.up = vec3(1, 0, 0)}), {1, 2, 3}, ahead, {1, 0, 0}, double{0.9f});
}

TEST(ChangedView, OfTheProgramsOwnStillLooksAtTheMiddleOfTheScene) {
    const std::vector<vec3> points{vec3(1, 2, 3), vec3(3, 8, 5)};
    const Camera own = threeQuarterView(points, Box{points[0], points[1]});
    ASSERT_EQ(own.target, vec3(2, 5, 4));
    const Camera moved = changedView(own, {.eye = vec3(2, 5, 40)});
    EXPECT_EQ(moved.forward, vec3(0, 0, -1));
    EXPECT_EQ(moved.target, own.target);
    expectRays(changedView(own, {.eye = vec3(-4, 6, 1)}), {-4, 6, 1}, {2, 5, 4}, {0, 1, 0}, own.yfov);
}

TEST(ChangedView, LooksStraightUpAndDownToo) {
    for (const float way : {1.0f, -1.0f})
        for (const vec3& ownUp : {vec3(0, 1, 0), vec3(0, 0, 1)}) {
            Camera before;
            before.up = ownUp;
            before.forward = ownUp.y > 0 ? vec3(0, 0, -1) : vec3(0, 1, 0);
            const Camera camera = changedView(before, {.at = before.eye + vec3(0, way, 0)});
            EXPECT_EQ(camera.forward, vec3(0, way, 0));
            EXPECT_EQ(glm::dot(camera.up, camera.forward), 0.0f);
            EXPECT_EQ(glm::length(camera.up), 1.0f);
            EXPECT_EQ(camera.right, glm::cross(camera.forward, camera.up));
        }
}

TEST(ChangedView, OfACameraThatMirrorsMirrorsStill) {
    for (const ViewChange& change : {ViewChange{.at = vec3(0, 5, 0)}, ViewChange{.up = vec3(1, 0, 0)}}) {
        const Camera plain = changedView(rolled(), change), mirrored = changedView(rolled(true), change);
        EXPECT_EQ(mirrored.right, -plain.right);
        EXPECT_EQ(mirrored.up, plain.up);
    }
}

TEST(ChangedView, IsRefusedWhereThereIsNone) {
    const Camera camera = rolled();
    EXPECT_THROW(changedView(camera, {.at = camera.eye}), Error);
    EXPECT_THROW(changedView(camera, {.eye = vec3(4), .at = vec3(4)}), Error);
    EXPECT_THROW(changedView(camera, {.up = vec3(0.0f)}), Error);
    EXPECT_THROW(changedView(camera, {.up = -3.0f * camera.forward}), Error);
    EXPECT_THROW(changedView(camera, {.eye = vec3(0, 5, 0), .at = vec3(0), .up = vec3(0, 1, 0)}), Error);
    Camera seesCentre;
    seesCentre.target = vec3(1, 2, 3);
    EXPECT_THROW(changedView(seesCentre, {.eye = vec3(1, 2, 3)}), Error);
    Camera parallel;
    parallel.orthographic = true;
    EXPECT_THROW(changedView(parallel, {.yfov = 1.0f}), Error);
    EXPECT_EQ(changedView(parallel, {.eye = vec3(1)}).eye, vec3(1));
}

// ---- Parts of pictures -------------------------------------------------------------------------------------------------

/// Glass, a mirror, a lamp to sample, a light.
Scene roomWithGlass() {
    Scene scene = variedRoom();
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 8, true, tintedGlass());
    addTrueSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, metal(vec3(0.9f, 0.8f, 0.5f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)}};
    return scene;
}

FrameOptions whole(uint32_t samples = 2) {
    FrameOptions options;
    options.width = 53;
    options.height = 41;
    options.samples = samples;
    return options;
}

const std::vector<Crop> parts = {{0, 0, 53, 41}, {0, 0, 1, 1},  {52, 40, 1, 1},
                                 {7, 0, 3, 41},  {0, 9, 53, 2}, {13, 11, 27, 19}};

/// Pixels of the part that differ from the whole's in any bit.
size_t countDifferent(const Picture& part, const Picture& all, const Crop& crop) {
    EXPECT_EQ(part.width, crop.width);
    EXPECT_EQ(part.height, crop.height);
    size_t different = 0;
    for (uint32_t y = 0; y < crop.height; ++y)
        for (uint32_t x = 0; x < crop.width; ++x) {
            const size_t i = size_t{y} * crop.width + x, k = size_t{crop.y + y} * all.width + crop.x + x;
            different += part.radiance[i] != all.radiance[k] || part.discarded[i] != all.discarded[k];
        }
    return different;
}

TEST(PartOfAPicture, HasTheBitsOfTheWholeOnTheCpuWhateverTheTiles) {
    const Stage stage(roomWithGlass());
    FrameOptions options = whole();
    const Picture all = stage.onCpu(options);
    for (const Crop& crop : parts)
        for (const uint32_t tile : {0u, 1u, 100u}) {
            options.crop = crop;
            options.tilePixels = tile;
            const Picture part = stage.onCpu(options);
            EXPECT_EQ(countDifferent(part, all, crop), 0u) << crop.x << ' ' << crop.y << ", tiles of " << tile;
            EXPECT_LT(part.statistics.closestRays, all.statistics.closestRays + (crop.pixels() == 53 * 41 ? 1 : 0));
        }
}

class PartOfAPictureOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, PartOfAPictureOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(PartOfAPictureOnDevice, HasTheBitsOfTheWholeWhateverTheTiles) {
    const Stage stage(roomWithGlass());
    Device device(info);
    const auto tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    FrameOptions options = whole();
    const Picture all = frame.render(options);
    for (const Crop& crop : parts)
        for (const uint32_t tile : {0u, 100u}) {
            options.crop = crop;
            options.tilePixels = tile;
            EXPECT_EQ(countDifferent(frame.render(options), all, crop), 0u)
                << crop.x << ' ' << crop.y << ", tiles of " << tile;
        }
}

TEST(PartOfAPicture, HasTheRaysOfTheWhole) {
    Scene scene;
    scene.cameras = {rolled()};
    FrameOptions options = whole(3);
    const std::vector<Ray> all = cameraRays(scene, options, 2);
    for (const Crop& crop : parts) {
        options.crop = crop;
        const std::vector<Ray> part = cameraRays(scene, options, 2);
        ASSERT_EQ(part.size(), crop.pixels());
        for (uint32_t i = 0; i < part.size(); ++i) {
            const Ray& want = all[(crop.y + i / crop.width) * 53 + crop.x + i % crop.width];
            EXPECT_EQ(part[i].direction, want.direction);
        }
    }
}

TEST(PartOfAPicture, OfTheReferenceHasTheBitsOfTheWhole) {
    const Stage stage(roomWithGlass());
    const reference::World world(stage.scene, stage.geometry);
    reference::PictureOptions options;
    options.width = 53;
    options.height = 41;
    options.samples = 2;
    const reference::Picture all = render(world, options);
    const Crop crop{13, 11, 27, 19};
    options.crop = crop;
    const reference::Picture part = render(world, options);
    ASSERT_EQ(part.radiance.size(), crop.pixels());
    for (uint32_t i = 0; i < crop.pixels(); ++i) {
        const size_t k = size_t{crop.y + i / crop.width} * 53 + crop.x + i % crop.width;
        EXPECT_EQ(part.radiance[i], all.radiance[k]);
        EXPECT_EQ(part.sensitivity[i], all.sensitivity[k]);
    }
}

// Larger than memory: only the part is made.
TEST(PartOfAPicture, MayBeOfAPictureTooLargeToRender) {
    const Stage stage(roomWithGlass());
    FrameOptions options;
    options.width = options.height = 65536;
    options.samples = 1;
    options.crop = Crop{65000, 40000, 3, 2};
    const Picture part = stage.onCpu(options);
    EXPECT_EQ(part.radiance.size(), 6u);
    options.crop = Crop{0, 0, 65536, 40000};
    EXPECT_THROW(stage.onCpu(options), Error);
}

}  // namespace
}  // namespace raig
