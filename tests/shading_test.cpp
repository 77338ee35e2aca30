// Shaded pictures against closed forms: furnaces, mirrors, lights, shadows, emitters, absorption and textures.
#include "support/rendering.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

Material material(float metallic, float roughness, float transmission, float ior, bool thin,
                  const vec3& color = vec3(1.0f)) {
    Material m;
    m.baseColor = color;
    m.metallic = metallic;
    m.roughness = roughness;
    m.transmission = transmission;
    m.ior = ior;
    m.thin = thin;
    return m;
}

// ---- Whole pictures against closed forms -------------------------------------------------------------------------------

// Where all light has radiance 1, everything that keeps energy looks like 1: what is missing is what was discarded.
TEST(Furnace, GivesOneWithWhatWasDiscarded) {
    std::vector<Material> materials = {material(0, 1, 0, 1.5f, true),     material(1, 0, 0, 1.5f, true),
                                       material(0, 0, 0, 1.5f, true),     material(0, 0, 1, 1.5f, false),
                                       material(0, 0.1f, 1, 1.33f, true), material(0, 0, 0.5f, 1.5f, false),
                                       material(0, 0.2f, 0, 1.5f, true),  material(0, 0, 1, 1.0f, false)};
    for (const float metallic : {0.0f, 0.5f, 1.0f})
        for (const float roughness : {0.2f, 0.5f, 1.0f}) materials.push_back(material(metallic, roughness, 0, 1.5f, true));
    for (size_t m = 0; m < materials.size(); ++m)
        for (const float minContribution : {0.0f, 0.05f}) {
            Scene scene = whiteSky();
            addSphere(scene, vec3(0.0f), 1.0f, 8, m % 2 == 0, materials[m]);
            const Picture picture = Stage(scene).onCpu(square(24, 2, 6, minContribution));
            for (size_t i = 0; i < picture.radiance.size(); ++i)
                ASSERT_NEAR(picture.radiance[i].x + picture.discarded[i], 1.0f, 2e-5f) << "material " << m << " pixel " << i;
        }
}

// A mirror of reflectance K before an emitting mirror of the same kind: a geometric series, cut off after `depth` terms.
TEST(FacingMirrors, SumTheGeometricSeriesAndDiscardItsRest) {
    for (const float reflectance : {0.5f, 0.9f, 0.98f})
        for (const uint32_t depth : {0u, 3u, 8u, 30u, 64u}) {
            Scene scene;
            Material mirror = material(1, 0, 0, 1.5f, true, vec3(reflectance));
            mirror.emission = vec3(0.25f);
            addQuad(scene, {-10, -10, -1}, {20, 0, 0}, {0, 20, 0}, mirror);
            addQuad(scene, {-10, -10, 1}, {0, 20, 0}, {20, 0, 0}, mirror);
            scene.cameras.push_back(lookAt({0.1f, 0.2f, 0}, {0.1f, 0.2f, -1}, 0.001f));
            const Picture picture = Stage(scene).onCpu(square(2, 1, depth));
            const double rest = std::pow(double{reflectance}, depth + 1.0);
            EXPECT_NEAR(picture.radiance[0].x, 0.25 * (1.0 - rest) / (1.0 - reflectance), 2e-5)
                << reflectance << ' ' << depth;
            EXPECT_NEAR(picture.discarded[0], rest, 1e-5) << reflectance << ' ' << depth;
            EXPECT_EQ(picture.statistics.deepest, depth);
        }
}

Material matteGrey() { return material(0, 1, 0, 1.5f, true, vec3(0.5f)); }

float onePixel(const Scene& scene, uint32_t samples = 1) {
    return Stage(scene).onCpu(square(1, samples)).radiance[0].x;
}

