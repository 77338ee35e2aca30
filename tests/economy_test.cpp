// No more is modelled than a scene needs: what it lacks is left out of the kernels and of its data, and named; and the
// picture is that of a scene in which it is there, but makes no difference.
#include "rays/economy.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>

namespace raig {
namespace {

using namespace test;

Scene box() { return importScene(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"); }

/// Something of that material which no ray can meet, but for which what it asks for is made ready.
void addUnseen(Scene& scene, const Material& material) { addQuad(scene, vec3(0), vec3(0), vec3(0), material); }

/// As much of the surface as `alpha` says, or from `cutoff` on all.
Material covering(float alpha, float cutoff) {
    Material material = matte(vec3(1.0f));
    material.alpha = alpha;
    material.alphaCutoff = cutoff;
    return material;
}

struct Addition {
    const char* name;  ///< as Economy has it
    std::function<void(Scene&)> make;
    bool keepsBits = true;
};

/// What may be added to the box without a change of any pixel; but that white is not white to the last bit between corners.
const std::vector<Addition>& additions() {
    static const std::vector<Addition> all = {
        {"glass", [](Scene& scene) { addUnseen(scene, glass(1.5f)); }},
        {"mirrors", [](Scene& scene) { addUnseen(scene, metal(vec3(1.0f))); }},
        {"highlights and rough mirrors", [](Scene& scene) { addUnseen(scene, metal(vec3(1.0f), 1.0f)); }},
        {"cut-outs", [](Scene& scene) { addUnseen(scene, covering(0.25f, 0.5f)); }},
        {"blending", [](Scene& scene) { addUnseen(scene, covering(0.25f, 0.0f)); }},
        {"vertex normals",
         [](Scene& scene) {
             for (Mesh& mesh : scene.meshes) mesh.normals.assign(mesh.positions.size(), vec3(0.0f));  // none
         }},
        {"vertex colours",
         [](Scene& scene) {
             for (Mesh& mesh : scene.meshes) mesh.colors.assign(mesh.positions.size(), vec3(1.0f));
         },
         /* keepsBits= */ false},
        {"lights", [](Scene& scene) { scene.lights.emplace_back().intensity = vec3(0.0f); }},
        {"colour textures",
         [](Scene& scene) {
             scene.images.push_back({1, 1, {9, 9, 9, 255}});
             for (Mesh& mesh : scene.meshes) mesh.uvs.assign(mesh.positions.size(), vec2(0.0f));
             Material material = matte(vec3(1.0f));
             material.baseColorTexture = Texture{};
             addUnseen(scene, material);
         }},
    };
    return all;
}

Economy economyOf(const Scene& scene) { return measureEconomy(scene, flatten(scene)); }

bool leavesOut(const Economy& economy, const std::string& name) {
    return std::ranges::any_of(economy.leftOut, [&](const LeftOut& each) { return each.name == name; });
}

TEST(Economy, LeavesOutWhatTheSceneLacksAndSaysWhatThatSaves) {
    const Economy plain = economyOf(box());
    EXPECT_LT(plain.instructions, plain.allInstructions);
    EXPECT_LT(plain.vertexBytes, plain.allVertexBytes);
    for (const LeftOut& each : plain.leftOut) EXPECT_GT(each.instructions, 0u) << each.name;
    for (const Addition& addition : additions()) {
        Scene scene = box();
        addition.make(scene);
        const Economy economy = economyOf(scene);
        EXPECT_TRUE(leavesOut(plain, addition.name)) << addition.name;
        EXPECT_FALSE(leavesOut(economy, addition.name)) << addition.name;
        EXPECT_TRUE(std::ranges::find(economy.used, addition.name) != economy.used.end()) << addition.name;
        EXPECT_GT(economy.instructions, plain.instructions) << addition.name;
        EXPECT_GE(economy.vertexBytes, plain.vertexBytes) << addition.name;
    }
}

TEST(Economy, LeavesOutWhatOnlyUnusedMaterialsAskFor) {
    const Economy plain = economyOf(box());
    Scene scene = box();
    scene.images.push_back({1, 1, {9, 9, 9, 255}});
    for (Mesh& mesh : scene.meshes) mesh.uvs.assign(mesh.positions.size(), vec2(0.0f));
    Material textured = metal(vec3(1.0f));
    textured.baseColorTexture = Texture{};
    for (const Material& material : {glass(1.5f), metal(vec3(1.0f), 1.0f), covering(0.25f, 0.5f), textured})
        scene.materials.push_back(material);
    EXPECT_EQ(economyOf(scene).used, plain.used);
    EXPECT_EQ(economyOf(scene).instructions, plain.instructions);
}

TEST(Economy, LeavesOutWhatAnIntegratorHasNoUseFor) {
    const Scene scene = box();
    const Geometry geometry = flatten(scene);
    const uint32_t whitted = measureEconomy(scene, geometry).instructions;
    EXPECT_LT(measureEconomy(scene, geometry, Integrator::ao).instructions, whitted) << "no light, no materials";
    EXPECT_GT(measureEconomy(scene, geometry, Integrator::path).instructions, whitted) << "directions are drawn";
}

TEST(Economy, KeepsOnceWhatIsRepeated) {
    Scene scene = box();
    scene.images.push_back({8, 8, std::vector<uint8_t>(256, 255)});
    for (Mesh& mesh : scene.meshes) mesh.uvs.assign(mesh.positions.size(), vec2(0.0f));
    for (Material& material : scene.materials) material.baseColorTexture = Texture{};
    const Economy economy = economyOf(scene);
    EXPECT_EQ(economy.textureBytes, 256u);
    EXPECT_GE(economy.namedTextureBytes, 3 * economy.textureBytes) << "three materials and more look it up";
}

TEST(Economy, ChangesNoBitOfThePictureOnTheCpu) {
    const FrameOptions options = square(24, 2, 4);
    const Picture plain = Stage(box()).onCpu(options);
    for (const Addition& addition : additions()) {
        if (!addition.keepsBits) continue;
        Scene scene = box();
        addition.make(scene);
        EXPECT_EQ(bitsOf(Stage(std::move(scene)).onCpu(options)), bitsOf(plain)) << addition.name;
    }
}

class EconomyOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, EconomyOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(EconomyOnDevice, ChangesNoBitOfThePicture) {
    Device device(info);
    const FrameOptions options = square(24, 2, 4);
    const auto render = [&](const Scene& scene) {
        const Stage stage(scene);
        const auto tracer = makeDeviceTracer(device, stage.structure);
        return bitsOf(renderPicture(device, stage.scene, stage.geometry, *tracer, options));
    };
    const auto plain = render(box());
    for (const Addition& addition : additions()) {
        if (!addition.keepsBits) continue;
        Scene scene = box();
        addition.make(scene);
        EXPECT_EQ(render(scene), plain) << addition.name;
    }
}

}  // namespace
}  // namespace raig
