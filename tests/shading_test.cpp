// Shading against closed forms, and the parts of it one by one: sampling numbers, Fresnel, spawned rays, textures, lights.
#include "rays/frame_kernels.hpp"
#include "support/random.hpp"
#include "support/rendering.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace raig {
namespace {

using namespace test;
using shared::FrameKernels;

/// Code shared with devices, called by name.
FrameKernels& code() {
    static FrameKernels kernels;
    return kernels;
}

Material material(float metallic, float roughness, float transmission, float ior, bool thin, const vec3& color = vec3(1.0f)) {
    Material m;
    m.baseColor = color;
    m.metallic = metallic;
    m.roughness = roughness;
    m.transmission = transmission;
    m.ior = ior;
    m.thin = thin;
    return m;
}

// ---- Sampling numbers --------------------------------------------------------------------------------------------------

TEST(Sampling, SecondDimensionIsSobols) {
    Random random(3);
    for (int n = 0; n < 10'000; ++n) {
        const auto i = n < 1000 ? static_cast<uint32_t>(n) : static_cast<uint32_t>(random.bits());
        uint32_t want = 0;
        for (uint32_t v = 0x80000000u, rest = i; rest != 0; rest >>= 1, v ^= v >> 1)
            if (rest & 1) want ^= v;
        ASSERT_EQ(code().sobol1(i), want) << i;
    }
}

TEST(Sampling, PermutesBits) {
    std::set<uint32_t> hashes, scrambled;
    for (uint32_t i = 0; i < 4096; ++i) {
        hashes.insert(code().hash(i));
        scrambled.insert(code().scramble(i, 12345));
    }
    EXPECT_EQ(hashes.size(), 4096u);
    EXPECT_EQ(scrambled.size(), 4096u);
}

// Every elementary interval of area 1/64 holds one of the first 64 samples, in every pixel and dimension.
TEST(Sampling, StratifiesEveryElementaryInterval) {
    for (const uint32_t pixel : {0u, 1u, 511u, 262143u})
        for (const uint32_t dimension : {0u, 1u, 5u, 4000000000u})
            for (uint32_t wide = 1; wide <= 64; wide *= 2) {
                std::set<uint32_t> cells;
                for (uint32_t s = 0; s < 64; ++s) {
                    const vec2 p = code().sampleSquare(pixel, s, dimension, 7);
                    ASSERT_TRUE(p.x >= 0.0f && p.x < 1.0f && p.y >= 0.0f && p.y < 1.0f);
                    cells.insert(static_cast<uint32_t>(p.x * float(wide)) * 64 + static_cast<uint32_t>(p.y * float(64 / wide)));
                }
                EXPECT_EQ(cells.size(), 64u) << pixel << ' ' << dimension << ' ' << wide;
            }
}

// ---- Surfaces ----------------------------------------------------------------------------------------------------------

TEST(Fresnel, IsThatOfTheEquationsAtEveryAngle) {
    for (const auto& [n1, n2] : {std::pair(1.0, 1.5), std::pair(1.5, 1.0), std::pair(1.0, 1.33), std::pair(2.4, 1.0)})
        for (double degrees = 0.0; degrees < 90.0; degrees += 0.25) {
            const double cosI = std::cos(degrees * M_PI / 180.0), sinT = n1 / n2 * std::sqrt(1.0 - cosI * cosI);
            if (std::abs(sinT - 1.0) < 1e-3) continue;  // at the critical angle a rounding decides
            const double cosT = std::sqrt(std::max(0.0, 1.0 - sinT * sinT));
            const double s = (n1 * cosI - n2 * cosT) / (n1 * cosI + n2 * cosT);
            const double p = (n2 * cosI - n1 * cosT) / (n2 * cosI + n1 * cosT);
            const double want = sinT > 1.0 ? 1.0 : 0.5 * (s * s + p * p);
            EXPECT_NEAR(code().fresnelReflectance(float(cosI), float(n1), float(n2)), want, 2e-5) << n1 << ' ' << degrees;
        }
}

TEST(Refraction, FollowsSnellAndIsTotallyReflectedBeyondTheCriticalAngle) {
    const vec3 n(0, 1, 0);
    for (double degrees = 0.0; degrees < 89.0; degrees += 0.5) {
        const double angle = degrees * M_PI / 180.0;
        const vec3 d(float(std::sin(angle)), float(-std::cos(angle)), 0.0f);
        const vec3 in = code().bent(d, n, 1.0f / 1.5f);
        EXPECT_NEAR(in.x, std::sin(angle) / 1.5, 1e-6);
        EXPECT_LT(in.y, 0.0f);
        const vec3 out = code().bent(d, n, 1.5f);
        const double sine = 1.5 * std::sin(angle);
        if (std::abs(sine - 1.0) < 1e-3) continue;  // at the critical angle a rounding decides
        EXPECT_NEAR(out.x, sine > 1.0 ? 0.0 : sine, 2e-6) << degrees;
        EXPECT_EQ(out == vec3(0.0f), sine > 1.0) << degrees;
    }
}

TEST(Decay, IsTheExponentialWithinTwoUlp) {
    double worst = 0.0;
    for (float x = 0.0f; x < 87.0f; x += 0.00123f) {
        const double want = std::exp(-double{x});
        worst = std::max(worst, std::abs(code().decay(x) / want - 1.0));
    }
    EXPECT_LT(worst, 2 * 1.2e-7);
    EXPECT_EQ(code().decay(0.0f), 1.0f);
    EXPECT_EQ(code().decay(1e30f), 0.0f);
}

TEST(FaceNormal, IsRightAtEverySize) {
    Random random(5);
    for (const double size : {1e-18, 1e-6, 1.0, 1e6, 1e18})
        for (int i = 0; i < 200; ++i) {
            const vec3 a = random.inCube(-size, size), b = random.inCube(-size, size), c = random.inCube(-size, size);
            const dvec3 cross = glm::cross((dvec3(b) - dvec3(a)) / size, (dvec3(c) - dvec3(a)) / size);
            if (glm::length(cross) < 0.05) continue;
            const vec3 n = code().faceNormal(a, b, c, vec3(0.0f));
            EXPECT_LT(glm::length(dvec3(n) - glm::normalize(cross)), 2e-5) << size;
        }
}

// ---- Spawned rays ------------------------------------------------------------------------------------------------------

/// Rays that leave points of `triangles` to the side of each one's normal, at all angles down to 1e-4 above the surface.
std::vector<Ray> spawn(const std::vector<Triangle>& triangles, size_t count, uint64_t seed) {
    Random random(seed);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
        const double r = std::sqrt(random.unit()), s = random.unit();
        const auto point = code().pointOf(t.a, t.b, t.c, float(r * (1 - s)), float(r * s));
        const vec3 n = code().faceNormal(t.a, t.b, t.c, vec3(0.0f));
        dvec3 d = random.direction();
        d -= glm::dot(d, dvec3(n)) * (rays.size() % 2 ? 1.0 - std::pow(10.0, -4.0 * random.unit()) : 0.0) * dvec3(n);
        if (glm::dot(d, dvec3(n)) < 0.0) d = -d;
        const vec3 direction(glm::normalize(d));
        if (!(glm::dot(direction, n) > 0.0f)) continue;
        rays.push_back({code().spawnOrigin(point, n), 0.0f, direction, shared::FAR_AWAY});
    }
    return rays;
}

