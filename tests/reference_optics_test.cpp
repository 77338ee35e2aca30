// The double-precision reference's optics, and the recursion along them, against closed forms.
#include "reference/optics.hpp"
#include "support/reference_scenes.hpp"

#include <gtest/gtest.h>

namespace raig::reference {
namespace {

using namespace test;

// ---- Optics ------------------------------------------------------------------------------------------------------------

TEST(ReferenceOptics, FresnelMatchesItsSpecialAngles) {
    const double n = 1.5;
    EXPECT_NEAR(fresnel(1.0, 1.0, n), 0.04, 1e-15);
    EXPECT_NEAR(fresnel(0.0, 1.0, n), 1.0, 1e-15);
    // At Brewster's angle, tan = n, light polarised in the plane of incidence is not reflected at all.
    const double senkrecht = (1.0 - n * n) / (1.0 + n * n);
    EXPECT_NEAR(fresnel(std::cos(std::atan(n)), 1.0, n), 0.5 * senkrecht * senkrecht, 1e-15);
    for (const double cosI : {0.1, 0.35, 0.8, 0.99}) {
        const double cosT = std::sqrt(1.0 - (1.0 - cosI * cosI) / (n * n));
        EXPECT_NEAR(fresnel(cosI, 1.0, n), fresnel(cosT, n, 1.0), 1e-14) << "the same from both sides";
        EXPECT_EQ(fresnel(cosI, 1.3, 1.3), 0.0);
    }
    const double critical = std::sqrt(1.0 - 1.0 / (n * n));
    EXPECT_EQ(fresnel(critical * 0.999, n, 1.0), 1.0);
    EXPECT_LT(fresnel(critical * 1.001, n, 1.0), 1.0);
    EXPECT_FALSE(refract(dvec3(std::sqrt(0.75), 0.0, -0.5), dvec3(0, 0, 1), n));
}

// A slab of glass over a floor whose colour tells where it is met: the ray leaves parallel, moved by Snell's law.
TEST(ReferenceOptics, SlabsShiftRaysBySnellsLaw) {
    for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
        Builder builder;
        const uint32_t glass = builder.material(clear(1.5f)), floor = builder.material(white());
        builder.quad(vec3(-9, 2, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
        builder.quad(vec3(-9, 1, -9), vec3(18, 0, 0), vec3(0, 0, 18), glass);
        builder.quad(vec3(-8, 0, 8), vec3(16, 0, 0), vec3(0, 0, -16), floor);
        for (const vec3& p : builder.scene.meshes[0].positions) builder.scene.meshes[0].colors.emplace_back((p.x + 9) / 18);
        builder.scene.ambient = vec3(1.0f);
        const Made made(builder.scene);
        const double angle = degrees * pi / 180.0, inside = std::asin(std::sin(angle) / 1.5);
        const double through = 1.0 - fresnel(std::cos(angle), 1.0, 1.5);
        const double x = -5.0 + 2.0 * std::tan(angle) + std::tan(inside);  // 1 above, 1 inside, 1 below
        const Ray ray{dvec3(-5, 3, 0.3), dvec3(std::sin(angle), -std::cos(angle), 0.0)};
        // The glass is tinted by the vertex colours where the ray enters and leaves.
        const double enter = (-5.0 + std::tan(angle) + 9) / 18, leave = (-5.0 + std::tan(angle) + std::tan(inside) + 9) / 18;
        const double want = through * through * enter * leave * (x + 9) / 18;
        EXPECT_NEAR(traceRay(made.world, ray, bounds(2), {}).value.x, want, 1e-6 * want) << degrees << " degrees";
    }
}

TEST(ReferenceOptics, NothingPassesBeyondTheCriticalAngle) {
    Builder builder;
    const uint32_t glass = builder.material(clear(1.5f)), ceiling = builder.material(lamp(3.0f));
    builder.quad(vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
    builder.quad(vec3(-9, -2, 9), vec3(18, 0, 0), vec3(0, 0, -18), ceiling);
    builder.scene.sky = {vec3(100.0f), vec3(100.0f), vec3(100.0f)};
    const Made made(builder.scene);
    for (const double degrees : {42.0, 60.0, 75.0}) {
        const double angle = degrees * pi / 180.0;
        const Radiance got =
            traceRay(made.world, {dvec3(-8, 0, 0), dvec3(std::sin(angle), std::cos(angle), 0.0)}, bounds(1), {});
        EXPECT_EQ(got.value, dvec3(3.0)) << degrees << " degrees: the emitting floor, mirrored whole";
        EXPECT_EQ(got.discarded, 0.0);
    }
}

TEST(ReferenceOptics, LightFadesByTheLengthInside) {
    Material tinted = clear(1.0f);
    tinted.attenuationColor = vec3(0.5f, 0.25f, 0.9f);
    tinted.attenuationDistance = 2.0f;
    Builder builder;
    const uint32_t glass = builder.material(tinted);
    builder.quad(vec3(-9, 3, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
    builder.quad(vec3(-9, 0, -9), vec3(18, 0, 0), vec3(0, 0, 18), glass);
    builder.scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Made made(builder.scene);
    for (const double degrees : {0.0, 30.0, 60.0}) {
        const double angle = degrees * pi / 180.0, length = 3.0 / std::cos(angle);
        const dvec3 got =
            traceRay(made.world, {dvec3(-2, 5, 0.1), dvec3(std::sin(angle), -std::cos(angle), 0.0)}, bounds(2), {}).value;
        const dvec3 want = glm::pow(dvec3(tinted.attenuationColor), dvec3(length / 2.0));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], 1e-6) << degrees << " degrees";
    }
}

// ---- The recursion -----------------------------------------------------------------------------------------------------

// Radiance e + K e + K^2 e + ... between two mirrors that glow; what the depth cuts off is bounded by the discarded weight.
TEST(ReferenceRecursion, FacingMirrorsSumTheGeometricSeries) {
    for (const float k : {0.5f, 0.9f, 0.98f}) {
        Material mirror = lamp(1.0f);
        mirror.baseColor = vec3(k);
        mirror.metallic = 1.0f;
        mirror.roughness = 0.0f;
        Builder builder;
        builder.material(mirror);
        builder.quad(vec3(-9, -9, -1), vec3(18, 0, 0), vec3(0, 18, 0));
        builder.quad(vec3(-9, -9, 1), vec3(0, 18, 0), vec3(18, 0, 0));
        const Made made(builder.scene);
        for (const uint32_t depth : {0u, 1u, 3u, 8u, 30u}) {
            const Radiance got = traceRay(made.world, {dvec3(0.1, 0.2, 0), dvec3(0, 0, -1)}, bounds(depth), {});
            const double left = std::pow(double{k}, depth + 1.0);
            EXPECT_NEAR(got.value.x, (1.0 - left) / (1.0 - k), 1e-12) << k << " to depth " << depth;
            EXPECT_NEAR(got.discarded, left, 1e-13);
            EXPECT_NEAR(1.0 / (1.0 - k) - got.value.x, got.discarded * (1.0 / (1.0 - k)), 1e-11)
                << "the bound is met exactly";
        }
        const Radiance cut = traceRay(made.world, {dvec3(0.1, 0.2, 0), dvec3(0, 0, -1)}, bounds(1000, 0.1f), {});
        EXPECT_LT(cut.discarded, 0.1);
        EXPECT_GE(cut.discarded, 0.1 * k);
    }
}

TEST(ReferenceRecursion, WhatIsNotThereShowsTheSky) {
    Scene scene;
    scene.sky = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    const Made made(scene);
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0, 1, 0)}, bounds(8), {}).value, dvec3(1, 0, 0));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(1, 0, 0)}, bounds(8), {}).value, dvec3(0, 1, 0));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0, -1, 0)}, bounds(8), {}).value, dvec3(0, 0, 1));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0.8, 0.6, 0)}, bounds(8), {}).value, dvec3(0.6, 0.4, 0));
}

TEST(ReferenceRecursion, AWhiteSceneInWhiteLightIsWhite) {
    Builder builder;
    builder.material(white());
    builder.quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0));
    builder.scene.ambient = vec3(1.0f);
    const Made made(builder.scene);
    EXPECT_EQ(traceRay(made.world, rayTo(dvec3(0.3, 2, 3), dvec3(0.1, 0.1, 0)), bounds(8), {}).value, dvec3(1.0));
    // Glass in a white environment loses nothing but what is cut off, and that is told.
    Builder glass;
    glass.material(clear(1.5f));
    glass.scene = closedSphere(16, 1.0f, vec3(0.0f));
    glass.scene.materials = {clear(1.5f)};
    glass.scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Made ball(glass.scene);
    for (const dvec3& target : {dvec3(0.0), dvec3(0.3, 0.1, 0), dvec3(0.9, 0.2, 0.1)}) {
        const Radiance got = traceRay(ball.world, rayTo(dvec3(0.2, 0.5, 5), target), bounds(8), {});
        EXPECT_NEAR(got.value.x + got.discarded, 1.0, 1e-12);
        EXPECT_LT(got.discarded, 0.1);
    }
}

}  // namespace
}  // namespace raig::reference