TEST(Lights, FallOffByDistanceAngleRangeAndCone) {
    Scene scene = floorFromAbove(matteGrey());
    const vec3 at(2.0f, 1.5f, 0.0f);
    const double squared = 2.0 * 2.0 + 1.5 * 1.5, cosine = 1.5 / std::sqrt(squared);
    const double point = 0.5 / M_PI * 7.0 * cosine / squared;
    scene.lights = {{.type = Light::Type::point, .position = at, .intensity = vec3(7.0f)}};
    EXPECT_NEAR(onePixel(scene), point, 1e-6);
    scene.lights[0].range = 3.0f;
    EXPECT_NEAR(onePixel(scene), point * (1.0 - squared * squared / 81.0), 1e-6);
    scene.lights[0].range = 2.4f;
    EXPECT_EQ(onePixel(scene), 0.0f);

    const double tilt = 0.4;  // between the axis and the direction to the floor's middle
    const double towards = std::atan2(-1.5, -2.0) + tilt;
    scene.lights[0] = {.type = Light::Type::spot,
                       .position = at,
                       .direction = vec3(float(std::cos(towards)), float(std::sin(towards)), 0.0f),
                       .intensity = vec3(7.0f),
                       .innerConeAngle = 0.2f,
                       .outerConeAngle = 0.7f};
    const double edge = (std::cos(tilt) - std::cos(0.7)) / (std::cos(0.2) - std::cos(0.7));
    EXPECT_NEAR(onePixel(scene), point * edge * edge, 1e-6);
    scene.lights[0].outerConeAngle = 0.3f;
    EXPECT_EQ(onePixel(scene), 0.0f);

    scene.lights[0] = {.type = Light::Type::directional, .direction = vec3(0.6f, -0.8f, 0.0f), .intensity = vec3(2.0f)};
    EXPECT_NEAR(onePixel(scene), 0.5 / M_PI * 2.0 * 0.8, 1e-6);
    scene.lights[0].direction = vec3(0.6f, 0.8f, 0.0f);  // from below
    EXPECT_EQ(onePixel(scene), 0.0f);
}

TEST(Shadows, FallFromWhatIsOpaqueAndNotFromGlass) {
    for (const bool opaque : {true, false}) {
        Scene scene = floorFromAbove(matteGrey());
        scene.lights = {{.type = Light::Type::point, .position = {2, 2, 0}, .intensity = vec3(7.0f)}};
        const float lit = onePixel(scene);
        addQuad(scene, {0.5f, 1, 1}, {1, 0, 0}, {0, 0, -2}, material(0, 0, opaque ? 0.0f : 1.0f, 1.5f, true));
        EXPECT_EQ(onePixel(scene), opaque ? 0.0f : lit);
    }
}

// Irradiance below a rectangular emitter has a closed form [Howell, configuration factor B-4]; the mean of many samples is
// within 4 standard errors of it.
TEST(Emitters, LightTheFloorBelowAsTheConfigurationFactorSays) {
    Scene scene = floorFromAbove(matteGrey());
    addQuad(scene, {0.0f, 1.0f, 0.0f}, {1.0f, 0, 0}, {0, 0, -0.5f}, glowing(vec3(3.0f)));
    scene.cameras[0].eye.y = 0.5f;  // below the lamp
    const double x = 1.0, y = 0.5;
    const double factor = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                           y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) /
                          (2.0 * M_PI);
    double sum = 0.0, squares = 0.0;
    constexpr int runs = 64;
    for (int run = 0; run < runs; ++run) {
        FrameOptions options = square(1, 16);
        options.seed = static_cast<uint32_t>(run);
        const double value = Stage(scene).onCpu(options).radiance[0].x;
        sum += value;
        squares += value * value;
    }
    const double mean = sum / runs, error = std::sqrt((squares / runs - mean * mean) / (runs - 1));
    EXPECT_NEAR(mean, 0.5 * 3.0 * factor, 4.0 * error);
    EXPECT_LT(error, 0.01 * mean);
}

// Shadow rays end at the emitter itself: rounding over their length must not make it hide its own point. (Without room for
// that at the far end, some four in 65,536 of these do.)
TEST(Emitters, DoNotHideThemselves) {
    Scene scene;
    addQuad(scene, {0, 0, 560}, {550, 0, 0}, {0, 0, -560}, material(0, 1, 0, 1.5f, true));
    Material lamp;
    lamp.emission = vec3(1.0f);
    addQuad(scene, {213, 548.7f, 227}, {130, 0, 0}, {0, 0, 105}, lamp);
    Camera camera;
    camera.orthographic = true;
    camera.eye = {275, 500, 280};
    camera.forward = {0, -1, 0};
    camera.right = {1, 0, 0};
    camera.up = {0, 0, -1};
    camera.xmag = camera.ymag = 270;
    scene.cameras.push_back(camera);
    const Stage stage(scene);
    size_t dark = 0;
    for (uint32_t seed = 0; seed < 4; ++seed) {
        FrameOptions options = square(256, 1);
        options.seed = seed;
        dark += std::ranges::count(stage.onCpu(options).radiance, vec3(0.0f));
    }
    EXPECT_EQ(dark, 0u);
}

