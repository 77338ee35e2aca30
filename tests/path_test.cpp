// Path tracing against closed forms, on the CPU and by the reference; that it has no bias; and that it is the same wherever
// it is asked for.
#include "measure/compare.hpp"
#include "reference/picture.hpp"
#include "reference/world.hpp"
#include "support/paths.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// A closed box of edge 2 around the origin, its faces inwards; the camera is within.
Scene closedBox(const Material& material) {
    Scene scene;
    for (int axis = 0; axis < 3; ++axis)
        for (const float side : {-1.0f, 1.0f}) {
            vec3 corner(-1.0f), u(0.0f), v(0.0f);
            corner[axis] = side;
            u[(axis + 1) % 3] = v[(axis + 2) % 3] = 2.0f;
            if (side > 0.0f) std::swap(u, v);
            addQuad(scene, corner, u, v, material);
        }
    scene.cameras.push_back(lookAt({0.3f, -0.2f, 0.4f}, {-1, 0.5f, -0.7f}, 1.2f));
    return scene;
}

Material greyGlow(float albedo, float emission) {
    Material material = matte(vec3(albedo));
    material.emission = vec3(emission);
    return material;
}

// Devices give the CPU's bits: see below.
INSTANTIATE_TEST_SUITE_P(, Paths, testing::Values("cpu", "reference"), testName);

// In light of radiance 1 from everywhere all that keeps energy looks like 1, however often light goes to and fro; without
// noise, as every way out weighs what it is chosen by.
TEST_P(Paths, InAFurnaceAreOneWhateverTheMaterial) {
    for (const Material& material : {matte(vec3(1.0f)), metal(vec3(1.0f)), glass(1.5f), glass(1.0f)})
        for (const bool isTrue : {false, true}) {
            Scene scene = whiteSky();
            scene.ambient = vec3(0.0f);
            if (isTrue)
                addTrueSphere(scene, vec3(0.0f), 1.0f, material);
            else
                addSphere(scene, vec3(0.0f), 1.0f, 6, false, material);
            addQuad(scene, {-3, -1.2f, 3}, {6, 0, 0}, {0, 0, -6}, matte(vec3(1.0f)));
            for (const dvec3& pixel : render(scene, paths(12, 2, 1000)))
                ASSERT_NEAR(pixel.x, 1.0, 1e-4) << "sphere " << isTrue;
        }
}

// The same in the light of a picture, which is drawn from as well.
TEST_P(Paths, InTheLightOfAnEvenEnvironmentAreOneOnTheAverage) {
    for (const Material& material :
         {matte(vec3(1.0f)), metal(vec3(1.0f)), metal(vec3(1.0f), 0.3f), metal(vec3(1.0f), 0.6f), glass(1.5f)}) {
        Scene scene;
        addTrueSphere(scene, vec3(0.0f), 1.0f, material);
        addQuad(scene, {-3, -1.2f, 3}, {6, 0, 0}, {0, 0, -6}, matte(vec3(1.0f)));
        scene.cameras.push_back(lookAt({0, 0.3f, 4}, {0, 0, 0}));
        scene.environment = makeEnvironment(8, std::vector<vec3>(64, vec3(1.0f)));
        const Sample mean = meansOf(scene, paths(12, 4, 100));
        if (material.roughness == 0.3f || material.roughness == 0.6f)
            EXPECT_NEAR(mean.mean, 1.0, 0.033) << "as good as the lobe's albedo is fitted; roughness " << material.roughness;
        else
            expectMean(mean, 1.0, 0.02);
    }
}

// Within a closed room whose walls glow by e and reflect a, light that has been reflected k times is a^k e: all of it up to
// one more than the depth, as the last point still asks for direct light.
TEST_P(Paths, InAGlowingBoxSumTheGeometricSeries) {
    for (const uint32_t depth : {2u, 7u}) {
        const float albedo = 0.6f;
        const double want = (1.0 - std::pow(double{albedo}, depth + 2.0)) / (1.0 - albedo);
        expectMean(meansOf(closedBox(greyGlow(albedo, 1.0f)), paths(8, 8, depth)), want, 0.04);
    }
}

// A sphere is no light to draw from: so there is no noise either, and the series ends at the depth.
TEST_P(Paths, InAGlowingSphereSumTheGeometricSeriesWithoutNoise) {
    for (const uint32_t depth : {0u, 3u, 20u, 64u}) {
        Scene scene;
        const float albedo = 0.75f;
        addTrueSphere(scene, vec3(0.0f), 2.0f, greyGlow(albedo, 0.5f));
        scene.cameras.push_back(lookAt({0.5f, 0.25f, 0}, {0, 1, -1}));
        const double want = 0.5 * (1.0 - std::pow(double{albedo}, depth + 1.0)) / (1.0 - albedo);
        for (const dvec3& pixel : render(scene, paths(6, 2, depth))) ASSERT_NEAR(pixel.x, want, 1e-5) << depth;
    }
}

