/// What a scene gets that its file lacks: a material, a camera that frames it, and light.
#include "base/error.hpp"
#include "scene/geometry.hpp"
#include "scene/import.hpp"
#include "scene/validate.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <random>

namespace raig {
namespace {

constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Scene triangleScene(const vec3& a, const vec3& b, const vec3& c) {
    Scene scene;
    scene.meshes.resize(1);
    scene.meshes[0].positions = {a, b, c};
    scene.meshes[0].triangles = {{0, 1, 2}};
    scene.meshes[0].materials = {0};
    scene.instances.resize(1);
    scene.materials.resize(1);
    return scene;
}

/// Where a camera sees a point: in [-1, 1] inside the frame of a square picture.
dvec2 frameOf(const Camera& camera, const dvec3& point) {
    const dvec3 p = point - dvec3(camera.eye);
    const double slope = std::tan(static_cast<double>(camera.yfov) / 2.0) * glm::dot(p, dvec3(camera.forward));
    return {glm::dot(p, dvec3(camera.right)) / slope, glm::dot(p, dvec3(camera.up)) / slope};
}

double farthestInFrame(const Camera& camera, const std::vector<vec3>& points) {
    double farthest = 0.0;
    for (const vec3& point : points) {
        EXPECT_GT(glm::dot(dvec3(point) - dvec3(camera.eye), dvec3(camera.forward)), 0.0) << "behind the camera";
        const dvec2 at = frameOf(camera, point);
        farthest = std::max({farthest, std::abs(at.x), std::abs(at.y)});
    }
    return farthest;
}

TEST(ThreeQuarterView, IsTheTightestThatHoldsEveryPointInTheMiddle95Percent) {
    std::mt19937 random(1);
    for (int round = 0; round < 500; ++round) {
        std::uniform_real_distribution<float> coordinate(-1.0f, 1.0f);
        const vec3 shape(1.0f + coordinate(random), 0.01f + std::abs(coordinate(random)),
                         std::exp(2.0f * coordinate(random)));
        std::vector<vec3> points;
        Box box;
        for (int i = 0; i < 20; ++i) {
            points.push_back(shape * vec3(coordinate(random), coordinate(random), coordinate(random)) + 3.0f);
            box.grow(points.back());
        }
        EXPECT_NEAR(farthestInFrame(threeQuarterView(points, box), points), 0.95, 1e-5) << "round " << round;
    }
}

TEST(ThreeQuarterView, LooksFromTheDefinedSide) {
    const Camera camera = threeQuarterView({vec3(1), vec3(3)}, {vec3(1), vec3(3)});
    const dvec3 towardsEye = glm::normalize(dvec3(0.5, 0.35, 1.0));
    EXPECT_EQ(camera.forward, vec3(-towardsEye));
    EXPECT_NEAR(glm::length(glm::normalize(dvec3(camera.eye) - 2.0) - towardsEye), 0.0, 1e-6);
    EXPECT_GT(camera.up.y, 0.9f);
    EXPECT_EQ(camera.right.y, 0.0f);
    EXPECT_NEAR(glm::length(glm::cross(dvec3(camera.right), dvec3(camera.forward)) - dvec3(camera.up)), 0.0, 1e-6);
    EXPECT_FLOAT_EQ(camera.yfov, 0.78539816f);
}

TEST(ThreeQuarterView, LeavesOutWhatLiesOutsideTheFramedBox) {
    const Box box{vec3(-1), vec3(1)};
    const std::vector<vec3> inside{vec3(-1), vec3(1)};
    std::vector<vec3> all = inside;
    all.emplace_back(50.0f, 0.0f, 0.0f);
    EXPECT_EQ(threeQuarterView(all, box).eye, threeQuarterView(inside, box).eye);
}

TEST(ThreeQuarterView, ScalesWithTheSceneAndMovesWithIt) {
    std::vector<vec3> points{{0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f}};
    const Box box{vec3(0), vec3(1, 1, 0.5f)};
    const vec3 eye = threeQuarterView(points, box).eye;
    for (const float scale : {0x1p-90f, 0x1p-20f, 0x1p20f, 0x1p50f}) {
        std::vector<vec3> scaled;
        for (const vec3& p : points) scaled.push_back(scale * p);
        EXPECT_EQ(threeQuarterView(scaled, {box.lo * scale, box.hi * scale}).eye, eye * scale) << scale;
    }
}

TEST(CompleteScene, FramesUsableTrianglesOfAllInstances) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.meshes[0].positions.insert(scene.meshes[0].positions.end(), {{nan, 0, 0}, {1e30f, 0, 0}, {500, 500, 500}});
    scene.meshes[0].triangles.insert(scene.meshes[0].triangles.end(), {{0, 1, 3}, {0, 1, 4}});
    scene.meshes[0].materials.assign(3, 0);
    Instance moved;
    moved.toWorld[3] = dvec4(10, -3, 2, 1);
    Instance flat;
    flat.toWorld = dmat4(0.0);
    flat.toWorld[3] = dvec4(900, 900, 900, 1);
    scene.instances = {Instance{}, moved, flat};
    completeScene(scene);
    ASSERT_EQ(scene.cameras.size(), 1u);
    const std::vector<vec3> seen{{0, 0, 0}, {1, 0, 0}, {0, 1, 0}, {10, -3, 2}, {11, -3, 2}, {10, -2, 2}};
    EXPECT_NEAR(farthestInFrame(scene.cameras[0], seen), 0.95, 1e-5);
    EXPECT_EQ(flatten(scene).bounds.hi, vec3(11, 1, 2));
}

// 2^20 vertices, 2^16 times: gone through one by one they would take minutes. Boxes frame all of it, and here little more.
TEST(CompleteScene, FramesBoxesWhereInstancesShowTooMuch) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0.5f});
    scene.meshes[0].positions.resize(1 << 20, vec3(nan));
    scene.instances.resize(1 << 16);
    for (size_t i = 0; i < scene.instances.size(); ++i)
        scene.instances[i].toWorld[3] = dvec4(static_cast<double>(i % 256), static_cast<double>(i / 256), 0, 1);
    scene.instances[7].toWorld = dmat4(0.0);
    scene.instances[7].toWorld[3] = dvec4(9000, 9000, 9000, 1);  // and so it shows nothing
    completeScene(scene);
    std::vector<vec3> seen;
    for (const Instance& instance : scene.instances)
        if (instance.toWorld[0][0] != 0.0)
            for (int i = 0; i < 3; ++i) seen.push_back(scene.meshes[0].positions[i] + vec3(instance.toWorld[3]));
    EXPECT_LE(farthestInFrame(scene.cameras[0], seen), 0.95 + 1e-5);
    EXPECT_GT(farthestInFrame(scene.cameras[0], seen), 0.94);
}

