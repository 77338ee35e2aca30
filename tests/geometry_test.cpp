/// The scene's triangles in the world: what instancing, mirroring, scaling and bad numbers do to them.
#include "scene/geometry.hpp"

#include "base/error.hpp"

#include <gtest/gtest.h>

#include <bit>
#include <cstring>
#include <limits>
#include <random>

namespace raig {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();
constexpr float infinity = std::numeric_limits<float>::infinity();

dmat4 scaling(const dvec3& s) {
    return dmat4(dvec4(s.x, 0, 0, 0), dvec4(0, s.y, 0, 0), dvec4(0, 0, s.z, 0), dvec4(0, 0, 0, 1));
}

dmat4 translation(const dvec3& by) {
    dmat4 m(1.0);
    m[3] = dvec4(by, 1.0);
    return m;
}

/// A matrix of random entries, and so of either orientation.
dmat4 randomAffine(std::mt19937& random) {
    std::uniform_real_distribution<double> entry(-2.0, 2.0);
    dmat4 m(1.0);
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 3; ++row) m[column][row] = entry(random);
    return m;
}

/// One triangle with its face's normal at every corner.
Mesh triangle(const vec3& a, const vec3& b, const vec3& c) {
    Mesh mesh;
    mesh.positions = {a, b, c};
    const vec3 n = glm::cross(b - a, c - a);
    mesh.normals.assign(3, n / glm::length(n));
    mesh.triangles = {{0, 1, 2}};
    mesh.materials = {0};
    return mesh;
}

Scene sceneOf(std::vector<Mesh> meshes, const std::vector<Instance>& instances) {
    Scene scene;
    scene.meshes = std::move(meshes);
    scene.instances = instances;
    scene.materials.resize(2);
    return scene;
}

/// The normal of a triangle by the order of its corners.
dvec3 faceNormal(const Geometry& g, size_t index) {
    const uvec3 t = g.triangles[index];
    const dvec3 a = g.positions[t.x], b = g.positions[t.y], c = g.positions[t.z];
    return glm::normalize(glm::cross(b - a, c - a));
}

TEST(Geometry, NormalsAndFrontsAgreeUnderAnyTransform) {
    std::mt19937 random(3);
    const Mesh mesh = triangle({0.1f, 0.2f, 0.3f}, {1, 0, 0.5f}, {0.25f, 1, -0.5f});
    int mirrored = 0;
    for (int round = 0; round < 1000; ++round) {
        const dmat4 toWorld = randomAffine(random);
        if (std::abs(glm::determinant(glm::dmat3(toWorld))) < 0.05) continue;
        const Geometry g = flatten(sceneOf({mesh}, {{0, toWorld}}));
        mirrored += glm::determinant(glm::dmat3(toWorld)) < 0.0;
        for (int i = 0; i < 3; ++i) {
            EXPECT_NEAR(glm::length(dvec3(g.normals[i])), 1.0, 1e-6);
            EXPECT_GT(glm::dot(dvec3(g.normals[i]), faceNormal(g, 0)), 1.0 - 1e-4) << "round " << round;
        }
        ASSERT_FALSE(HasFailure());
    }
    EXPECT_GT(mirrored, 300);
}

// What is inside a closed mesh stays inside when the mesh is mirrored: else glass would bend light the wrong way.
TEST(Geometry, MirroredInstancesKeepTheirFrontsOutside) {
    const Mesh mesh = triangle({1, 0, 0}, {0, 1, 0}, {0, 0, 1});  // faces away from the origin
    for (const double side : {1.0, -1.0}) {
        const Geometry g = flatten(sceneOf({mesh}, {{0, scaling({side, 1, 1})}}));
        EXPECT_GT(glm::dot(faceNormal(g, 0), dvec3(g.positions[0])), 0.0);
        EXPECT_EQ(g.triangles[0].x, 0u) << "the first corner stays the first";
    }
}

TEST(Geometry, NormalsAreUnitAtExtremeScales) {
    const Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 1});
    for (const double scale : {1e-30, 1e-10, 1e10, 1e17}) {
        const Geometry g = flatten(sceneOf({mesh}, {{0, scaling({scale, -scale, 2 * scale})}}));
        EXPECT_NEAR(glm::length(dvec3(g.normals[0])), 1.0, 1e-6) << scale;
        EXPECT_EQ(g.dropped.zeroArea + g.dropped.nonFinite, 0u) << scale;
    }
}

