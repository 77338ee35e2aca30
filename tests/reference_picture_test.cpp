// The double-precision reference's lights, textures and pictures, against closed forms and what must not change.
#include "support/reference_scenes.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace raig::reference {
namespace {

using namespace test;

// ---- Lights ------------------------------------------------------------------------------------------------------------

/// What a rectangle of sides x and y, its corner h above the point and parallel to the floor, sends there as a share of pi
/// times its radiance. Source: Howell 2010, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4.
double configurationFactor(double x, double y, double h) {
    const double a = x / h, b = y / h, ra = std::sqrt(1.0 + a * a), rb = std::sqrt(1.0 + b * b);
    return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2.0 * pi);
}

TEST(ReferenceLights, ASquareLampLightsTheFloorAsItsFormulaSays) {
    Builder builder;
    const uint32_t floor = builder.material(white()), bright = builder.material(lamp(4.0f));
    builder.quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18), floor);
    builder.quad(vec3(0, 2, 0), vec3(1, 0, 0), vec3(0, 0, 1), bright);
    const Made made(builder.scene);
    // The floor's points p at x, z <= 0: the lamp is the difference of rectangles with a corner above p.
    for (const dvec2& p : {dvec2(0.0, 0.0), dvec2(-0.5, 0.0), dvec2(-1.0, -2.0), dvec2(-3.0, -0.25)}) {
        const auto factor = [&](double x, double z) { return configurationFactor(x, z, 2.0); };
        const double x0 = -p.x, x1 = 1.0 - p.x, z0 = -p.y, z1 = 1.0 - p.y;
        const double want = 4.0 * (factor(x1, z1) - factor(x0, z1) - factor(x1, z0) + factor(x0, z0));
        // Different pixels are independent, the samples of one are not.
        constexpr uint32_t count = 40000;
        double sum = 0.0, squares = 0.0;
        for (uint32_t pixel = 0; pixel < count; ++pixel) {
            const Ray ray = rayTo(dvec3(p.x - 1.0, 1.0, p.y - 1.0), dvec3(p.x, 0.0, p.y));
            const double value = traceRay(made.world, ray, bounds(0), {pixel, 0}).value.x;
            sum += value;
            squares += value * value;
        }
        const double mean = sum / count, deviation = std::sqrt((squares / count - mean * mean) / count);
        EXPECT_NEAR(mean, want, 3.9 * deviation) << "p < 1e-4 at (" << p.x << ", " << p.y << ")";
        EXPECT_LT(deviation, 0.01 * want) << "the test could not tell";
    }
}

TEST(ReferenceLights, PointSpotAndSunFollowTheirLaws) {
    Light light;
    light.position = vec3(0, 2, 0);
    light.intensity = vec3(8.0f);
    const dvec3 up(0, 1, 0);
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0, 1e-15);
    EXPECT_NEAR(arriving(light, dvec3(2, 0, 0), up).irradiance.x, 8.0 / 8.0 * std::sqrt(0.5), 1e-15);
    light.range = 4.0f;
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0 * (1.0 - 1.0 / 16.0), 1e-15);
    light.range = 1.9f;
    EXPECT_EQ(arriving(light, dvec3(0.0), up).irradiance.x, 0.0);

    light.range = 0.0f;
    light.type = Light::Type::spot;
    light.direction = vec3(0, -1, 0);
    light.innerConeAngle = 0.0f;
    light.outerConeAngle = static_cast<float>(pi / 3.0);
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0, 1e-15);
    const double ramp = (std::sqrt(0.5) - 0.5) / 0.5;
    EXPECT_NEAR(arriving(light, dvec3(2, 0, 0), up).irradiance.x, std::sqrt(0.5) * ramp * ramp, 1e-7);
    EXPECT_EQ(arriving(light, dvec3(4, 0, 0), up).irradiance.x, 0.0);

    light.type = Light::Type::directional;
    light.direction = vec3(0.6f, -0.8f, 0);
    EXPECT_NEAR(arriving(light, dvec3(5, 5, 5), up).irradiance.x, 6.4, 1e-6);
}

TEST(ReferenceLights, OpaqueThingsCastShadowsAndClearOnesDoNot) {
    for (const bool opaque : {true, false}) {
        Builder builder;
        const uint32_t floor = builder.material(white()), between = builder.material(opaque ? white() : clear(1.5f, true));
        builder.quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18), floor);
        builder.quad(vec3(-1, 1, 1), vec3(2, 0, 0), vec3(0, 0, -2), between);
        Light light;
        light.position = vec3(0, 2, 0);
        light.intensity = vec3(static_cast<float>(pi));
        builder.scene.lights = {light};
        const Made made(builder.scene);
        const auto seen = [&](const dvec3& p) {
            return traceRay(made.world, rayTo(p + dvec3(0, 0.5, 0), p), bounds(0), {}).value.x;
        };
        EXPECT_NEAR(seen(dvec3(0.0)), opaque ? 0.0 : 0.25, 1e-7);
        EXPECT_NEAR(seen(dvec3(3, 0, 0)), std::pow(13.0, -1.5) * 2.0, 1e-7) << "outside the shadow";
    }
}

