// Textures: each kind does what glTF 2.0 says, filtered by what a ray covers, and as the reference does it.
#include "rays/frame_kernels.hpp"
#include "rays/textures.hpp"
#include "reference/picture.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"
#include "support/ways.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// An image of `value(x, y)`.
template <class Value>
Texels imageOf(uint32_t width, uint32_t height, const Value& value) {
    Texels image{width, height, {}};
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x)
            for (const uint32_t byte : value(x, y)) image.rgba.push_back(static_cast<uint8_t>(byte));
    return image;
}

using Rgba = std::array<uint32_t, 4>;

Texels noise(uint32_t width, uint32_t height, uint32_t seed) {
    shared::FrameKernels code;
    return imageOf(width, height, [&](uint32_t x, uint32_t y) {
        const uint32_t bits = code.hash2(code.hash2(x, y), seed);
        return Rgba{bits & 255, (bits >> 8) & 255, (bits >> 16) & 255, bits >> 24};
    });
}

Texels plain(const Rgba& color) {
    return imageOf(1, 1, [&](uint32_t, uint32_t) { return color; });
}

// ---- Pyramids ----------------------------------------------------------------------------------------------------------

// The texels of each level, looked up one by one in the reference, which makes its own.
TEST(Pyramid, IsThatOfTheReferenceAtEverySize) {
    for (const uvec2 size : {uvec2(1, 1), uvec2(2, 2), uvec2(8, 4), uvec2(7, 5), uvec2(1, 9), uvec2(33, 20), uvec2(100, 3)})
        for (const bool encoded : {false, true}) {
            Scene scene;
            scene.images = {noise(size.x, size.y, 3)};
            scene.materials.resize(1);
            (encoded ? scene.materials[0].baseColorTexture : scene.materials[0].normalTexture) = Texture{};
            const reference::Pyramids pyramids(scene);
            const std::vector<Texels> levels = pyramidOf(scene.images[0], encoded);
            EXPECT_EQ(levels.back().rgba.size(), 4u);
            for (size_t l = 0; l < levels.size(); ++l) {
                EXPECT_EQ(levels[l].width, std::max(1u, size.x >> l));
                EXPECT_EQ(levels[l].height, std::max(1u, size.y >> l));
                const double width = std::ldexp(1.0, static_cast<int>(l)) / std::sqrt(double(size.x) * size.y);
                for (uint32_t i = 0; i < levels[l].width * levels[l].height; ++i) {
                    const dvec2 centre((i % levels[l].width + 0.5) / levels[l].width,
                                       (i / levels[l].width + 0.5) / levels[l].height);
                    const dvec4 want = pyramids.lookUp({}, encoded, centre, width * (1.0 + 1e-12));
                    for (int k = 0; k < 4; ++k) {
                        const double byte = levels[l].rgba[4 * i + k] / 255.0;
                        const bool srgb = encoded && k < 3;
                        const double value =
                            srgb ? (byte <= 0.04045 ? byte / 12.92 : std::pow((byte + 0.055) / 1.055, 2.4)) : byte;
                        ASSERT_NEAR(value, want[k], 1e-9) << size.x << 'x' << size.y << " level " << l << " texel " << i;
                    }
                }
            }
        }
}

TEST(Pyramid, KeepsTheMeanInLinearLight) {
    const Texels checks = imageOf(64, 64, [](uint32_t x, uint32_t y) {
        const uint32_t byte = (x + y) % 2 * 255;
        return Rgba{byte, byte, byte, 255};
    });
    EXPECT_EQ(pyramidOf(checks, true).back().rgba[0], 188) << "half the light is sRGB 188";
    EXPECT_EQ(pyramidOf(checks, false).back().rgba[0], 128);
}

// ---- Whole scenes ------------------------------------------------------------------------------------------------------

