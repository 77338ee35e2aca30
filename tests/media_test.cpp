// Glass in glass: which media rays are known to be in, and what pictures make of it.
#include "rays/media.hpp"
#include "base/random.hpp"
#include "measure/compare.hpp"
#include "measure/hard_scenes.hpp"
#include "rays/frame_data.hpp"
#include "reference/media.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using namespace test;

Material absorbing(float ior, const vec3& kept) {
    Material m = glass(ior);
    m.attenuationColor = kept;
    m.attenuationDistance = 1.0f;
    return m;
}

/// Amber with water, a bubble and a matte pearl in it; a ball of glass that another cuts into; in a varied room.
/// Cameras outside, in the amber, in the water, and in the bubble.
Scene vitrine() {
    Scene scene = variedRoom();
    hard::addBox(scene, {-1.6f, 0.3f, -1}, {0.6f, 2.1f, 1}, absorbing(1.55f, {0.9f, 0.7f, 0.4f}));
    addSphere(scene, {-0.5f, 1.2f, 0}, 0.7f, 12, true, absorbing(1.33f, {0.5f, 0.8f, 0.9f}));
    addTrueSphere(scene, {-0.6f, 1.3f, 0.1f}, 0.3f, glass(1.0f));
    addTrueSphere(scene, {-0.1f, 0.9f, 0.2f}, 0.1f, matte({0.9f, 0.8f, 0.8f}));
    addTrueSphere(scene, {1.6f, 1.1f, 0.4f}, 0.6f, glass(1.5f));
    addSphere(scene, {2.1f, 1.1f, 0.4f}, 0.5f, 8, true, absorbing(1.8f, {0.9f, 0.9f, 0.5f}));
    Light light;
    light.type = Light::Type::point;
    light.position = {1, 4, 3};
    light.intensity = vec3(20.0f);
    scene.lights.push_back(light);
    for (const vec3& eye : {vec3(0.4f, 1.9f, 0.9f), vec3(-0.9f, 0.9f, 0.2f), vec3(-0.7f, 1.2f, 0.1f)})
        scene.cameras.push_back(lookAt(eye, {0.3f, 1.0f, -0.4f}, 1.2f));
    return scene;
}

/// Packed as rays carry them, from the reference's: the numbers of media that have the same index and absorption.
std::vector<vec4> unpacked(const Media& media, uint32_t packed) {
    std::vector<vec4> found;
    for (; packed != 0; packed >>= 8) {
        const Medium& m = media.media[packed & 255u];
        found.emplace_back(m.absorption, m.ior);
    }
    return found;
}

std::vector<vec4> unpacked(const std::vector<Surface>& surfaces, reference::Nest nest) {
    std::vector<vec4> found;
    while (!nest.isEmpty()) {
        const Surface& s = surfaces[nest.innermost()];
        found.emplace_back(s.absorption, s.ior);
        nest.leave(nest.innermost());
    }
    return found;
}

// Winding numbers and distances say the same as rays from afar.
TEST(Media, AroundAPointAreThoseOfTheReference) {
    const Stage stage(vitrine()), kept = Stage::kept(vitrine());
    const Media media = findMedia(stage.scene, stage.geometry), ofKept = findMedia(kept.scene, kept.geometry);
    ASSERT_TRUE(media.nests);
    const reference::World world(stage.scene, stage.geometry);
    Random random(3);
    size_t depths[5] = {};
    for (int i = 0; i < 3000; ++i) {
        const vec3 point = vec3(0.5f, 1.2f, 0) + random.inCube(-2, 2) * vec3(1.1f, 0.6f, 0.6f);
        const vec3 ball = point - vec3(1.6f, 1.1f, 0.4f);
        if (glm::length(ball) < 0.6f && glm::length(point - vec3(2.1f, 1.1f, 0.4f)) < 0.5f) continue;  // in both: either
        const uint32_t around = mediaAround(media, stage.geometry, point);
        const auto want = unpacked(world.surfaces, reference::mediaAround(stage.geometry, world.media, point));
        ASSERT_EQ(unpacked(media, around), want) << point.x << ' ' << point.y << ' ' << point.z;
        ASSERT_EQ(mediaAround(ofKept, kept.geometry, point), around);
        ++depths[want.size()];
    }
    for (int depth = 0; depth < 4; ++depth) EXPECT_GT(depths[depth], 5u) << depth;
}

TEST(Media, OnASurfaceAreThoseOutside) {
    const Stage stage(vitrine());
    const Media media = findMedia(stage.scene, stage.geometry);
    EXPECT_EQ(mediaAround(media, stage.geometry, {0.6f, 1.0f, 0.0f}), 0u);
    EXPECT_NE(mediaAround(media, stage.geometry, {std::nextafter(0.6f, 0.0f), 1.0f, 0.0f}), 0u);
}