// ---- Textures, cameras, pictures ---------------------------------------------------------------------------------------

TEST(ReferenceTexture, IsBilinearAndWraps) {
    Scene scene;
    Texels image{2, 1, {0, 0, 0, 255, 255, 255, 255, 0}};
    scene.images = {image};
    scene.materials.resize(1);
    scene.materials[0].baseColorTexture = Texture{};
    const Pyramids pyramids(scene);
    const auto red = [&](double u, Wrap wrap) { return pyramids.lookUp({0, wrap, wrap}, true, {u, 0.5}, 0.0).x; };
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        EXPECT_EQ(red(0.25, wrap), 0.0);
        EXPECT_EQ(red(0.75, wrap), 1.0);
        EXPECT_NEAR(red(0.4, wrap), 0.3, 1e-15);
    }
    EXPECT_NEAR(red(1.0, Wrap::repeat), 0.5, 1e-15);
    EXPECT_NEAR(red(1.0, Wrap::clamp), 1.0, 1e-15);
    EXPECT_NEAR(red(1.25, Wrap::mirror), 1.0, 1e-15);
    EXPECT_NEAR(red(1.25, Wrap::repeat), 0.0, 1e-15);
    EXPECT_NEAR(red(-0.25, Wrap::repeat), 1.0, 1e-15);
    EXPECT_NEAR(red(-0.25, Wrap::mirror), 0.0, 1e-15);
    EXPECT_NEAR(red(-1e9 + 0.25, Wrap::repeat), 0.0, 1e-15);
    scene.images[0] = {1, 1, {188, 188, 188, 188}};
    const dvec4 grey = Pyramids(scene).lookUp({}, true, {0.5, 0.5}, 0.0);
    EXPECT_NEAR(grey.x, 0.5, 0.005);
    EXPECT_EQ(grey.w, 188 / 255.0) << "alpha is linear";
}

TEST(ReferencePicture, CameraRaysSpanTheFrame) {
    Camera camera;
    camera.yfov = static_cast<float>(pi / 2.0);
    PictureOptions options;
    options.width = 4;
    options.height = 2;
    const dvec3 d = cameraRay(camera, options, 3, 0, 0).direction;
    EXPECT_NEAR(d.x / -d.z, 1.5, 1e-7);
    EXPECT_NEAR(d.y / -d.z, 0.5, 1e-7);
    camera.orthographic = true;
    camera.xmag = camera.ymag = 3.0f;
    EXPECT_EQ(cameraRay(camera, options, 3, 0, 0).origin, dvec3(4.5, 1.5, 1.0)) << "the wider picture sees more, not less";
}

// The left half of the picture is an emitter whose edge runs through the centres of a column of pixels.
TEST(ReferencePicture, OnlyPixelsThatRoundingCanChangeAreSensitive) {
    Builder builder;
    builder.material(lamp(1.0f));
    builder.quad(vec3(-5, -5, 0), vec3(5, 0, 0), vec3(0, 10, 0));
    Camera camera;
    camera.orthographic = true;
    builder.scene.cameras = {camera};
    const Made made(builder.scene);
    PictureOptions options;
    options.width = options.height = 9;
    const Picture picture = render(made.world, options);
    for (uint32_t i = 0; i < 81; ++i) {
        const uint32_t x = i % 9;
        EXPECT_EQ(picture.sensitivity[i], x == 4 ? 1.0 : 0.0) << "pixel " << i;
        if (x != 4) {
            EXPECT_EQ(picture.radiance[i].x, x < 4 ? 1.0 : 0.0);
        }
    }
    // 1e-4 of a pixel beside the edge, rounding changes nothing.
    builder.scene.cameras[0].eye.x = 2.0f / 9.0f * 1e-4f;
    const Picture beside = render(Made(builder.scene).world, options);
    EXPECT_EQ(*std::max_element(beside.sensitivity.begin(), beside.sensitivity.end()), 0.0);
}

TEST(ReferencePicture, IsTheSameEveryTime) {
    Scene scene = closedSphere(12, 1.0f, vec3(0.0f));
    scene.materials = {clear(1.5f)};
    Light sun;
    sun.type = Light::Type::directional;
    scene.lights = {sun};
    scene.sky = {vec3(0.2f, 0.4f, 1.0f), vec3(1.0f), vec3(0.1f)};
    Camera camera;
    camera.eye = vec3(0, 0, 4);
    scene.cameras = {camera};
    const Made made(scene);
    PictureOptions options;
    options.width = 33;
    options.height = 17;
    options.samples = 3;
    double last = 0.0;
    const Picture first = render(made.world, options, [&](double done) {
        EXPECT_GT(done, last);
        last = done;
    });
    const Picture second = render(made.world, options);
    EXPECT_EQ(last, 1.0);
    EXPECT_EQ(first.radiance, second.radiance);
    EXPECT_EQ(first.sensitivity, second.sensitivity);
    EXPECT_EQ(first.discarded, second.discarded);
}

}  // namespace
}  // namespace raig::reference