/// Every kind of texture at once, by both sets of coordinates, with and without tangents, each with a transform of its own,
/// on flat and smooth surfaces, under a lamp, before a mirror; of two places of each mesh one is mirrored.
Scene texturedScene() {
    Scene scene;
    scene.images = {noise(16, 16, 1), noise(9, 7, 2), noise(32, 8, 3), noise(4, 4, 4)};
    for (size_t i = 0; i < scene.images[2].rgba.size(); i += 4) scene.images[2].rgba[i + 2] |= 128;  // normals, upwards
    Material all = matte(vec3(0.8f));
    all.metallic = 0.6f;
    all.roughness = 0.7f;
    all.emission = vec3(0.3f, 0.2f, 0.1f);
    all.normalScale = 0.6f;
    all.occlusionStrength = 0.8f;
    all.baseColorTexture = Texture{0, Wrap::repeat, Wrap::mirror, 0, {1.5f, 0.3f, 0.2f}, {-0.4f, 1.2f, 0.0f}};
    all.roughnessTexture = Texture{1, Wrap::clamp, Wrap::repeat, 1};
    all.normalTexture = Texture{2, Wrap::repeat, Wrap::repeat, 0, {0.0f, 1.0f, 0.0f}, {-1.0f, 0.0f, 0.0f}};
    all.emissionTexture = Texture{3, Wrap::mirror, Wrap::repeat, 1, {2.0f, 0.0f, 0.5f}, {0.0f, 3.0f, 0.25f}};
    all.occlusionTexture = Texture{1, Wrap::repeat, Wrap::repeat, 0};
    const auto giveUvs = [&](uint32_t index, bool tangents) {
        Mesh& mesh = scene.meshes[index];
        for (const vec3& p : mesh.positions) {
            mesh.uvs.emplace_back(0.4f * p.x + 0.1f * p.z, 0.3f - 0.4f * p.y + 0.2f * p.z);
            mesh.moreUvs.emplace_back(0.2f * p.z - 0.3f * p.x, 0.5f * p.y);
            if (tangents) mesh.tangents.emplace_back(glm::normalize(vec3(0.4f, 0.05f, 0.1f)), p.x > 50.0f ? 1.0f : -1.0f);
        }
    };
    giveUvs(addSphere(scene, {-1.3f, 1.0f, 0.0f}, 1.0f, 8, true, all), false);
    giveUvs(addSphere(scene, {1.3f, 1.0f, 0.0f}, 1.0f, 8, true, all), true);
    giveUvs(addQuad(scene, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, all), false);
    addQuad(scene, {-4, 0, -4}, {8, 0, 0}, {0, 5, 0}, metal(vec3(0.9f)));
    const std::vector<Instance> once = scene.instances;
    for (size_t i = 0; i < 2; ++i) {
        dmat4 mirrored(1.0);
        mirrored[0] = dvec4(-0.7, 0, 0.2, 0);
        mirrored[1].y = 0.6;
        mirrored[3] = dvec4(0.4, 0.1, 1.9, 1);
        scene.instances.push_back({once[i].mesh, mirrored});
    }
    scene.ambient = vec3(0.2f);
    scene.sky = {.zenith = {0.2f, 0.3f, 0.6f}, .horizon = {0.6f, 0.6f, 0.6f}, .ground = {0.1f, 0.1f, 0.1f}};
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(9.0f)}};
    scene.cameras.push_back(lookAt({0.5f, 2.0f, 6.0f}, {0.0f, 1.0f, 0.0f}));
    return scene;
}

TEST(Textures, OfEveryKindAreThoseOfTheReference) {
    expectTheReferences(Stage(texturedScene()), 64, 4);
}

TEST(Textures, AreTheSameWithInstancesKeptAsWithAllWrittenOut) {
    const FrameOptions options = square(48, 2, 4);
    EXPECT_EQ(bitsOf(Stage::kept(texturedScene()).onCpu(options)), bitsOf(Stage(texturedScene()).onCpu(options)));
}

class TexturesOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, TexturesOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(TexturesOnDevice, HaveTheBitsOfTheCpus) {
    const FrameOptions options = square(40, 2, 4);
    for (const bool keeps : {false, true}) {
        const Stage stage = keeps ? Stage::kept(texturedScene()) : Stage(texturedScene());
        Device device(info);
        const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
        const Picture got = renderPicture(device, stage.scene, stage.geometry, *tracer, options);
        EXPECT_EQ(countDifferent(got, stage.onCpu(options)), 0u);
    }
}

