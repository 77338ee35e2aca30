// Spheres in pictures: rays that leave them, what shading makes of them, on every device and against the reference.
#include "base/random.hpp"
#include "measure/compare.hpp"
#include "measure/compare_rays.hpp"
#include "rays/frame_kernels.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

/// Spheres of every kind among triangles with texture, vertex colours and normals; an air bubble in glass; lights of two
/// kinds.
Scene variedScene() {
    Scene scene = variedRoom();
    addSphere(scene, {2.6f, 0.8f, 0.5f}, 0.8f, 8, true, metal(vec3(0.8f)));
    addTrueSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, tintedGlass());
    addTrueSphere(scene, {-1.2f, 1.0f, 0.5f}, 0.4f, glass(1.0f / 1.5f));  // air, as seen from the glass
    addTrueSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, metal(vec3(0.9f, 0.8f, 0.5f)));
    addTrueSphere(scene, {0.3f, 0.5f, 2.0f}, 0.5f, matte(vec3(0.2f, 0.3f, 0.8f)));
    const Material lamp = glowing(vec3(9.0f, 8.0f, 7.0f));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, lamp);
    addTrueSphere(scene, {3.0f, 3.0f, 0.0f}, 0.3f, lamp);
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)}};
    // In the glass, between its surface and the bubble.
    scene.cameras.push_back(lookAt({-1.2f, 1.0f, 0.0f}, {0.0f, 1.0f, 0.0f}));
    return scene;
}

// ---- Rays that leave spheres -------------------------------------------------------------------------------------------