TEST(CompleteScene, MorePrimitivesThanCanBeTracedAreALimitAtOnce) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.meshes[0].triangles.resize(1 << 16, uvec3(0, 1, 2));
    scene.meshes[0].materials.resize(1 << 16, 0);
    scene.instances.resize(1 << 20);
    try {
        completeScene(scene);
        FAIL() << "2^36 triangles were accepted";
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::limit);
    }
}

TEST(CompleteScene, AHeadlightMakesFacingWhiteExactlyOneBright) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    completeScene(scene);
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.lights[0].type, Light::Type::directional);
    EXPECT_EQ(scene.lights[0].direction, scene.cameras[0].forward);
    EXPECT_FLOAT_EQ(scene.lights[0].intensity.x / 3.14159265f, 1.0f);
    EXPECT_GT(scene.sky.zenith.z, scene.sky.zenith.x);
    EXPECT_FALSE(scene.lights[0].castsShadows);
    EXPECT_GT(scene.ambient.x, 0.05f);
    EXPECT_EQ(scene.remarks.size(), 2u);
    EXPECT_EQ(findFault(scene), std::nullopt);
}

TEST(CompleteScene, KeepsWhatTheFileHas) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.cameras.emplace_back().eye = vec3(7);
    scene.lights.emplace_back().intensity = vec3(9);
    completeScene(scene);
    ASSERT_EQ(scene.cameras.size(), 1u);
    ASSERT_EQ(scene.lights.size(), 1u);
    EXPECT_EQ(scene.cameras[0].eye, vec3(7));
    EXPECT_EQ(scene.lights[0].intensity, vec3(9));
    EXPECT_EQ(scene.sky.horizon, vec3(0));
    EXPECT_LT(scene.ambient.x, 0.05f);
    EXPECT_EQ(scene.remarks.size(), 1u) << "of the ambient light alone";
}