// A slab that absorbs: what is behind it is seen through its thickness, straight on.
TEST(Absorption, FollowsBeerAndLambert) {
    Scene scene;
    scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(1.0f), .ground = vec3(1.0f)};
    Material slab = material(0, 0, 1, 1.0f, false);  // refraction index 1: nothing is reflected
    slab.attenuationColor = vec3(0.5f, 0.25f, 1.0f);
    slab.attenuationDistance = 2.0f;
    addQuad(scene, {-5, -5, 0}, {10, 0, 0}, {0, 10, 0}, slab);
    addQuad(scene, {-5, -5, -3}, {0, 10, 0}, {10, 0, 0}, slab);
    scene.cameras.push_back(lookAt({0, 0, 2}, {0, 0, 0}, 1e-4f));
    const vec3 seen = Stage(scene).onCpu(square(1, 1)).radiance[0];
    EXPECT_NEAR(seen.x, std::pow(0.5, 1.5), 1e-6);
    EXPECT_NEAR(seen.y, std::pow(0.25, 1.5), 1e-6);
    EXPECT_NEAR(seen.z, 1.0, 1e-6);
}

// ---- Textures ----------------------------------------------------------------------------------------------------------

/// The colour at (u, v) of a texture 2 texels wide and 1 high, black then white.
float textureAt(float u, Wrap wrap) {
    Scene scene = floorFromAbove(material(0, 1, 0, 1.5f, true));
    scene.images.push_back({2, 1, {0, 0, 0, 255, 255, 255, 255, 255}});
    scene.materials[0].baseColorTexture = Texture{0, wrap, wrap};
    scene.meshes[0].uvs.assign(4, vec2(u, 0.5f));
    scene.ambient = vec3(1.0f);
    return onePixel(scene);
}

TEST(Textures, AreBilinearAndWrapAsTold) {
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        EXPECT_NEAR(textureAt(0.25f, wrap), 0.0f, 1e-6f);
        EXPECT_NEAR(textureAt(0.5f, wrap), 0.5f, 1e-6f);
        EXPECT_NEAR(textureAt(0.75f, wrap), 1.0f, 1e-6f);
    }
    EXPECT_NEAR(textureAt(0.0f, Wrap::repeat), 0.5f, 1e-6f);
    EXPECT_NEAR(textureAt(0.0f, Wrap::clamp), 0.0f, 1e-6f);
    EXPECT_NEAR(textureAt(0.0f, Wrap::mirror), 0.0f, 1e-6f);
    EXPECT_NEAR(textureAt(1.25f, Wrap::repeat), 0.0f, 1e-6f);
    EXPECT_NEAR(textureAt(1.25f, Wrap::clamp), 1.0f, 1e-6f);
    EXPECT_NEAR(textureAt(1.25f, Wrap::mirror), 1.0f, 1e-6f);
    EXPECT_NEAR(textureAt(-0.25f, Wrap::repeat), 1.0f, 1e-6f);
    EXPECT_NEAR(textureAt(-0.25f, Wrap::mirror), 0.0f, 1e-6f);
    EXPECT_NEAR(textureAt(-7e30f, Wrap::clamp), 0.0f, 1e-6f);
    for (const Wrap wrap : {Wrap::repeat, Wrap::mirror}) {
        const float far = textureAt(3e30f, wrap);
        EXPECT_TRUE(far >= 0.0f && far <= 1.0f);
    }
}

TEST(Textures, AreDecodedFromSrgb) {
    Scene scene = floorFromAbove(material(0, 1, 0, 1.5f, true));
    scene.images.push_back({1, 1, {188, 188, 188, 255}});
    scene.materials[0].baseColorTexture = Texture{};
    scene.meshes[0].uvs.assign(4, vec2(0.0f));
    scene.ambient = vec3(1.0f);
    EXPECT_NEAR(onePixel(scene), std::pow((188 / 255.0 + 0.055) / 1.055, 2.4), 1e-6);
}

}  // namespace
}  // namespace raig
