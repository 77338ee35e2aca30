// Alpha: surfaces that are there in part, cut out or blended, for the camera's rays, for those that follow, and for shadows.
#include "rays/frame_data.hpp"
#include "reference/picture.hpp"
#include "reference/whitted.hpp"
#include "support/devices.hpp"
#include "support/leaves.hpp"
#include "support/ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// A camera straight above the origin, that sees one point.
Camera above() { return floorFromAbove(Material{}).cameras[0]; }

uint32_t addSheet(Scene& scene, float height, const Material& material) {
    const uint32_t sheet = addQuad(scene, {-2, height, 2}, {4, 0, 0}, {0, 0, -4}, material);
    scene.meshes[sheet].uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    return sheet;
}

/// Left half without alpha, right half with.
Texels halves() {
    Texels image{2, 1, {255, 255, 255, 0, 255, 255, 255, 255}};
    return image;
}

float pixelOf(const Scene& scene, uint32_t maxDepth = 8, uint32_t samples = 1) {
    return Stage(scene).onCpu(square(1, samples, maxDepth)).radiance[0].x;
}

TEST(Coverage, SharesAPixelBetweenWhatBlendsAndWhatIsBehind) {
    Scene scene;
    addSheet(scene, 0.0f, matte(vec3(0.2f)));
    addSheet(scene, 1.0f, covering(0.25f));
    scene.ambient = vec3(1.0f);
    scene.cameras.push_back(above());
    EXPECT_NEAR(pixelOf(scene), 0.25f + 0.75f * 0.2f, 1e-6f);
    EXPECT_NEAR(pixelOf(scene, 0), 0.25f + 0.75f * 0.2f, 1e-6f) << "to pass costs no depth";
    scene.materials[0].baseColor = vec3(0.0f);  // or the sheet would light it
    scene.materials[1].emission = vec3(2.0f);
    EXPECT_NEAR(pixelOf(scene), 0.25f * 3.0f, 1e-6f);
}

TEST(Coverage, IsCutOutFromTheCutoffOn) {
    Scene scene;
    scene.images = {{1, 1, {255, 255, 255, 128}}};
    addSheet(scene, 0.0f, matte(vec3(0.2f)));
    addSheet(scene, 1.0f, cutOut(0.5f));
    scene.ambient = vec3(1.0f);
    scene.cameras.push_back(above());
    EXPECT_NEAR(pixelOf(scene), 1.0f, 1e-6f);
    scene.images[0].rgba[3] = 127;
    EXPECT_NEAR(pixelOf(scene, 0), 0.2f, 1e-6f);
    scene.materials[1].alphaCutoff = 2.0f;
    EXPECT_NEAR(pixelOf(scene), 0.2f, 1e-6f) << "no alpha is as much";
}

// However alpha is rounded on its way, texels that have as much as the cutoff are there, in the reference, too.
TEST(Coverage, IsWholeWhereTexelsEqualTheCutoff) {
    for (const uint32_t fifths : {1u, 2u, 3u, 4u, 5u}) {
        Scene scene;
        scene.images = {{1, 1, {255, 255, 255, static_cast<uint8_t>(51 * fifths)}}};
        addSheet(scene, 1.0f, cutOut(static_cast<float>(fifths / 5.0)));
        scene.ambient = vec3(1.0f);
        scene.cameras.push_back(above());
        const Stage stage(scene);
        EXPECT_NEAR(stage.onCpu(square(1, 1)).radiance[0].x, 1.0f, 1e-6f) << fifths;
        const reference::World world(stage.scene, stage.geometry);
        EXPECT_NEAR(reference::traceRay(world, {{0, 5, 0}, {0, -1, 0}}, {}, {}).value.x, 1.0, 1e-9) << fifths;
    }
}

TEST(Coverage, IsThatOfVerticesToo) {
    Scene scene;
    addSheet(scene, 0.0f, matte(vec3(0.2f)));
    const uint32_t sheet = addSheet(scene, 1.0f, covering(0.5f));
    scene.meshes[sheet].colors.assign(4, vec3(1.0f));
    scene.meshes[sheet].alphas.assign(4, 0.5f);
    scene.ambient = vec3(1.0f);
    scene.cameras.push_back(above());
    EXPECT_NEAR(pixelOf(scene), 0.25f + 0.75f * 0.2f, 1e-6f);
    scene.materials[1].alphaVaries = false;
    EXPECT_NEAR(pixelOf(scene), 0.5f + 0.5f * 0.2f, 1e-6f);
}