TEST(CompleteScene, AnEmittingTriangleIsALightAnUnusedMaterialIsNone) {
    Scene scene = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0});
    scene.materials.resize(2);
    scene.materials[1].emission = vec3(0, 0, 1);
    Scene lit = scene;
    lit.meshes[0].materials[0] = 1;
    completeScene(lit);
    EXPECT_TRUE(lit.lights.empty());
    EXPECT_LT(lit.ambient.x, 0.05f);
    completeScene(scene);
    EXPECT_EQ(scene.lights.size(), 1u);
    lit.instances.clear();
    completeScene(lit);
    EXPECT_EQ(lit.lights.size(), 1u) << "a mesh that no instance shows lights nothing";
}

/// The unit cube's faces, seen from within; `lacks` is left out.
Scene room(int lacks) {
    Scene scene = triangleScene({}, {}, {});
    Mesh& mesh = scene.meshes[0] = {};
    for (int face = 0; face < 6; ++face) {
        if (face == lacks) continue;
        const int axis = face / 2;
        vec3 corner(0.0f), right(0.0f), up(0.0f);
        corner[axis] = static_cast<float>(face % 2);
        right[(axis + 1) % 3] = up[(axis + 2) % 3] = 1.0f;
        if (face % 2) std::swap(right, up);
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {corner, corner + right, corner + right + up, corner + up});
        mesh.triangles.insert(mesh.triangles.end(), {{first, first + 1, first + 2}, {first, first + 2, first + 3}});
    }
    mesh.materials.assign(mesh.triangles.size(), 0);
    scene.materials[0].emission = vec3(1.0f);
    return scene;
}

TEST(CompleteScene, LooksIntoARoomThroughTheWallThatItLacks) {
    const vec3 into[] = {{1, 0, 0}, {-1, 0, 0}, {}, {}, {0, 0, 1}, {0, 0, -1}};
    for (int lacks = 0; lacks < 6; ++lacks) {
        Scene scene = room(lacks), mirrored = room(lacks), dark = room(lacks);
        mirrored.instances[0].toWorld[0][0] = -1.0;
        dark.materials[0].emission = vec3(0.0f);
        for (Scene* each : {&scene, &mirrored, &dark}) completeScene(*each);
        const vec3 standard = dark.cameras[0].forward;
        const bool isOpenAside = into[lacks] != vec3(0.0f);
        EXPECT_EQ(scene.cameras[0].forward, isOpenAside ? into[lacks] : standard) << lacks;
        EXPECT_EQ(mirrored.cameras[0].forward, isOpenAside ? into[lacks] * vec3(-1, 1, 1) : standard) << lacks;
        EXPECT_NEAR(farthestInFrame(scene.cameras[0], scene.meshes[0].positions), 0.95, 1e-5) << lacks;
    }
    Scene closed = room(-1);
    completeScene(closed);
    EXPECT_EQ(closed.cameras[0].name, "three-quarter view");
}

