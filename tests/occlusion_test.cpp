// Ambient occlusion against closed forms, on the CPU and by the reference; and that it is the same wherever it is asked for.
#include "measure/compare.hpp"
#include "reference/picture.hpp"
#include "reference/world.hpp"
#include "support/ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

FrameOptions clay(uint32_t side, uint32_t samples, float reach = INFINITY) {
    FrameOptions options = square(side, samples);
    options.integrator = Integrator::ao;
    options.reach = reach;
    return options;
}

class Occlusion : public ByEveryWay {
protected:
    std::vector<dvec3> render(const Scene& scene, const FrameOptions& options) const {
        return WayOfScene(GetParam(), scene).render(options);
    }
    /// Of the point under the camera of floorFromAbove(): pixels are independent of each other.
    Sample opennessOf(const Scene& scene, float reach = INFINITY) const {
        std::vector<double> values;
        for (const dvec3& pixel : render(scene, clay(24, 4, reach))) values.push_back(pixel.y);
        return sampleOf(values);
    }
};
// Devices give the CPU's bits: see below.
INSTANTIATE_TEST_SUITE_P(, Occlusion, testing::Values("cpu", "reference"), testName);

/// True if all are white.
bool isWhite(const std::vector<dvec3>& pixels) {
    return std::ranges::all_of(pixels, [](const dvec3& c) { return c == dvec3(1.0); });
}

// Whatever the material, a furnace is white: nothing hides a plane, nor anything that is convex, however coarse it is.
TEST_P(Occlusion, WhatIsConvexIsWhiteAsIsTheBackground) {
    Scene scene = whiteSky();
    const std::vector<Material> materials = {matte(vec3(0.2f)), metal(vec3(0.9f)), glass(1.5f), glowing(vec3(3.0f))};
    for (size_t i = 0; i < materials.size(); ++i) {
        addSphere(scene, {3.0f * float(i), 0, 0}, 1.0f, 5, i % 2 == 0, materials[i]);
        scene.cameras.push_back(lookAt({3.0f * float(i), 0.3f, 4}, {3.0f * float(i), 0, 0}, 0.5f));
    }
    addTrueSphere(scene, {12, 0, 0}, 1.0f, materials[0]);
    scene.cameras.push_back(lookAt({12, 0.3f, 4}, {12, 0, 0}, 0.5f));
    WayOfScene way(GetParam(), scene);
    for (uint32_t camera = 1; camera < scene.cameras.size(); ++camera) {
        FrameOptions options = clay(16, 2, 0.9f);  // the others are out of reach
        options.camera = camera;
        EXPECT_TRUE(isWhite(way.render(options))) << camera;
    }
}

TEST_P(Occlusion, InAClosedRoomIsBlackUnlessWallsAreOutOfReach) {
    Scene scene = floorFromAbove(matte(vec3(0.5f)), 20.0f);
    addSphere(scene, vec3(0.0f), 10.0f, 6, false, glass(1.5f));  // all surfaces count, those that let light through as well
    const auto black = render(scene, clay(8, 4));
    EXPECT_TRUE(std::ranges::all_of(black, [](const dvec3& c) { return c == dvec3(0.0); }));
    EXPECT_TRUE(isWhite(render(scene, clay(8, 4, 5.0f))));
}

// A wall without end along one side hides half of the cosine-weighted sky; one that ends at an angle f above the floor, the
// share (1 - cos f) / 2.
TEST_P(Occlusion, OfAWallIsThatOfItsAngle) {
    for (const float height : {0.5f, 2e4f}) {
        Scene scene = floorFromAbove(matte(vec3(0.5f)));
        addQuad(scene, {0.5f, 0, 1e4f}, {0, 0, -2e4f}, {0, height, 0}, matte(vec3(0.5f)));
        const double cosine = 0.5 / std::hypot(0.5, double{height});
        expectMean(opennessOf(scene), 1.0 - 0.5 * (1.0 - cosine), 0.1);
    }
}