// From either side, at every size and place: outwards a ray never meets its sphere again; inwards it meets it once, at the
// far end of its chord; and it starts nearer to the surface than 8 ULP of the largest coordinate.
TEST(SpheresRays, LeaveThemOnTheRightSide) {
    shared::FrameKernels code;
    Random random(31);
    size_t outwards = 0, inwards = 0;
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : {dvec3(0), dvec3(1e4, -1e4, 1e4), dvec3(-1e6, 1e6, 1e6)}) {
            if (size < glm::length(place) * 1e-4) continue;
            const Primitive sphere = Primitive::sphere(vec3(place), static_cast<float>(size));
            const float reach = float(glm::length(place) + size);
            const double gap = 8.0 * (std::nextafter(reach, INFINITY) - reach);
            std::vector<Ray> rays;
            std::vector<double> cosines;
            for (int i = 0; i < 20'000; ++i) {
                const vec3 n = code.unit(vec3(random.direction()));
                const vec3 side = i % 2 == 0 ? n : -n;
                dvec3 d = random.direction();
                d -= glm::dot(d, dvec3(side)) * (i % 4 < 2 ? 1.0 - std::pow(10.0, -4.0 * random.unit()) : 0.0) * dvec3(side);
                if (glm::dot(d, dvec3(side)) < 0.0) d = -d;
                const vec3 direction(glm::normalize(d));
                const double cosine = glm::dot(dvec3(direction), dvec3(side));
                if (!(cosine > 1e-6)) continue;
                const auto point = code.pointOfSphere(sphere.centre(), sphere.radius(), n);
                const vec3 origin = code.spawnOrigin(point, side);
                const double height = glm::length(dvec3(origin) - dvec3(sphere.centre())) - sphere.radius();
                ASSERT_TRUE(i % 2 == 0 ? height > 0.0 : height < 0.0) << size << " at " << place.x;
                ASSERT_LE(std::abs(height), gap) << size << " at " << place.x;
                rays.push_back({origin, 0.0f, direction, shared::FAR_AWAY});
                cosines.push_back(i % 2 == 0 ? -1.0 : cosine);
            }
            const Structure structure = structureType("bvh").build(std::vector{sphere}, {});
            std::vector<Hit> hits(rays.size());
            makeCpuTracer(structure)->trace(rays, hits, Query::closest);
            for (size_t i = 0; i < rays.size(); ++i) {
                if (cosines[i] < 0.0) {
                    ASSERT_EQ(hits[i].primitive, NO_HIT) << size << " at " << place.x << " t " << hits[i].t;
                    ++outwards;
                } else {
                    ASSERT_EQ(hits[i].primitive, 0u) << size << " at " << place.x;
                    const double allowed = 0.05 * size * cosines[i] + 20.0 * gap / cosines[i];
                    ASSERT_NEAR(hits[i].t, 2.0 * size * cosines[i], allowed) << size << " at " << place.x;
                    ++inwards;
                }
            }
        }
    EXPECT_GT(outwards, 80'000u);
    EXPECT_GT(inwards, 80'000u);
}

// ---- Closed forms ------------------------------------------------------------------------------------------------------

TEST(SpheresFurnace, GivesOneWithWhatWasDiscarded) {
    for (const Material& material : {matte(vec3(1.0f)), metal(vec3(1.0f)), glass(1.5f), glass(1.0f)}) {
        Scene scene = whiteSky();
        addTrueSphere(scene, vec3(0.0f), 1.0f, material);
        const Picture picture = Stage(scene).onCpu(square(32, 2, 6));
        for (size_t i = 0; i < picture.radiance.size(); ++i)
            ASSERT_NEAR(picture.radiance[i].x + picture.discarded[i], 1.0f, 2e-5f)
                << "metallic " << material.metallic << " pixel " << i;
    }
}

// Along a diameter, light passes straight on, dimmed by the length inside.
TEST(SpheresOfGlass, AbsorbByTheirDiameter) {
    Scene scene;
    scene.sky = {.zenith = vec3(1.0f), .horizon = vec3(1.0f), .ground = vec3(1.0f)};
    Material dim = glass(1.0f);
    dim.attenuationColor = vec3(0.5f, 0.25f, 1.0f);
    dim.attenuationDistance = 2.0f;
    addTrueSphere(scene, vec3(0.0f), 1.5f, dim);
    scene.cameras.push_back(lookAt({0, 0, 5}, {0, 0, 0}, 1e-4f));
    const vec3 seen = Stage(scene).onCpu(square(1, 1)).radiance[0];
    EXPECT_NEAR(seen.x, std::pow(0.5, 1.5), 1e-6);
    EXPECT_NEAR(seen.y, std::pow(0.25, 1.5), 1e-6);
    EXPECT_NEAR(seen.z, 1.0, 1e-6);
}

TEST(SpheresThatGlow, AreSeenAndLightNothing) {
    Scene scene;
    addTrueSphere(scene, {0, 1, 0}, 0.5f, glowing(vec3(3.0f)));
    addQuad(scene, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, matte(vec3(0.5f)));
    scene.cameras.push_back(lookAt({0, 1, 4}, {0, 1, 0}, 1e-4f));
    scene.cameras.push_back(lookAt({0, 1, 4}, {0, 0, 1}, 1e-4f));
    FrameOptions options = square(1, 4);
    EXPECT_EQ(Stage(scene).onCpu(options).radiance[0], vec3(3.0f));
    options.camera = 1;
    EXPECT_EQ(Stage(scene).onCpu(options).radiance[0], vec3(0.0f));
}

// ---- Every device, and the reference -----------------------------------------------------------------------------------

TEST(SpheresPicture, EqualsTheReferenceOutsideTies) {
    const Stage stage(variedScene());
    const reference::World world(stage.scene, stage.geometry);
    for (const uint32_t camera : {0u, 1u}) {
        FrameOptions options = square(48, 1);
        options.camera = camera;
        const Picture picture = stage.onCpu(options);
        reference::PictureOptions same;
        same.width = same.height = 48;
        same.camera = camera;
        same.bounds.minContribution = 0.0;
        const reference::Picture expected = reference::render(world, same);
        Image image(48, 48);
        image.pixels = picture.radiance;
        const PictureComparison got = compareToReference(image, expected);
        EXPECT_LT(got.outsideTies.rmse, 1e-3) << "camera " << camera;
        EXPECT_EQ(got.outsideTies.nan, 0u);
        EXPECT_LT(got.ties, 48u * 48u / 4);
        EXPECT_FALSE(got.blank);
    }
}

class SpheresOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, SpheresOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(SpheresOnDevice, LookAsOnTheCpuToTheBit) {
    const Stage stage(variedScene());
    Device device(info);
    const auto tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    for (const uint32_t camera : {0u, 1u}) {
        FrameOptions options = square(45, 2);
        options.camera = camera;
        EXPECT_EQ(bitsOf(frame.render(options)), bitsOf(stage.onCpu(options))) << "camera " << camera;
    }
}

// The asset with two true spheres: no ray missed, phantom or wrong.
TEST_P(SpheresOnDevice, AreHitAsTheReferenceHitsThem) {
    Scene scene = importScene(std::filesystem::path(RAIG_SOURCE_DIR) / "assets/cornell_spheres.gltf");
    const Stage stage(scene);
    ASSERT_EQ(stage.geometry.spheres.size(), 2u);
    const reference::World world(stage.scene, stage.geometry);
    std::vector<Ray> rays = aimedRays(stage.geometry, stage.scene.cameras[0].eye, 4000);
    const std::vector<Ray> first = rays;
    for (int bounce = 0; bounce < 2; ++bounce) {
        const std::vector<Ray> more = bounceRays(world.tree, bounce == 0 ? first : rays);
        rays.insert(rays.end(), more.begin(), more.end());
    }
    Device device(info);
    std::vector<Hit> hits(rays.size());
    makeDeviceTracer(device, stage.structure)->trace(rays, hits, Query::closest);
    const HitComparison got = compareHits(world.tree, rays, hits);
    EXPECT_EQ(got.faultCount(), 0u);
    EXPECT_GT(got.met, rays.size() / 2);
    EXPECT_LT(got.offset.max, 1.0);
}

}  // namespace
}  // namespace raig