TEST(CompleteScene, GivesASunTheSkyAndTheFaintLightThatGoWithIt) {
    Scene one = triangleScene({0, 0, 0}, {1, 0, 0}, {0, 1, 0}), two = one;
    for (Scene* scene : {&one, &two}) {
        Light& sun = scene->lights.emplace_back();
        sun.type = Light::Type::directional;
        sun.intensity = vec3(3.14159265f);
    }
    two.lights.push_back(two.lights[0]);
    completeScene(one);
    completeScene(two);
    EXPECT_GT(one.sky.horizon.x, 0.5f);
    EXPECT_FLOAT_EQ(one.ambient.x, 0.03f);
    EXPECT_FLOAT_EQ(two.ambient.x, 0.06f);
    EXPECT_FLOAT_EQ(two.sky.zenith.z, 2.0f * one.sky.zenith.z);
    ASSERT_EQ(one.lights.size(), 2u);
    EXPECT_EQ(one.lights[1].direction, one.cameras[0].forward);
    EXPECT_FLOAT_EQ(one.lights[1].intensity.x, 0.03f * 3.14159265f) << "seen face on, as bright as by the ambient light";
    EXPECT_FALSE(one.lights[1].castsShadows);
    lightByEnvironment(one, {});
    EXPECT_EQ(one.lights.size(), 1u) << "the sun is the file's own";
}

TEST(CompleteScene, SceneWithNothingToSeeGetsACameraAllTheSame) {
    for (Scene scene :
         {Scene{}, triangleScene({nan, 0, 0}, {1, 0, 0}, {0, 1, 0}), triangleScene({0, 0, 0}, {1, 1, 1}, {2, 2, 2})}) {
        completeScene(scene);
        ASSERT_EQ(scene.cameras.size(), 1u);
        EXPECT_EQ(findFault(scene), std::nullopt);
        std::vector<vec3> unitBox;
        for (const float x : {-0.5f, 0.5f})
            for (const float y : {-0.5f, 0.5f})
                for (const float z : {-0.5f, 0.5f}) unitBox.emplace_back(x, y, z);
        EXPECT_NEAR(farthestInFrame(scene.cameras[0], unitBox), 0.95, 1e-5);
    }
}

TEST(CompleteScene, ExtremeScenesGetFiniteCameras) {
    for (const float scale : {1e-38f, 1e-20f, 1e10f, 1.8e18f}) {
        Scene scene = triangleScene({0, 0, 0}, {scale, 0, 0}, {0, scale, -scale});
        completeScene(scene);
        EXPECT_EQ(findFault(scene), std::nullopt) << scale;
        EXPECT_NE(scene.cameras[0].eye, vec3(0)) << scale;
    }
    Scene far = triangleScene({1e6f, 1e6f, 1e6f}, {1e6f + 1, 1e6f, 1e6f}, {1e6f, 1e6f + 1, 1e6f});
    completeScene(far);
    EXPECT_NEAR(farthestInFrame(far.cameras[0], far.meshes[0].positions), 0.95, 0.1);
}

TEST(CornellBoxes, AreWholeAsTheyAre) {
    for (const auto& [name, primitives] :
         {std::pair("cornell_box.gltf", 32u), std::pair("cornell_spheres.gltf", 12u + 2u)}) {
        const Scene scene = importScene(std::filesystem::path(RAIG_SOURCE_DIR) / "assets" / name);
        ASSERT_EQ(scene.remarks.size(), 1u) << name;
        EXPECT_NE(scene.remarks.front().find("ambient"), std::string::npos) << scene.remarks.front();
        EXPECT_TRUE(scene.lights.empty()) << "the lamp is all the light there is";
        const Geometry geometry = flatten(scene);
        EXPECT_EQ(geometry.triangles.size(), primitives);
        EXPECT_EQ(geometry.dropped.zeroArea + geometry.dropped.nonFinite, 0u);
        EXPECT_EQ(scene.cameras.at(0).eye, vec3(278, 273, -800));
        EXPECT_NEAR(scene.cameras.at(0).forward.z, 1.0f, 1e-6f);
        EXPECT_NEAR(scene.cameras.at(0).yfov, 2.0f * std::atan(0.0125f / 0.035f), 1e-6f);
    }
}

}  // namespace
}  // namespace raig