/// The floor from above, v growing towards the viewer's bottom as glTF has it, ambient light as it comes.
Scene floorWith(const Material& material, uint32_t width = 8) {
    Scene scene = floorFromAbove(material, static_cast<float>(width) / 2.0f);
    scene.meshes[0].uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
    scene.cameras[0].eye = {0.1f, 3.0f, 0.1f};
    return scene;
}

vec3 pixelOf(const Scene& scene) { return Stage(scene).onCpu(square(1, 1)).radiance[0]; }

// Neighbouring pixels of a far checkerboard see many checks each: all have their mean, from one sample on.
TEST(Textures, DoNotShimmerFarAway) {
    Material checks = matte(vec3(1.0f));
    checks.baseColorTexture = Texture{};
    Scene scene = floorWith(checks, 4000);
    for (vec2& uv : scene.meshes[0].uvs) uv *= 4000.0f;
    scene.images = {imageOf(64, 64, [](uint32_t x, uint32_t y) {
        const uint32_t byte = (x / 8 + y / 8) % 2 * 255;
        return Rgba{byte, byte, byte, 255};
    })};
    scene.ambient = vec3(1.0f);
    scene.cameras[0] = lookAt({0, 2, 0}, {0, 0, -150}, 0.02f);
    const Stage stage(scene);
    const Picture still = stage.onCpu(square(64, 1));
    for (const vec3& c : still.radiance) ASSERT_NEAR(c.x, 0.5f, 0.02f);
    // Through a mirror it is as far as the whole way.
    addQuad(scene, {-50, 0, -80}, {100, 0, 0}, {0, 50, 0}, metal(vec3(1.0f)));
    scene.cameras[0] = lookAt({0, 2, 0}, {0, 1, -80}, 0.002f);
    for (const vec3& c : Stage(scene).onCpu(square(64, 1)).radiance) ASSERT_NEAR(c.x, 0.5f, 0.02f);
}

TEST(Textures, StaySharpNearby) {
    Material checks = matte(vec3(1.0f));
    checks.baseColorTexture = Texture{};
    Scene scene = floorWith(checks);
    scene.images = {imageOf(8, 8, [](uint32_t x, uint32_t y) {
        const uint32_t byte = (x + y) % 2 * 255;
        return Rgba{byte, byte, byte, 255};
    })};
    scene.ambient = vec3(1.0f);
    scene.cameras[0].eye = {0.5f, 3.0f, 0.5f};  // the middle of a texel
    EXPECT_NEAR(pixelOf(scene).x, 0.0f, 1e-5f);
    scene.cameras[0].eye = {1.5f, 3.0f, 0.5f};
    EXPECT_NEAR(pixelOf(scene).x, 1.0f, 1e-5f);
}

// x to the right, y upwards in the image, z out of it, whichever way the coordinates run.
TEST(NormalTextures, TiltTheSurfaceAsTheImageLooks) {
    const auto cosineOf = [](const Rgba& texel, const vec3& towardsLight, bool flipped, float scale, bool tangents) {
        Material bumpy = matte(vec3(1.0f));
        bumpy.normalTexture = Texture{};
        bumpy.normalScale = scale;
        Scene scene = floorWith(bumpy);
        if (flipped)
            for (vec2& uv : scene.meshes[0].uvs) uv.x = 1.0f - uv.x;
        if (tangents) scene.meshes[0].tangents.assign(4, flipped ? vec4(-1, 0, 0, -1) : vec4(1, 0, 0, 1));
        scene.images = {plain(texel)};
        scene.lights = {{.type = Light::Type::directional, .direction = -towardsLight, .intensity = vec3(3.14159265f)}};
        return pixelOf(scene).x;
    };
    const Rgba flat{128, 128, 255, 255}, right{218, 128, 218, 255}, up{128, 218, 218, 255};
    const float tilt = std::sqrt(0.5f);
    for (const bool tangents : {false, true}) {
        EXPECT_NEAR(cosineOf(flat, {0, 1, 0}, false, 1, tangents), 1.0f, 1e-4f);
        EXPECT_NEAR(cosineOf(right, {tilt, tilt, 0}, false, 1, tangents), 1.0f, 1e-4f) << "right in the image is +x";
        EXPECT_NEAR(cosineOf(right, {-tilt, tilt, 0}, true, 1, tangents), 1.0f, 1e-4f) << "now the image is mirrored";
        EXPECT_NEAR(cosineOf(up, {0, tilt, -tilt}, false, 1, tangents), 1.0f, 1e-4f) << "up in the image is away, -z";
        EXPECT_NEAR(cosineOf(up, {0, tilt, -tilt}, true, 1, tangents), 1.0f, 1e-4f);
        EXPECT_NEAR(cosineOf(right, {0, 1, 0}, false, 0, tangents), 1.0f, 1e-4f);
    }
}