size_t countHits(const std::vector<Triangle>& triangles, const std::vector<Ray>& rays) {
    const Structure structure = structureType("bvh").build(triangles, {});
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::any);
    return static_cast<size_t>(std::ranges::count_if(hits, [](const Hit& hit) { return hit.primitive != NO_HIT; }));
}

const dvec3 places[] = {{0, 0, 0}, {1e4, -1e4, 1e4}, {-1e6, 1e6, 1e6}};

/// The outside of a convex body: nothing that leaves it can meet it again.
TEST(SpawnedRays, NeverMeetTheConvexBodyTheyLeave) {
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places) {
            // At sizes below the spacing of floats there, bodies are dents and points: not convex any more.
            if (size < glm::length(place) * 1e-4) continue;
            const std::vector<Triangle> sphere = test::sphere(12, size, place);
            EXPECT_EQ(countHits(sphere, spawn(sphere, 20'000, 11)), 0u) << "size " << size << " at " << place.x;
        }
}

/// Single triangles of any shape, slivers and those in planes of coordinates among them: a plane is never met again.
TEST(SpawnedRays, NeverMeetTheTriangleTheyLeave) {
    Random random(9);
    size_t met = 0, rays = 0;
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places)
            for (int i = 0; i < 60; ++i) {
                vec3 p[3];
                for (vec3& corner : p) corner = vec3(place + size * dvec3(random.inCube(-1, 1)));
                if (i % 3 == 1) p[0][i % 2] = p[1][i % 2] = p[2][i % 2] = float(place[i % 2]);
                if (i % 3 == 2) p[2] = vec3(glm::mix(dvec3(p[0]), dvec3(p[1]), 0.4)) + 0.01f * (p[2] - vec3(place));
                const std::vector<Triangle> one = {{p[0], p[1], p[2]}};
                const double longest = std::max(glm::length(dvec3(p[1]) - dvec3(p[0])), glm::length(dvec3(p[2]) - dvec3(p[0])));
                const double area = glm::length(glm::cross(dvec3(p[1]) - dvec3(p[0]), dvec3(p[2]) - dvec3(p[0])));
                if (!one[0].usable() || area < 1e-3 * longest * longest) continue;
                met += countHits(one, spawn(one, 100, random.bits()));
                rays += 100;
            }
    EXPECT_GT(rays, 50'000u);
    EXPECT_EQ(met, 0u);
}

/// Rays start nearer to the triangle's plane than 8 ULP of the body's largest coordinates.
TEST(SpawnedRays, NeverJumpAGapOfEightUlp) {
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places) {
            if (size < glm::length(place) * 1e-4) continue;
            const std::vector<Triangle> body = test::sphere(12, size, place);
            const float reach = float(glm::length(place) + size);
            const float gap = 8.0f * (std::nextafter(reach, INFINITY) - reach);
            Random random(21);
            size_t leaks = 0;
            for (int i = 0; i < 300; ++i) {
                const Triangle& t = body[random.below(static_cast<uint32_t>(body.size()))];
                const vec3 n = code().faceNormal(t.a, t.b, t.c, vec3(0.0f));
                const auto point = code().pointOf(t.a, t.b, t.c, 0.3f, 0.5f);
                const double height = glm::dot(dvec3(code().spawnOrigin(point, n)) - dvec3(t.a), dvec3(n));
                leaks += height > gap;
            }
            EXPECT_EQ(leaks, 0u) << "size " << size << " at " << place.x;
        }
}

// ---- Whole pictures against closed forms -------------------------------------------------------------------------------

// Where all light has radiance 1, everything that keeps energy looks like 1: what is missing is what was discarded.
TEST(Furnace, GivesOneWithWhatWasDiscarded) {
    const std::vector<Material> materials = {material(0, 1, 0, 1.5f, true),       material(1, 0, 0, 1.5f, true),
                                             material(0, 0, 0, 1.5f, true),       material(0, 0, 1, 1.5f, false),
                                             material(0, 0.1f, 1, 1.33f, true),   material(0, 0, 0.5f, 1.5f, false),
                                             material(0, 0.2f, 0, 1.5f, true), material(0, 0, 1, 1.0f, false)};
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
            EXPECT_NEAR(picture.radiance[0].x, 0.25 * (1.0 - rest) / (1.0 - reflectance), 2e-5) << reflectance << ' ' << depth;
            EXPECT_NEAR(picture.discarded[0], rest, 1e-5) << reflectance << ' ' << depth;
            EXPECT_EQ(picture.statistics.deepest, depth);
        }
}

