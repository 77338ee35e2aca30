// Paths where textures say what glows and what is there: rays to lamps and drawn rays share the light of both.
#include "support/paths.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using namespace test;

class TexturedPaths : public Paths {};
INSTANTIATE_TEST_SUITE_P(, TexturedPaths, testing::Values("cpu", "reference"), testName);

/// What lampOnFloor's floor shows on the average.
constexpr double whole = 0.5 * 3.0 * formFactor;

/// White and there on one side, black and not there on the other, in the direction of u.
Texture addHalves(Scene& scene) {
    scene.images.push_back({2, 1, {255, 255, 255, 255, 0, 0, 0, 0}});
    return {.image = 0, .wrapU = Wrap::clamp, .wrapV = Wrap::clamp};
}

/// u goes along y, across the floor's middle.
const std::vector<vec2> alongY = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};

// Half of the lamp's light is left in the mean, as the picture and its mirror image make a lamp that glows all over.
TEST_P(TexturedPaths, AreLitByALampsTexture) {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    scene.meshes[1].uvs = alongY;
    scene.materials[scene.meshes[1].materials.at(0)].emissionTexture = addHalves(scene);
    expectMean(meansOf(scene, paths(12, 32, 3)), 0.5 * whole, 0.03);
}

TEST_P(TexturedPaths, AreLitByAsMuchOfALampAsIsThere) {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    Material& lamp = scene.materials[scene.meshes[1].materials.at(0)];
    lamp.alpha = 0.4f;
    expectMean(meansOf(scene, paths(12, 32, 3)), 0.4 * whole, 0.03);
}

/// Before the lamp a black card of which half is cut out. Nothing blends: that takes other ways through the code than what
/// is half there.
Scene lampBehindCard() {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    Material card = matte(vec3(0.0f));
    card.baseColorTexture = addHalves(scene);
    card.alphaVaries = true;
    card.alphaCutoff = 0.5f;
    const uint32_t mesh = addQuad(scene, {4e-4f, 0, 0}, {0, 1, 0}, {0, 0, 1}, card);
    scene.meshes[mesh].uvs = alongY;
    return scene;
}

TEST_P(TexturedPaths, GoThroughWhatIsCutOut) {
    expectMean(meansOf(lampBehindCard(), paths(12, 32, 3)), 0.5 * whole, 0.03);
}

// The same for a lamp of which half is cut out: that half neither glows nor is in the way.
TEST_P(TexturedPaths, AreLitByWhatIsLeftOfALamp) {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    scene.meshes[1].uvs = alongY;
    Material& lamp = scene.materials[scene.meshes[1].materials.at(0)];
    lamp.baseColorTexture = addHalves(scene);
    lamp.alphaVaries = true;
    lamp.alphaCutoff = 0.5f;
    expectMean(meansOf(scene, paths(12, 32, 3)), 0.5 * whole, 0.03);
}

class TexturedPathsOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, TexturedPathsOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(TexturedPathsOnDevice, LookAsOnTheCpuToTheBit) {
    Device device(info);
    expectTheCpusBits(device, Stage(lampBehindCard()), paths(24, 3, 4, 1.0f / 512.0f));
}

}  // namespace
}  // namespace raig