TEST(Media, OfSurfacesThatAreOpenInsideOutOrApartAreNotAskedFor) {
    const auto features = [](const Scene& scene) {
        return packFrame(scene, flatten(scene)).features & shared::FEATURE_NESTED;
    };
    Scene apart = whiteSky();
    addTrueSphere(apart, {-2, 0, 0}, 0.9f, glass(1.5f));
    addTrueSphere(apart, {2, 0, 0}, 0.9f, glass(1.33f));
    EXPECT_EQ(features(apart), 0u);
    Scene nested = apart;
    addTrueSphere(nested, {2, 0, 0}, 0.5f, glass(1.0f));
    EXPECT_NE(features(nested), 0u);

    Scene open = whiteSky();
    const uint32_t mesh = addSphere(open, vec3(0), 1.0f, 6, false, glass(1.5f));
    addSphere(open, vec3(0), 0.5f, 6, false, glass(1.33f));
    EXPECT_EQ(findMedia(open, flatten(open)).openMaterials, 0u);
    open.meshes[mesh].triangles.pop_back();
    open.meshes[mesh].materials.pop_back();
    EXPECT_EQ(findMedia(open, flatten(open)).openMaterials, 1u);
    EXPECT_EQ(reference::closedMedia(flatten(open), reference::World(open, flatten(open)).surfaces)[0], reference::noMedium);
    Scene inside = whiteSky();
    addSphere(inside, vec3(0), 1.0f, 6, false, glass(1.5f));
    for (uvec3& t : inside.meshes[0].triangles) std::swap(t.y, t.z);
    addSphere(inside, vec3(0), 0.5f, 6, false, glass(1.33f));
    EXPECT_EQ(findMedia(inside, flatten(inside)).openMaterials, 1u);
}

TEST(Media, BeyondTheFirst255AreUnknownAndCounted) {
    Scene scene = whiteSky();
    for (int i = 0; i < 300; ++i) addSphere(scene, vec3(0), 1.0f + 0.01f * i, 4, false, glass(1.1f + 0.001f * i));
    const Media media = findMedia(scene, flatten(scene));
    EXPECT_TRUE(media.nests);
    EXPECT_EQ(media.openMaterials, 45u);
    EXPECT_EQ(std::ranges::count(media.ofMaterial, 0), 45);
}

// What an absorbing ball of glass holds is seen through it; a ball beside it changes nothing.
TEST(Media, AreAbsorbedByWhereLightRunsNotByWhatItMeets) {
    Scene scene = whiteSky();
    scene.sky = {};
    addTrueSphere(scene, vec3(0), 2.0f, absorbing(1.0f, vec3(0.5f)));
    addTrueSphere(scene, vec3(0), 0.5f, glowing(vec3(1.0f)));
    scene.cameras[0] = lookAt({0, 0, 8}, {0, 0, 0}, 0.01f);
    const Picture picture = Stage(scene).onCpu(square(1, 1));
    EXPECT_NEAR(picture.radiance[0].x, std::pow(0.5, 1.5), 1e-6);
}

// Shells within shells: of more than four around a ray the outermost are forgotten, and that is told.
TEST(Media, BeyondFourAreForgottenAndCounted) {
    const auto shells = [](int count) {
        Scene scene = whiteSky();
        for (int i = 0; i < count; ++i)
            addTrueSphere(scene, vec3(0), 1.0f - 0.15f * float(i), glass(1.1f + 0.1f * float(i)));
        return Stage(scene).onCpu(square(8, 1, 12));
    };
    EXPECT_EQ(shells(4).statistics.forgottenMedia, 0u);
    const Picture five = shells(5);
    EXPECT_GT(five.statistics.forgottenMedia, 0u);
    for (size_t i = 0; i < five.radiance.size(); ++i)  // nothing is lost all the same
        EXPECT_NEAR(five.radiance[i].x + five.discarded[i], 1.0, 1e-4);
}

TEST(Media, MakeThePicturesOfTheReference) {
    const Stage stage(vitrine());
    const reference::World world(stage.scene, stage.geometry);
    for (const uint32_t camera : {0u, 1u, 2u, 3u}) {
        FrameOptions options = square(28, 1, 6, 1e-3f);
        options.camera = camera;
        const Picture picture = stage.onCpu(options);
        reference::PictureOptions same;
        same.width = same.height = 28;
        same.camera = camera;
        same.bounds = {6, 1e-3f, 0};
        const reference::Picture expected = reference::render(world, same);
        Image image(28, 28);
        image.pixels = picture.radiance;
        const PictureComparison got = compareToReference(image, expected);
        EXPECT_LT(got.outsideTies.rmse, 1e-3) << "camera " << camera;
        EXPECT_EQ(got.outsideTies.nan, 0u);
        EXPECT_LT(got.ties, 28u * 28u / 3) << "camera " << camera;
        EXPECT_FALSE(got.blank);
    }
}

class MediaOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, MediaOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(MediaOnDevice, LookAsOnTheCpuToTheBitAndAsWithInstancesKept) {
    const Stage stage(vitrine()), kept = Stage::kept(vitrine());
    Device device(info);
    const auto tracer = makeDeviceTracer(device, stage.structure), ofKept = makeDeviceTracer(device, kept.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    DeviceFrame keptFrame(device, kept.scene, kept.geometry, *ofKept);
    for (const uint32_t camera : {0u, 1u, 2u, 3u}) {
        FrameOptions options = square(28, 2, 6, 1e-3f);
        options.camera = camera;
        const Picture picture = frame.render(options);
        EXPECT_EQ(bitsOf(picture), bitsOf(stage.onCpu(options))) << "camera " << camera;
        EXPECT_EQ(bitsOf(picture), bitsOf(keptFrame.render(options))) << "camera " << camera;
    }
}

}  // namespace
}  // namespace raig