// Drawn from the lamp alone light has a variance there that has no bound.
TEST_P(Paths, LightAFloorByTheFormFactorUpToTheLampsFoot) {
    expectMean(meansOf(lampOnFloor(0.5f, 3.0f), paths(12, 16, 3)), 0.5 * 3.0 * formFactor, 0.02);
}

// What a lamp sends through glass that neither bends nor absorbs is what it sends without: only drawn rays find it.
TEST_P(Paths, FindTheirWayThroughGlass) {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    Material pane = glass(1.0f);
    pane.thin = true;
    addQuad(scene, {4e-4f, -1, -1}, {0, 3, 0}, {0, 0, 3}, pane);
    expectMean(meansOf(scene, paths(12, 64, 3)), 0.5 * 3.0 * formFactor, 0.05);
}

/// As much of it is there as alpha says.
Material veil(float alpha) {
    Material material = matte(vec3(0.0f));
    material.alpha = alpha;
    return material;
}

// What a black veil lets pass by its alpha both kinds of rays find, and share.
TEST_P(Paths, PassWhatIsNotThereByItsAlpha) {
    Scene scene = lampOnFloor(0.5f, 3.0f);
    addQuad(scene, {4e-4f, -1, -1}, {0, 3, 0}, {0, 0, 3}, veil(0.75f));
    addQuad(scene, {8e-4f, -1, -1}, {0, 3, 0}, {0, 0, 3}, veil(0.2f));
    expectMean(meansOf(scene, paths(12, 32, 3)), 0.25 * 0.8 * 0.5 * 3.0 * formFactor, 0.04);
}

// A rough metal that reflects all looks like 1 in a furnace, but for the fit of what it gains for light that goes from facet
// to facet: 0.033 at most.
TEST_P(Paths, OfRoughMetalLoseNoLight) {
    for (const float roughness : {0.2f, 0.5f, 1.0f}) {
        Scene scene = whiteSky();
        addTrueSphere(scene, vec3(0.0f), 1.0f, metal(vec3(1.0f), roughness));
        const Sample mean = meansOf(scene, paths(16, 8, 20));
        EXPECT_NEAR(mean.mean, 1.0, 0.02) << roughness;
        EXPECT_LT(mean.error, 0.003) << roughness;
    }
}

// Light without size shines through glass, as no drawn ray could meet it.
TEST_P(Paths, LetLightsShineThroughGlass) {
    Scene scene = floorFromAbove(matte(vec3(0.5f)));
    scene.lights = {{.type = Light::Type::point, .position = {0, 2, 0.5f}, .intensity = vec3(7.0f)}};
    const dvec3 lit = render(scene, paths(1, 1)).at(0);
    addQuad(scene, {-1, 1, 1}, {2, 0, 0}, {0, 0, -2}, glass(1.5f));
    scene.cameras[0].eye.y = 0.5f;
    EXPECT_GT(lit.x, 0.1);
    EXPECT_NEAR(render(scene, paths(1, 1)).at(0).x, lit.x, 1e-6);
}

// ---- What of it is chance ----------------------------------------------------------------------------------------------

/// Of many pictures' means, by seed.
Sample manyMeans(const Stage& stage, FrameOptions options, uint32_t seeds) {
    std::vector<double> means;
    for (options.seed = 0; options.seed < seeds; ++options.seed) {
        double sum = 0.0;
        for (const vec3& c : stage.onCpu(options).radiance) sum += c.y;
        means.push_back(sum);
    }
    return sampleOf(means);
}

/// Expects two means to be one by a t-test at p = 1e-4, and that they are known to `precision` of them.
void expectSame(const Sample& a, const Sample& b, double precision) {
    const double error = 4.2 * std::hypot(a.error, b.error);
    EXPECT_NEAR(a.mean, b.mean, error);
    EXPECT_LT(error, precision * a.mean) << "the test could not tell";
}

// Both kinds of rays together are no brighter than rays to the lamp alone, which are Whitted's, but quieter where the lamp
// is near.
TEST(PathChance, OfTwoKindsOfRaysIsThatOfOneButForItsNoise) {
    const Stage stage(lampOnFloor(0.5f, 3.0f));
    FrameOptions one = square(12, 16, 0), both = paths(12, 16, 1);
    const Sample rays = manyMeans(stage, one, 256), mixed = manyMeans(stage, both, 64);
    expectSame(rays, mixed, 0.08);
    EXPECT_LT(mixed.error, 0.7 * rays.error) << "of a quarter of the pictures";
}