TEST(Geometry, SingularTransformsDropTheirTrianglesAndNothingElse) {
    const Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 1});
    const Geometry g = flatten(sceneOf({mesh}, {{0, scaling({0, 0, 0})}, {0, dmat4(1.0)}, {0, scaling({1, 0, 0})}}));
    EXPECT_EQ(g.triangles.size(), 3u);
    EXPECT_EQ(g.dropped.zeroArea, 2u);
    EXPECT_EQ(g.bounds.lo, vec3(0));
    EXPECT_EQ(g.bounds.hi, vec3(1));
    for (const vec3& n : g.normals) EXPECT_TRUE(n == vec3(0) || std::abs(glm::length(n) - 1.0f) < 1e-6f);
}

// Flattened onto a plane, a triangle keeps an area, and its normal is the plane's.
TEST(Geometry, ProjectionsOntoAPlaneHaveThePlanesNormal) {
    const Geometry g = flatten(sceneOf({triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 1})}, {{0, scaling({1, 1, 0})}}));
    EXPECT_EQ(g.dropped.zeroArea, 0u);
    EXPECT_NEAR(std::abs(g.normals[0].z), 1.0f, 1e-6f);
}

TEST(Geometry, WhatIsNoNumberIsDroppedAndCountedApart) {
    Mesh mesh;
    mesh.positions = {{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {nan, 0, 0}, {0, infinity, 0}, {0, 0, 2e18f}, {2, 0, 0}};
    mesh.triangles = {{0, 1, 2}, {0, 1, 3}, {4, 1, 2}, {0, 5, 1}, {0, 1, 6}, {1, 1, 2}, {3, 3, 3}};
    mesh.materials.assign(7, 0);
    Scene scene = sceneOf({mesh}, {{0, dmat4(1.0)}});
    scene.otherPrimitives = 5;
    const Geometry g = flatten(scene);
    EXPECT_EQ(g.triangles.size(), 7u) << "they keep their ids";
    EXPECT_EQ(g.dropped.nonFinite, 4u);
    EXPECT_EQ(g.dropped.zeroArea, 2u);
    EXPECT_EQ(g.dropped.other, 5u);
    EXPECT_EQ(g.bounds.hi, vec3(1, 1, 0)) << "only what rays can meet counts";
}

TEST(Geometry, CollinearCornersAreUnusableHoweverTheyLie) {
    std::mt19937 random(5);
    std::uniform_int_distribution<int> whole(-1000, 1000);
    for (int round = 0; round < 10'000; ++round) {
        const vec3 a(whole(random), whole(random), whole(random));
        const vec3 step(whole(random) / 64.0f, whole(random) / 64.0f, whole(random) / 64.0f);
        const float i = static_cast<float>(whole(random)), j = static_cast<float>(whole(random));
        // Exact in float: every term is a multiple of 1/64 below 2^24 / 64.
        EXPECT_FALSE(isUsable(a, a + 0.25f * i * step, a + 0.25f * j * step) && (i == 0 || j == 0 || i == j));
    }
    EXPECT_FALSE(isUsable({0, 0, 0}, {1, 2, 3}, {2, 4, 6}));
    EXPECT_FALSE(isUsable({1e6f, 1e6f, 1e6f}, {1e6f + 1, 1e6f + 1, 1e6f + 1}, {1e6f - 2, 1e6f - 2, 1e6f - 2}));
}

TEST(Geometry, ThinTrianglesOfAnySizeAreUsable) {
    for (const float scale : {1e-30f, 1e-6f, 1.0f, 1e6f, 1e17f}) {
        EXPECT_TRUE(isUsable({0, 0, 0}, {scale, 0, 0}, {0.5f * scale, 1e-6f * scale, 0})) << scale;
        EXPECT_TRUE(
            isUsable(vec3(scale), vec3(scale) + vec3(scale, 0, 0), vec3(scale, std::nextafter(scale, infinity), scale)))
            << scale;
    }
    EXPECT_TRUE(isUsable({0, 0, 0}, {1e-45f, 0, 0}, {0, 1e-45f, 0})) << "of the smallest numbers there are";
    EXPECT_TRUE(isUsable({-1.8e18f, 0, 0}, {1.8e18f, 0, 0}, {0, 1.8e18f, 0}));
}

TEST(Geometry, IdsCountInstancesThenTriangles) {
    Mesh two = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    two.triangles.push_back({2, 1, 0});
    two.materials.push_back(1);
    const Mesh none;
    const Geometry g = flatten(sceneOf(
        {two, none}, {{1, dmat4(1.0)}, {0, dmat4(1.0)}, {1, dmat4(1.0)}, {0, translation({5, 0, 0})}, {1, dmat4(1.0)}}));
    ASSERT_EQ(g.triangles.size(), 4u);
    EXPECT_EQ(g.firstTriangle, (std::vector<uint32_t>{0, 0, 2, 2, 4, 4}));
    EXPECT_EQ(g.materials, (std::vector<uint32_t>{0, 1, 0, 1}));
    for (uint32_t i = 0; i < 4; ++i) {
        EXPECT_EQ(g.place(i).instance, i < 2 ? 1u : 3u);
        EXPECT_EQ(g.place(i).primitive, i % 2);
    }
    EXPECT_EQ(g.positions[g.triangles[2].x], vec3(5, 0, 0));
}

// Rotations that floats rounded scale evenly enough; what is squeezed or sheared by more does not.
TEST(Geometry, SpheresArePlacedByTheirTransform) {
    std::mt19937 random(8);
    std::uniform_real_distribution<double> entry(-1.0, 1.0);
    for (int i = 0; i < 1000; ++i) {
        dvec4 q(entry(random), entry(random), entry(random), entry(random));
        q = dvec4(vec4(q / glm::length(q)));  // in float
        const glm::dmat3 rotation(
            dvec3(1 - 2 * (q.y * q.y + q.z * q.z), 2 * (q.x * q.y + q.w * q.z), 2 * (q.x * q.z - q.w * q.y)),
            dvec3(2 * (q.x * q.y - q.w * q.z), 1 - 2 * (q.x * q.x + q.z * q.z), 2 * (q.y * q.z + q.w * q.x)),
            dvec3(2 * (q.x * q.z + q.w * q.y), 2 * (q.y * q.z - q.w * q.x), 1 - 2 * (q.x * q.x + q.y * q.y)));
        const double scale = std::pow(10.0, 8.0 * entry(random)) * (i % 2 == 0 ? 1.0 : -1.0);
        dmat4 m(rotation);
        for (int column = 0; column < 3; ++column) m[column] *= scale;
        m[3] = dvec4(1, 2, 3, 1);
        ASSERT_TRUE(uniformScale(m)) << i;
        const Sphere placed = placeSphere(m, {vec3(0.0f), 0.75f});
        EXPECT_EQ(placed.centre, vec3(1, 2, 3));
        EXPECT_NEAR(placed.radius / std::abs(scale), 0.75, 1e-6);
        EXPECT_FALSE(uniformScale(m * scaling({1.0, 1.0001, 1.0})));
        dmat4 shear(1.0);
        shear[1].x = 1e-4;
        EXPECT_FALSE(uniformScale(m * shear));
    }
    EXPECT_EQ(uniformScale(dmat4(0.0)), 0.0);
    EXPECT_FALSE(uniformScale(scaling({1, 1, 0})));
    EXPECT_FALSE(uniformScale(scaling({nan, 1, 1})));
}

TEST(Geometry, SpheresThatCannotBeHitAreDroppedAndCounted) {
    Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.spheres = {{vec3(1, 2, 3), 0.5f}, {vec3(0), 0.0f},     {vec3(0), -1.0f},
                    {vec3(nan), 1.0f},     {vec3(0), infinity}, {vec3(1.8e18f), 1e17f}};
    mesh.materials.assign(7, 0);
    const Geometry g = flatten(sceneOf({mesh}, {{0, dmat4(1.0)}, {0, dmat4(scaling(dvec3(0.0)))}}));
    EXPECT_EQ(g.triangles.size(), 14u);
    EXPECT_EQ(g.spheres.size(), 12u);
    EXPECT_EQ(g.triangleCount(), 2u);
    EXPECT_EQ(g.place(9).primitive, 2u);
    EXPECT_EQ(g.bounds.lo, vec3(0.0f));
    EXPECT_EQ(g.bounds.hi, vec3(1.5f, 2.5f, 3.5f));
    EXPECT_EQ(g.dropped.zeroArea, 2u + 1u + 4u);  // scaled to nothing: the triangle, and all but those that are no numbers
    EXPECT_EQ(g.dropped.nonFinite, 3u + 2u);
}

TEST(Geometry, AttributesThatOneMeshLacksAreNeutralThere) {
    Mesh plain = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), rich = plain;
    plain.normals.clear();
    rich.uvs = {{0, 0}, {1, 0}, {0, 1}};
    rich.colors = {{1, 0, 0}, {0, 1, 0}, {0, 0, 1}};
    const Geometry g = flatten(sceneOf({plain, rich}, {{0, dmat4(1.0)}, {1, dmat4(1.0)}}));
    EXPECT_EQ(g.normals[0], vec3(0));
    EXPECT_EQ(g.uvs[0], vec2(0));
    EXPECT_EQ(g.colors[0], vec3(1));
    EXPECT_EQ(g.colors[4], vec3(0, 1, 0));
    EXPECT_TRUE(flatten(sceneOf({plain}, {{0, dmat4(1.0)}})).uvs.empty());
}