// The lamp is above the sheet's edge between its halves; its light falls through one half of it.
TEST(Coverage, IsThatOfShadows) {
    const auto lit = [](const Material& sheet, float x) {
        Scene scene;
        scene.images = {halves()};
        addSheet(scene, 0.0f, matte(vec3(1.0f)));
        addSheet(scene, 1.0f, sheet);
        scene.lights = {{.type = Light::Type::directional, .direction = {0, -1, 0}, .intensity = vec3(3.14159265f)}};
        Camera camera = above();
        camera.eye = {x, 0.5f, 0.0f};  // below the sheet
        scene.cameras.push_back(camera);
        return pixelOf(scene);
    };
    EXPECT_NEAR(lit(cutOut(0.5f), -0.8f), 1.0f, 1e-6f);
    EXPECT_EQ(lit(cutOut(0.5f), 0.8f), 0.0f);
    EXPECT_NEAR(lit(covering(0.25f), 0.3f), 0.75f, 1e-6f);
    EXPECT_EQ(lit(covering(1.0f), 0.3f), 0.0f);
    Material tinted = glass(1.5f);
    tinted.thin = true;
    EXPECT_NEAR(lit(tinted, 0.3f), 1.0f, 1e-6f);
}

TEST(Coverage, LetsRaysPassSixtyFourTimesAndTellsWhatItKeepsBack) {
    for (const int sheets : {64, 65}) {
        Scene scene;
        addSheet(scene, 0.0f, matte(vec3(1.0f)));
        for (int i = 0; i < sheets; ++i) addSheet(scene, 0.04f * float(i + 1), covering(1.0f / 256.0f, vec3(0.0f)));
        scene.ambient = vec3(1.0f);
        scene.cameras.push_back(above());
        const Picture picture = Stage(scene).onCpu(square(1, 1, 0));
        const double left = std::pow(255.0 / 256.0, sheets);
        EXPECT_NEAR(picture.radiance[0].x, sheets == 64 ? left : 0.0, 1e-5);
        EXPECT_NEAR(picture.discarded[0], sheets == 64 ? 0.0 : left, 1e-5);
    }
}

// "No more than a scene needs": alpha that is 1 everywhere leaves the code out that would look it up.
TEST(Coverage, IsLookedUpOnlyWhereItVaries) {
    Scene scene = variedRoom();
    const Stage plain(scene);
    const FrameData without = packFrame(plain.scene, plain.geometry);
    EXPECT_EQ(without.features & (shared::FEATURE_COVERAGE | shared::FEATURE_BLENDS), 0u);
    scene.materials[0].alphaVaries = true;
    const Stage opaque(scene);
    EXPECT_EQ(packFrame(opaque.scene, opaque.geometry).features, without.features);
    EXPECT_EQ(bitsOf(opaque.onCpu(square(16, 2))), bitsOf(plain.onCpu(square(16, 2))));
    scene.images[0].rgba[3] = 254;
    const Stage blended(scene);
    EXPECT_NE(packFrame(blended.scene, blended.geometry).features & shared::FEATURE_BLENDS, 0u);
    scene.materials[0].alphaCutoff = 0.5f;
    const Stage cut(scene);
    EXPECT_EQ(packFrame(cut.scene, cut.geometry).features & shared::FEATURE_BLENDS, 0u);
}

TEST(Coverage, IsThatOfTheReference) {
    expectTheReferences(Stage(leafyScene()), 64, 5);
}

TEST(Coverage, IsTheSameWithInstancesKeptAndWhateverTheTiles) {
    FrameOptions options = square(40, 2, 5);
    const Stage stage(leafyScene());
    const std::vector<uint32_t> bits = bitsOf(stage.onCpu(options));
    EXPECT_EQ(bitsOf(Stage::kept(leafyScene()).onCpu(options)), bits);
    for (const uint32_t tile : {64u, 500u}) {
        options.tilePixels = tile;
        EXPECT_EQ(bitsOf(stage.onCpu(options)), bits) << tile;
    }
}

// Emitters light by as much of them as is there: a floor below one that covers a fourth, or whose left half is cut out, gets
// what is left of the light of the whole.
TEST(Coverage, IsThatOfEmittersToo) {
    const auto lit = [](Material lamp) {
        lamp.baseColor = vec3(0.0f);
        lamp.emission = vec3(3.0f);
        Scene scene = floorFromAbove(matte(vec3(1.0f)), 1.0f);
        scene.images = {halves()};
        scene.meshes[addQuad(scene, {-0.5f, 4, -0.5f}, {1, 0, 0}, {0, 0, 1}, lamp)].uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
        return pixelOf(scene, 8, 16384);
    };
    const double whole = lit(covering(1.0f));
    EXPECT_GT(whole, 0.05);
    EXPECT_NEAR(lit(covering(0.25f)), 0.25 * whole, 1e-5 * whole);
    EXPECT_NEAR(lit(cutOut(0.5f)), 0.5 * whole, 5e-3 * whole);
}

class CoverageOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, CoverageOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(CoverageOnDevice, HasTheBitsOfTheCpus) {
    const FrameOptions options = square(40, 2, 5);
    const Stage stage(leafyScene());
    Device device(info);
    const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
    const Picture got = renderPicture(device, stage.scene, stage.geometry, *tracer, options);
    EXPECT_EQ(countDifferent(got, stage.onCpu(options)), 0u);
}

}  // namespace
}  // namespace raig