/// A matte floor at y = 0 seen from above, one pixel around the origin.
Scene floorFromAbove(const Material& m = material(0, 1, 0, 1.5f, true, vec3(0.5f))) {
    Scene scene;
    addQuad(scene, {-4, 0, 4}, {8, 0, 0}, {0, 0, -8}, m);
    Camera camera;
    camera.eye = {0.0f, 3.0f, 0.0f};
    camera.forward = {0, -1, 0};
    camera.right = {1, 0, 0};
    camera.up = {0, 0, -1};
    camera.yfov = 1e-4f;
    scene.cameras.push_back(camera);
    return scene;
}

float onePixel(const Scene& scene, uint32_t samples = 1) { return Stage(scene).onCpu(square(1, samples)).radiance[0].x; }

TEST(Lights, FallOffByDistanceAngleRangeAndCone) {
    Scene scene = floorFromAbove();
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
    scene.lights[0] = {.type = Light::Type::spot, .position = at,
                       .direction = vec3(float(std::cos(towards)), float(std::sin(towards)), 0.0f), .intensity = vec3(7.0f),
                       .innerConeAngle = 0.2f, .outerConeAngle = 0.7f};
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
        Scene scene = floorFromAbove();
        scene.lights = {{.type = Light::Type::point, .position = {2, 2, 0}, .intensity = vec3(7.0f)}};
        const float lit = onePixel(scene);
        addQuad(scene, {0.5f, 1, 1}, {1, 0, 0}, {0, 0, -2}, material(0, 0, opaque ? 0.0f : 1.0f, 1.5f, true));
        EXPECT_EQ(onePixel(scene), opaque ? 0.0f : lit);
    }
}

// Irradiance below a rectangular emitter has a closed form [Howell, configuration factor B-4]; the mean of many samples is
// within 4 standard errors of it.
TEST(Emitters, LightTheFloorBelowAsTheConfigurationFactorSays) {
    Scene scene = floorFromAbove();
    addQuad(scene, {0.0f, 1.0f, 0.0f}, {1.0f, 0, 0}, {0, 0, -0.5f}, glowing(vec3(3.0f)));
    scene.cameras[0].eye.y = 0.5f;  // below the lamp
    const double x = 1.0, y = 0.5;
    const double factor = (x / std::sqrt(1 + x * x) * std::atan(y / std::sqrt(1 + x * x)) +
                           y / std::sqrt(1 + y * y) * std::atan(x / std::sqrt(1 + y * y))) / (2.0 * M_PI);
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