// Of the sum that makes a coordinate, each product is rounded at most four times.
TEST(Geometry, PositionsAreOffByFourRoundingsAtMost) {
    std::mt19937 random(9);
    std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
    for (int round = 0; round < 20'000; ++round) {
        const vec3 p = vec3(coordinate(random), coordinate(random), coordinate(random)) * std::ldexp(1.0f, round % 90 - 45);
        dmat4 toWorld = randomAffine(random);
        toWorld[3] = dvec4(dvec3(toWorld[3]) * std::ldexp(1.0, round % 50 - 20), 1.0);
        const Placement placement = placementOf(toWorld);
        const vec3 got = placePoint(placement, p);
        for (int k = 0; k < 3; ++k) {
            const dvec4 row(k == 0 ? placement.x : k == 1 ? placement.y : placement.z);
            const dvec4 terms = row * dvec4(p, 1.0);
            const double exact = terms.x + terms.y + terms.z + terms.w;
            EXPECT_LE(std::abs(got[k] - exact), 4.01 * 0x1p-24 * glm::dot(glm::abs(terms), dvec4(1.0))) << round;
        }
        ASSERT_FALSE(HasFailure());
    }
}

TEST(Geometry, TheIdentityLeavesPositionsAsTheyAre) {
    std::mt19937 random(10);
    const Placement identity = placementOf(dmat4(1.0));
    for (int round = 0; round < 100'000; ++round) {
        vec3 p;
        for (int k = 0; k < 3; ++k) do p[k] = std::bit_cast<float>(static_cast<uint32_t>(random()));
        while (!std::isfinite(p[k]));
        const vec3 got = placePoint(identity, p);
        ASSERT_EQ(std::memcmp(&got, &p, sizeof p), 0) << p.x << ' ' << p.y << ' ' << p.z;
    }
    dmat4 minus(1.0);
    minus[3] = dvec4(-0.0, -0.0, -0.0, 1.0);
    const vec3 zero = placePoint(placementOf(minus), vec3(-0.0f));
    EXPECT_FALSE(std::signbit(zero.x)) << "no zero is negative, so placing it again changes nothing";
}