TEST(PathChance, OfEndingEarlyChangesNoMeanAndSavesRays) {
    const Stage stage(importScene(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"));
    const FrameOptions all = paths(12, 4, 12, 0.0f), ended = paths(12, 4, 12, 1.0f);
    expectSame(manyMeans(stage, all, 128), manyMeans(stage, ended, 256), 0.08);
    EXPECT_LT(stage.onCpu(ended).statistics.closestRays, stage.onCpu(all).statistics.closestRays / 2);
}

TEST(PathDepth, IsDiscardedWhereItEnds) {
    Scene scene;
    const float albedo = 0.75f;
    addTrueSphere(scene, vec3(0.0f), 2.0f, greyGlow(albedo, 0.5f));
    scene.cameras.push_back(lookAt({0.5f, 0.25f, 0}, {0, 1, -1}));
    const Stage stage(scene);
    for (const uint32_t depth : {0u, 3u, 20u}) {
        const Picture picture = stage.onCpu(paths(6, 2, depth));
        EXPECT_EQ(picture.statistics.deepest, depth);
        EXPECT_EQ(picture.statistics.closestRays, 36u * 2u * (depth + 1));
        for (const float discarded : picture.discarded) EXPECT_NEAR(discarded, std::pow(albedo, depth + 1.0f), 1e-5);
    }
}

// ---- Everywhere the same -----------------------------------------------------------------------------------------------

/// Matte, a mirror, nested glass, smooth normals, textures, lights of all kinds, and an instance.
Scene furnished(bool hasEnvironment) {
    Scene scene = variedRoom();
    const uint32_t ball = addSphere(scene, {-1.4f, 1, 0}, 0.8f, 10, true, matte({0.8f, 0.7f, 0.6f}));
    addTrueSphere(scene, {0.3f, 0.7f, 1}, 0.6f, tintedGlass());
    addTrueSphere(scene, {0.3f, 0.7f, 1}, 0.3f, glass(1.2f));
    addTrueSphere(scene, {1.9f, 1, -0.5f}, 0.8f, metal({0.9f, 0.8f, 0.5f}));
    addTrueSphere(scene, {-2.6f, 0.5f, 1}, 0.5f, metal({0.9f, 0.6f, 0.5f}, 0.4f));
    Material plastic = matte({0.2f, 0.5f, 0.8f});
    plastic.roughness = 0.3f;
    addSphere(scene, {2.4f, 2.6f, 0}, 0.6f, 8, true, plastic);
    addQuad(scene, {-1, 2.5f, 0}, {2, 0, 0}, {0, 0, 2}, veil(0.6f));
    addQuad(scene, {-0.5f, 3.9f, 0}, {1, 0, 0}, {0, 0, 1}, glowing({4.0f, 3.0f, 2.0f}));
    dmat4 moved(0.5);
    moved[3] = dvec4(2.2, 0.3, 2.0, 1);
    scene.instances.push_back({ball, moved});
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)}};
    if (hasEnvironment) {
        std::vector<vec3> texels;
        for (uint32_t i = 0; i < 16 * 16; ++i)
            texels.push_back(vec3(0.1f + 0.01f * float(i % 7), 0.2f, i == 40 ? 20.0f : 0.3f));
        scene.environment = makeEnvironment(16, texels);
    }
    return scene;
}

TEST(PathPicture, IsTheReferences) {
    for (const bool hasEnvironment : {false, true}) {
        const Stage stage(furnished(hasEnvironment));
        const reference::World world(stage.scene, stage.geometry);
        const FrameOptions options = paths(40, 2, 5, 1.0f / 512.0f);
        reference::PictureOptions same;
        same.width = same.height = 40;
        same.samples = 2;
        same.bounds = {options.maxDepth, options.minContribution, 0};
        same.integrator = Integrator::path;
        const reference::Picture expected = reference::render(world, same);
        const Picture picture = stage.onCpu(options);
        Image image(40, 40);
        image.pixels = picture.radiance;
        const PictureComparison got = compareToReference(image, expected);
        EXPECT_LT(got.outsideTies.rmse, 5e-5);
        EXPECT_EQ(got.outsideTies.nan, 0u);
        EXPECT_LT(got.ties, 40u * 40u / 10);
        EXPECT_FALSE(got.blank);
        size_t others = 0;
        for (size_t i = 0; i < picture.discarded.size(); ++i)
            others += std::abs(picture.discarded[i] - expected.discarded[i]) > 1e-4;
        EXPECT_LT(others, picture.discarded.size() / 20);
    }
}

class PathOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, PathOnDevice, testing::ValuesIn(devicesToTest()), testName);

// Also by kept instances, in small tiles, where samples are needed, and between pictures by other integrators.
TEST_P(PathOnDevice, LooksAsOnTheCpuToTheBit) {
    Device device(info);
    for (const bool keeps : {false, true})
        expectTheCpusBits(device, keeps ? Stage::kept(furnished(true)) : Stage(furnished(false)),
                          paths(32, 3, 6, 1.0f / 512.0f));
}

}  // namespace
}  // namespace raig