// A sphere of radius r whose middle is h above the floor hides (r / h)^2; from h - r on, as far as it is within reach.
TEST_P(Occlusion, OfASphereOverheadIsTheSquareOfItsSine) {
    for (const float radius : {0.5f, 1.2f}) {
        Scene scene = floorFromAbove(matte(vec3(0.5f)));
        addTrueSphere(scene, {0, 1.5f, 0}, radius, matte(vec3(0.5f)));
        scene.cameras[0].eye.y = 0.05f;  // under it
        expectMean(opennessOf(scene), 1.0 - radius * radius / 2.25, 0.12);
        EXPECT_NEAR(opennessOf(scene, 1.49f - radius).mean, 1.0, 1e-12);
        EXPECT_LT(opennessOf(scene, 1.51f - radius).mean, 1.0);
    }
}

/// Smooth normals and flat ones, spheres, a normal texture, glass, what blends and what is cut out, and instances that are
/// moved and mirrored.
Scene furnished() {
    Scene scene = variedRoom();
    const uint32_t ball = addSphere(scene, {-1.2f, 1, 0}, 0.8f, 10, true, matte({0.8f, 0.7f, 0.6f}));
    addTrueSphere(scene, {0.5f, 0.7f, 1}, 0.6f, glass(1.5f));
    addQuad(scene, {-0.5f, 3.9f, 0}, {1, 0, 0}, {0, 0, 1}, glowing(vec3(4.0f)));
    scene.images.push_back({2, 2, {128, 128, 255, 255, 200, 128, 220, 255, 128, 60, 220, 255, 90, 160, 240, 255}});
    scene.materials[0].normalTexture = Texture{1};
    Material blended = matte(vec3(0.5f)), cut = blended;
    blended.alpha = 0.5f;
    scene.images.push_back({2, 1, {255, 255, 255, 0, 255, 255, 255, 255}});
    cut.baseColorTexture = Texture{2};
    cut.alphaVaries = true;
    cut.alphaCutoff = 0.5f;
    addQuad(scene, {-3, 1.5f, 1}, {2, 0, 0}, {0, 0, -2}, blended);
    const uint32_t leaf = addQuad(scene, {-0.5f, 0.2f, 2}, {1.5f, 0, 0}, {0, 1.2f, 0}, cut);
    scene.meshes[leaf].uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    dmat4 moved(0.5);
    moved[0][0] = -0.5;
    moved[3] = dvec4(1.5, 0.6, 2.0, 1);
    scene.instances.push_back({ball, moved});
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)}};
    return scene;
}

TEST(OcclusionPicture, IsTheReferences) {
    for (const float reach : {INFINITY, 1.5f}) {
        const Stage stage(furnished());
        const reference::World world(stage.scene, stage.geometry);
        const Picture picture = stage.onCpu(clay(48, 3, reach));
        reference::PictureOptions same;
        same.width = same.height = 48;
        same.samples = 3;
        same.integrator = Integrator::ao;
        same.reach = reach;
        const reference::Picture expected = reference::render(world, same);
        Image image(48, 48);
        image.pixels = picture.radiance;
        const PictureComparison got = compareToReference(image, expected);
        EXPECT_LT(got.outsideTies.max, 1e-6) << "means of the same zeros and ones";
        EXPECT_LT(got.ties, 48u * 48u / 20);
        EXPECT_FALSE(got.blank);
    }
}

TEST(OcclusionPicture, AsksOneRayASampleAndFollowsNone) {
    const Picture picture = Stage(variedRoom()).onCpu(clay(32, 2));
    const FrameStatistics& s = picture.statistics;
    EXPECT_EQ(s.closestRays, 32u * 32u * 2u);
    EXPECT_LT(s.shadowRays, s.closestRays) << "the background asks for nothing";
    EXPECT_EQ(s.shadowRays + s.spared, s.closestRays);
    EXPECT_EQ(s.deepest, 0u);
    EXPECT_TRUE(std::ranges::all_of(picture.discarded, [](float weight) { return weight == 0.0f; }));
}

class OcclusionOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, OcclusionOnDevice, testing::ValuesIn(devicesToTest()), testName);

// Also by kept instances, in parts, where samples are needed, and after and before a picture by another integrator.
TEST_P(OcclusionOnDevice, LooksAsOnTheCpuToTheBit) {
    Device device(info);
    for (const bool keeps : {false, true})
        expectTheCpusBits(device, keeps ? Stage::kept(furnished()) : Stage(furnished()), clay(32, 3, 2.0f));
}

}  // namespace
}  // namespace raig