TEST(RoughnessTextures, ScaleRoughnessByGreenAndMetallicByBlue) {
    Material m = matte(vec3(0.5f));
    m.metallic = 1.0f;
    m.roughness = 0.5f;
    m.roughnessTexture = Texture{};
    Scene scene = floorWith(m);
    scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(1.0f), .ground = vec3(1.0f)};
    scene.images = {plain({0, 0, 255, 255})};
    EXPECT_NEAR(pixelOf(scene).x, 0.5f, 1e-5f) << "a mirror";
    scene.images = {plain({0, 0, 0, 255})};
    EXPECT_NEAR(pixelOf(scene).x, 0.04f, 1e-5f) << "a polished dielectric";
}

TEST(OcclusionTextures, KeepOutAmbientLightAlone) {
    Material m = matte(vec3(1.0f));
    m.occlusionTexture = Texture{};
    m.occlusionStrength = 0.5f;
    Scene scene = floorWith(m);
    scene.images = {plain({51, 255, 255, 255})};
    scene.ambient = vec3(1.0f);
    EXPECT_NEAR(pixelOf(scene).x, 0.6f, 1e-5f);
    scene.ambient = vec3(0.0f);
    scene.lights = {{.type = Light::Type::directional, .direction = {0, -1, 0}, .intensity = vec3(3.14159265f)}};
    EXPECT_NEAR(pixelOf(scene).x, 1.0f, 1e-5f);
}

// A lamp of which a texture lets half glow lights as much as one half as large, and is seen as the texture says.
TEST(EmissionTextures, GlowAndLightByWhatTheyShow) {
    Material lamp = glowing(vec3(2.0f));
    lamp.emissionTexture = Texture{0, Wrap::clamp, Wrap::clamp};
    Scene scene = floorWith(lamp);
    scene.images = {plain({188, 0, 255, 255})};
    EXPECT_NEAR(pixelOf(scene).x, 2.0 * std::pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-5);
    EXPECT_EQ(pixelOf(scene).y, 0.0f);

    Scene lit;
    addQuad(lit, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, matte(vec3(1.0f)));
    const uint32_t quad = addQuad(lit, {-0.5f, 1, -0.5f}, {1, 0, 0}, {0, 0, 1}, lamp);
    lit.meshes[quad].uvs = {{0, 0}, {1, 0}, {1, 1}, {0, 1}};
    lit.images = {imageOf(64, 1, [](uint32_t x, uint32_t) {
        const uint32_t byte = x < 32 ? 255 : 0;
        return Rgba{byte, byte, byte, 255};
    })};
    lit.cameras = scene.cameras;
    lit.cameras[0].eye = {0.0f, 0.5f, 0.0f};  // below the lamp
    const double textured = Stage(lit).onCpu(square(1, 4096)).radiance[0].x;
    lit.materials.back().emissionTexture.reset();
    lit.meshes[quad].positions = {{-0.5f, 1, -0.5f}, {0.0f, 1, -0.5f}, {0.0f, 1, 0.5f}, {-0.5f, 1, 0.5f}};
    EXPECT_NEAR(textured, Stage(lit).onCpu(square(1, 4096)).radiance[0].x, 0.01 * textured);
}

}  // namespace
}  // namespace raig