TEST(Geometry, NormalsThatHaveNoDirectionAreZero) {
    const float inf = std::numeric_limits<float>::infinity();
    const NormalPlacement flat = normalPlacementOf(scaling({1, 1, 0}));
    EXPECT_EQ(placeNormal(flat, vec3(1, 0, 0)), vec3(0));
    EXPECT_EQ(placeNormal(flat, vec3(0, 0, 1)), vec3(0, 0, 1));
    EXPECT_EQ(placeNormal(flat, vec3(0)), vec3(0));
    EXPECT_EQ(placeNormal(flat, vec3(0, 0, nan)), vec3(0));
    EXPECT_EQ(placeNormal(flat, vec3(0, 0, inf)), vec3(0));
    EXPECT_EQ(placeNormal(normalPlacementOf(scaling({0, 0, 1})), vec3(0, 0, 1)), vec3(0));
}

TEST(Geometry, MoreTrianglesThanCanBeNumberedAreALimit) {
    Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.triangles.assign(1 << 20, {0, 1, 2});
    mesh.materials.assign(1 << 20, 0);
    try {
        flatten(sceneOf({mesh}, std::vector<Instance>(2048)));
        FAIL() << "2^31 triangles were accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::limit);
        EXPECT_NE(std::string(error.what()).find("has 2147483648 triangles and spheres"), std::string::npos) << error.what();
    }
}

TEST(Geometry, MoreVerticesThanCanBeNumberedAreALimitWrittenOutAndKeptCountOnce) {
    Mesh mesh = triangle({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    mesh.normals.clear();
    mesh.positions.resize(1 << 20, vec3(0));
    const Scene scene = sceneOf({mesh}, std::vector<Instance>(4096));
    try {
        flatten(scene);
        FAIL() << "2^32 vertices were accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::limit);
        EXPECT_NE(std::string(error.what()).find("has 4294967296 vertices"), std::string::npos) << error.what();
    }
    EXPECT_EQ(gatherInstances(scene).primitiveCount(), 4096u);
}

TEST(Geometry, AnEmptySceneIsEmpty) {
    const Geometry g = flatten(Scene{});
    EXPECT_TRUE(g.triangles.empty() && g.positions.empty() && g.bounds.empty());
    EXPECT_EQ(g.firstTriangle, std::vector<uint32_t>{0});
}

}  // namespace
}  // namespace raig
