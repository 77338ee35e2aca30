// glTF's animations, skins and morph targets, at moments at which it is known where everything is.
#include "base/error.hpp"
#include "scene/validate.hpp"
#include "support/moving_assets.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using nlohmann::json;
using test::animate;
using test::bendingBar;
using test::GltfAsset;
using test::morphedTriangle;

constexpr double pi = 3.14159265358979323846;

Moment at(double seconds, const std::string& animation = "") {
    return {seconds, animation};
}

bool hasRemark(const Scene& scene, const std::string& part) {
    return std::ranges::any_of(scene.remarks, [&](const std::string& r) { return r.find(part) != std::string::npos; });
}

void expectNear(const dvec3& got, const dvec3& want, double tolerance) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(got[k], want[k], tolerance) << "component " << k;
}

/// A node with a triangle, moved by one channel.
GltfAsset moved(const std::string& path, const std::vector<float>& times, const std::vector<float>& values,
                const std::string& type, const std::string& interpolation) {
    GltfAsset asset;
    animate(asset, 0, asset.node({{"mesh", asset.triangle()}}), path, times, values, type, interpolation);
    return asset;
}

dvec3 placeOf(const GltfAsset& asset, double seconds) {
    return dvec3(asset.load(at(seconds)).instances.at(0).toWorld[3]);
}

/// Rodrigues' formula: what turns by `angle` about unit vector `axis`.
dvec3 turned(const dvec3& v, const dvec3& axis, double angle) {
    return v * std::cos(angle) + glm::cross(axis, v) * std::sin(angle) + axis * glm::dot(axis, v) * (1.0 - std::cos(angle));
}

TEST(Animation, LinearTranslationsLieOnTheSegmentAndAreHeldOutsideTheClip) {
    const GltfAsset asset = moved("translation", {0.5f, 1, 3}, {1, 0, 0, 2, 4, 0, 2, 4, 8}, "VEC3", "LINEAR");
    expectNear(placeOf(asset, -7), {1, 0, 0}, 0);
    expectNear(placeOf(asset, 0), {1, 0, 0}, 0);
    expectNear(placeOf(asset, 0.625), {1.25, 1, 0}, 1e-15);
    expectNear(placeOf(asset, 1), {2, 4, 0}, 0);
    expectNear(placeOf(asset, 2.5), {2, 4, 6}, 1e-14);
    expectNear(placeOf(asset, 3), {2, 4, 8}, 0);
    expectNear(placeOf(asset, 1e300), {2, 4, 8}, 0);
}

TEST(Animation, StepsHoldUntilTheNextKeyframe) {
    const GltfAsset asset = moved("scale", {0, 1, 2}, {1, 2, 3, 4, 5, 6, 7, 8, 9}, "VEC3", "STEP");
    const auto scaleAt = [&](double seconds) {
        const dmat4 m = asset.load(at(seconds)).instances[0].toWorld;
        return dvec3(m[0].x, m[1].y, m[2].z);
    };
    expectNear(scaleAt(0.999999), {1, 2, 3}, 0);
    expectNear(scaleAt(1), {4, 5, 6}, 0);
    expectNear(scaleAt(1.999999), {4, 5, 6}, 0);
    expectNear(scaleAt(2), {7, 8, 9}, 0);
}

// A cubic is its own Hermite spline, whatever the distance of keyframes: t^3 - 2 t + 1, whose derivative is 3 t^2 - 2.
TEST(Animation, ACubicSplineIsTheCubicThroughItsValuesAndTangents) {
    const auto value = [](double t) { return t * t * t - 2 * t + 1; };
    std::vector<float> values;
    const std::vector<float> times = {0, 1, 3, 3.5f};
    for (const float t : times)
        for (const double number : {3.0 * t * t - 2.0, value(t), 3.0 * t * t - 2.0})
            for (const double factor : {1.0, -2.0, 0.5}) values.push_back(static_cast<float>(number * factor));
    const GltfAsset asset = moved("translation", times, values, "VEC3", "CUBICSPLINE");
    for (const double t : {0.0, 0.25, 0.9, 1.0, 1.5, 2.875, 3.0, 3.25, 3.5}) {
        SCOPED_TRACE(t);
        expectNear(placeOf(asset, t), dvec3(1.0, -2.0, 0.5) * value(t), 1e-13 * 100);
    }
    expectNear(placeOf(asset, 4), dvec3(1.0, -2.0, 0.5) * value(3.5), 1e-13 * 100);
}

TEST(Animation, LinearRotationsGoAlongTheShorterArcAtConstantSpeed) {
    const dvec3 axis = dvec3(1, 1, 1) / std::sqrt(3.0);
    const double angle = 2.0 * pi / 3.0;
    const auto quaternion = [&](double turn, double sign) {
        const dvec3 v = axis * std::sin(turn / 2);
        return std::vector<float>{float(sign * v.x), float(sign * v.y), float(sign * v.z), float(sign * std::cos(turn / 2))};
    };
    for (const double sign : {1.0, -1.0}) {  // the same rotation, but the longer arc between the numbers
        std::vector<float> values = quaternion(0, 1), last = quaternion(angle, sign);
        values.insert(values.end(), last.begin(), last.end());
        const GltfAsset asset = moved("rotation", {0, 1}, values, "VEC4", "LINEAR");
        for (const double share : {0.0, 0.125, 0.25, 0.5, 0.75, 1.0}) {
            SCOPED_TRACE(share);
            const dmat4 m = asset.load(at(share)).instances[0].toWorld;
            for (int k = 0; k < 3; ++k) {
                dvec3 e(0.0);
                e[k] = 1.0;
                expectNear(dvec3(m[k]), turned(e, axis, share * angle), 2e-7);  // the keyframes are floats
            }
        }
    }
}

TEST(Animation, RotationsThatHardlyDifferAndThatAreOppositeHaveAPlaceBetween) {
    const float tiny = 1e-6f;
    const GltfAsset near = moved("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, tiny, 1}, "VEC4", "LINEAR");
    // Half of an angle of 2e-6.
    EXPECT_NEAR(near.load(at(0.5)).instances[0].toWorld[0].y, 1e-6, 1e-12);
    const GltfAsset same = moved("rotation", {0, 1}, {0, 0, 1, 0, 0, 0, 1, 0}, "VEC4", "LINEAR");
    EXPECT_EQ(same.load(at(0.5)).instances[0].toWorld[0].x, -1.0);
    // A full turn of the quaternion by 180 degrees: either way round is right, and it is half way.
    const GltfAsset far = moved("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 1, 0}, "VEC4", "LINEAR");
    EXPECT_NEAR(std::abs(far.load(at(0.5)).instances[0].toWorld[0].y), 1.0, 1e-15);
}

TEST(Animation, SplineRotationsAreMadeUnitAndNormalizedIntegersAreRead) {
    // From none to a half turn with tangents of zero: half way, the quaternion is (0, 0, 0.5, 0.5), a quarter turn.
    const GltfAsset spline = moved(
        "rotation", {0, 2}, {0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0, 0, 0, 0, 0, 0, 1, 0, 0, 0, 0, 0}, "VEC4", "CUBICSPLINE");
    const dmat4 m = spline.load(at(1)).instances[0].toWorld;
    expectNear(dvec3(m[0]), {0, 1, 0}, 1e-15);
    expectNear(dvec3(m[1]), {-1, 0, 0}, 1e-15);

    GltfAsset integers = moved("rotation", {0, 1}, {0, 0, 0, 1, 0, 0, 0, 1}, "VEC4", "LINEAR");
    const int output = integers.accessor(std::vector<int16_t>{0, 0, 0, 32767, 0, 0, -32767, 0}, "VEC4", 5122, true);
    integers.json["animations"][0]["samplers"][0]["output"] = output;
    EXPECT_NEAR(std::abs(integers.load(at(0.5)).instances[0].toWorld[0].y), 1.0, 1e-15);
}

TEST(Animation, OnlyTheOneThatIsNamedIsPlayed) {
    GltfAsset asset;
    const int node = asset.node({{"mesh", asset.triangle()}, {"translation", {5, 6, 7}}});
    animate(asset, 0, node, "translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "VEC3");
    animate(asset, 1, node, "translation", {0, 2}, {0, 0, 0, 0, 1, 0}, "VEC3");
    asset.json["animations"][1]["name"] = "up";
    const auto place = [&](const Moment& moment) { return dvec3(asset.load(moment).instances[0].toWorld[3]); };
    expectNear(place({}), {5, 6, 7}, 0);
    expectNear(place(at(1)), {1, 0, 0}, 0);
    expectNear(place(at(1, "0")), {1, 0, 0}, 0);
    expectNear(place(at(1, "1")), {0, 0.5, 0}, 0);
    expectNear(place(at(1, "up")), {0, 0.5, 0}, 0);
    EXPECT_TRUE(hasRemark(asset.load(at(1)), "of 2 animations, animation 0 is played"));
    EXPECT_TRUE(hasRemark(asset.load(), "animations are not played"));
    const Scene scene = asset.load();
    ASSERT_EQ(scene.clips.size(), 2u);
    EXPECT_EQ(scene.clips[0].name, "");
    EXPECT_EQ(scene.clips[0].seconds, 1.0);
    EXPECT_EQ(scene.clips[1].name, "up");
    EXPECT_EQ(scene.clips[1].seconds, 2.0);
    for (const char* const wanted : {"2", "down", "-1", "1x"}) {
        try {
            asset.load(at(0, wanted));
            FAIL() << wanted;
        } catch (const Error& error) {
            EXPECT_EQ(error.exitCode, ExitCode::usage);
            EXPECT_NE(std::string(error.what()).find("it has: 0 (unnamed), 1 up"), std::string::npos) << error.what();
        }
    }
}

TEST(Animation, ParentsCarryTheirChildrenCamerasAndLightsToo) {
    GltfAsset asset;
    asset.json["extensionsUsed"] = {"KHR_lights_punctual"};
    asset.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}}}}}}};
    asset.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.125}}}}};
    const int mesh = asset.node({{"mesh", asset.triangle()}, {"translation", {1, 0, 0}}});
    const int view = asset.node({{"camera", 0}});
    const int lamp = asset.node({{"translation", {0, 2, 0}}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const int root = asset.node({{"children", {mesh, view, lamp}}});
    const float half = 0.70710678f;
    animate(asset, 0, root, "rotation", {0, 1}, {0, 0, 0, 1, 0, 0, half, half}, "VEC4");
    animate(asset, 0, root, "translation", {0, 1}, {0, 0, 0, 0, 0, 10}, "VEC3");
    const Scene scene = asset.load(at(1));
    expectNear(dvec3(scene.instances[0].toWorld[3]), {0, 1, 10}, 1e-6);
    expectNear(dvec3(scene.cameras[0].eye), {0, 0, 10}, 1e-6);
    expectNear(dvec3(scene.cameras[0].up), {-1, 0, 0}, 1e-6);
    expectNear(dvec3(scene.lights[0].position), {-2, 0, 10}, 1e-6);
}

TEST(Animation, WhatIsNoNodesTransformIsRemarkedAndLeftOut) {
    GltfAsset asset = moved("translation", {0, 1}, {0, 0, 0, 1, 0, 0}, "VEC3", "LINEAR");
    json& channels = asset.json["animations"][0]["channels"];
    channels.push_back({{"sampler", 0}, {"target", {{"path", "translation"}}}});
    channels.push_back(
        {{"sampler", 0},
         {"target",
          {{"path", "pointer"}, {"extensions", {{"KHR_animation_pointer", {{"pointer", "/materials/0/alphaCutoff"}}}}}}}});
    const Scene scene = asset.load(at(1));
    expectNear(dvec3(scene.instances[0].toWorld[3]), {1, 0, 0}, 0);
    EXPECT_TRUE(hasRemark(scene, "an animation of what is no node is not played"));
    EXPECT_TRUE(hasRemark(scene, "an animation of 'pointer' is not played"));
}

TEST(Skin, ABarBendsWhereItsJointsPutIt) {
    for (const double seconds : {0.0, 0.5, 1.0, 2.0, 9.0}) {
        SCOPED_TRACE(seconds);
        const double angle = pi / 4 * std::min(seconds, 2.0), c = std::cos(angle), s = std::sin(angle);
        const Scene scene = bendingBar().load(at(seconds));
        ASSERT_EQ(scene.instances.size(), 1u);
        EXPECT_EQ(scene.instances[0].toWorld, dmat4(1.0)) << "the node's own transform means nothing";
        const Mesh& mesh = scene.meshes.at(0);
        const auto byJoint1 = [&](double x, double y) { return dvec3(c * x - s * (y - 1), s * x + c * (y - 1) + 1, 0); };
        for (size_t i = 0; i < 6; ++i) {
            const double x = i % 2 ? 0.5 : -0.5, y = double(i / 2);
            const dvec3 still(x, y, 0), moved = byJoint1(x, y);
            expectNear(dvec3(mesh.positions[i]), i < 2 ? still : i < 4 ? 0.5 * (still + moved) : moved, 3e-7);
        }
        expectNear(dvec3(mesh.normals[0]), {0, 1, 0}, 1e-7);
        expectNear(dvec3(mesh.normals[4]), {-s, c, 0}, 3e-7);
        EXPECT_NEAR(glm::length(mesh.normals[2]), 1.0, 1e-6);
        EXPECT_EQ(mesh.triangles[0], uvec3(0, 1, 2));
        EXPECT_EQ(findFault(scene), std::nullopt);
    }
}

TEST(Skin, AtRestJointsAreWhereTheirNodesSay) {
    GltfAsset asset = bendingBar();
    asset.json["nodes"][1]["translation"] = {0, 3, 0};
    const Scene scene = asset.load();
    EXPECT_EQ(scene.meshes[0].positions[4], vec3(-0.5f, 4, 0));
    EXPECT_EQ(scene.meshes[0].positions[2], vec3(-0.5f, 2, 0)) << "the average of 1 and 3";
    asset.json["nodes"][0]["scale"] = {2, 2, 2};  // joint 0, and joint 1 below it
    EXPECT_EQ(asset.load().meshes[0].positions[4], vec3(-1, 8, 0));
}

TEST(Skin, WithoutInverseBindMatricesJointsMoveTheMeshAsItIs) {
    GltfAsset asset = bendingBar();
    asset.json["skins"][0].erase("inverseBindMatrices");
    EXPECT_EQ(asset.load().meshes[0].positions[4], vec3(-0.5f, 3, 0));
}

TEST(Skin, WeightsOfIntegersOfTwoSetsAndOfSumsOtherThanOneAreAveraged) {
    GltfAsset asset = bendingBar();
    json& attributes = asset.json["meshes"][0]["primitives"][0]["attributes"];
    asset.json["nodes"][1]["translation"] = {0, 4, 0};  // joint 1 moves by 3
    // A quarter of joint 1 each: 1 of 4 in bytes; in two sets; of a sum of 2.
    const std::vector<uint8_t> first(24, 0);
    std::vector<uint8_t> both;
    for (int i = 0; i < 6; ++i) both.insert(both.end(), {0, 1, 0, 0});
    attributes["JOINTS_0"] = asset.accessor(both, "VEC4", 5121);
    std::vector<uint8_t> bytes;
    for (int i = 0; i < 6; ++i) bytes.insert(bytes.end(), {150, 50, 0, 0});
    attributes["WEIGHTS_0"] = asset.accessor(bytes, "VEC4", 5121, true);
    expectNear(dvec3(asset.load().meshes[0].positions[0]), {-0.5, 0.75, 0}, 1e-6);
    const auto constant = [&](const std::vector<float>& of) {
        std::vector<float> values;
        for (int i = 0; i < 6; ++i) values.insert(values.end(), of.begin(), of.end());
        return asset.floats(values, "VEC4");
    };
    attributes["WEIGHTS_0"] = constant({1.5f, 0.5f, 0, 0});
    EXPECT_EQ(asset.load().meshes[0].positions[0], vec3(-0.5f, 0.75f, 0));
    attributes["JOINTS_1"] = asset.accessor(both, "VEC4", 5121);
    attributes["WEIGHTS_0"] = constant({0.5f, 0, 0, 0});
    attributes["WEIGHTS_1"] = constant({0.25f, 0.25f, 0, 0});
    EXPECT_EQ(asset.load().meshes[0].positions[0], vec3(-0.5f, 0.75f, 0));
    attributes["WEIGHTS_0"] = attributes["WEIGHTS_1"] = constant({0, 0, 0, 0});
    const Scene weightless = asset.load();
    EXPECT_EQ(weightless.meshes[0].positions[0], vec3(-0.5f, 0, 0)) << "it follows its first joint";
    EXPECT_TRUE(hasRemark(weightless, "has no weight"));
}

TEST(Skin, JointsThatMirrorKeepFrontsInFront) {
    GltfAsset asset = bendingBar();
    asset.json["nodes"][0]["scale"] = {-1, 1, 1};
    const Mesh mesh = asset.load().meshes[0];
    EXPECT_EQ(mesh.positions[1], vec3(-0.5f, 0, 0));
    EXPECT_EQ(mesh.triangles[0], uvec3(0, 2, 1)) << "as instances that mirror have it";
    const auto up = [&](const uvec3& t) {
        return glm::cross(mesh.positions[t.y] - mesh.positions[t.x], mesh.positions[t.z] - mesh.positions[t.x]).z > 0;
    };
    EXPECT_TRUE(up(mesh.triangles[0]));
}

TEST(Morph, WeightsComeFromTheMeshTheNodeOrTheAnimation) {
    GltfAsset asset = morphedTriangle();
    const auto corners = [&](const Moment& moment) { return asset.load(moment).meshes.at(0).positions; };
    using Corners = std::vector<vec3>;
    EXPECT_EQ(corners({}), (Corners{{0, 0, 0}, {1, 0, 1}, {0, 1, 0}})) << "the mesh's";
    EXPECT_EQ(corners(at(0.5)), (Corners{{0, 2, 0}, {1, 2, 2}, {0, 3, 0}})) << "the animation's";
    EXPECT_EQ(corners(at(1)), (Corners{{0, 4, 0}, {1, 4, 4}, {0, 5, 0}}));
    asset.json["nodes"][0]["weights"] = {0, 1};
    EXPECT_EQ(corners({}), (Corners{{0, 8, 0}, {1, 8, 0}, {0, 9, 0}})) << "the node's";
    EXPECT_EQ(corners(at(0.5)), (Corners{{0, 2, 0}, {1, 2, 2}, {0, 3, 0}}));
}

TEST(Morph, NormalsAreAddedAndMadeUnit) {
    const Mesh mesh = morphedTriangle().load(at(1)).meshes[0];
    expectNear(dvec3(mesh.normals[0]), {0, 0, 1}, 0);
    expectNear(dvec3(mesh.normals[1]), dvec3(1, 0, 1) / std::sqrt(2.0), 1e-7);
}

TEST(Morph, WithASkinTargetsComeFirst) {
    GltfAsset asset = bendingBar();
    std::vector<float> wider;
    for (int i = 0; i < 6; ++i) wider.insert(wider.end(), {i % 2 ? 1.0f : -1.0f, 0, 0});
    asset.json["meshes"][0]["primitives"][0]["targets"] = {{{"POSITION", asset.floats(wider, "VEC3")}}};
    asset.json["meshes"][0]["weights"] = {0.5};
    const Mesh mesh = asset.load(at(2)).meshes[0];
    expectNear(dvec3(mesh.positions[0]), {-1, 0, 0}, 1e-7);
    expectNear(dvec3(mesh.positions[4]), {-1, 0, 0}, 1e-6);  // (-1, 1) above joint 1, by a quarter turn
    expectNear(dvec3(mesh.positions[5]), {-1, 2, 0}, 1e-6);
}

TEST(Morph, AMeshThatIsBentAlikeIsStoredOnceAndOtherwiseAgain) {
    GltfAsset asset = morphedTriangle();
    asset.json.erase("animations");
    const int other = asset.triangle();
    asset.node({{"mesh", 0}, {"weights", {0.25, 0}}});
    asset.node({{"mesh", 0}, {"weights", {0, 0}}});
    asset.node({{"mesh", other}});
    asset.node({{"mesh", 0}, {"weights", {0, 1}}});
    asset.node({{"mesh", 0}, {"weights", {0, 0}}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.meshes.size(), 4u);
    std::vector<uint32_t> shown;
    for (const Instance& instance : scene.instances) shown.push_back(instance.mesh);
    EXPECT_EQ(shown, (std::vector<uint32_t>{0, 0, 2, 1, 3, 2}));
    EXPECT_EQ(scene.meshes[2].positions[1], vec3(1, 0, 0));
    EXPECT_EQ(scene.meshes[3].positions[1], vec3(1, 8, 0));
}

TEST(MovingScene, ACameraThatWasAddedStays) {
    const test::TemporaryFolder folder;
    writeFileAtomically(folder.path / "bar.glb", bendingBar().glb());
    MovingScene moving(folder.path / "bar.glb");
    const Scene first = moving.at(at(0)), later = moving.at(at(2)), again = moving.at(at(0));
    EXPECT_EQ(first.cameras[0].eye, later.cameras[0].eye);
    EXPECT_NE(first.meshes[0].positions, later.meshes[0].positions);
    EXPECT_EQ(first.meshes[0].positions, again.meshes[0].positions);
    EXPECT_NE(importScene(folder.path / "bar.glb", at(2)).cameras[0].eye, first.cameras[0].eye);
}

// Where another program, in another language, has put vertices 0, 1000 and 3000 of the sample.
TEST(Skin, TheWalkingManIsWhereAnotherProgramPutsHim) {
    const std::filesystem::path file = std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/animated/CesiumMan.glb";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
    const std::pair<Moment, std::array<dvec3, 3>> cases[] = {
        {{},
         {dvec3(0.0934292, 0.9735749, -0.0487147), dvec3(-0.1309999, 1.4232998, 0.0691544),
          dvec3(0.1310001, 1.4228398, -0.0978833)}},
        {at(0.3),
         {dvec3(0.1093603, 0.9771256, -0.0214966), dvec3(-0.0762450, 1.4369068, 0.0906862),
          dvec3(0.1725750, 1.4307769, -0.0960708)}},
        {at(1),
         {dvec3(0.1081107, 0.9293007, -0.0197256), dvec3(-0.0319879, 1.3915229, 0.1468711),
          dvec3(0.1811485, 1.3798045, -0.0791941)}},
        {at(5),
         {dvec3(0.1163098, 0.9196381, -0.0258369), dvec3(-0.0431934, 1.3630768, 0.1576891),
          dvec3(0.2229991, 1.3800498, -0.0028216)}},
    };
    for (const auto& [moment, places] : cases) {
        const Mesh mesh = importGltf(file, moment).meshes.at(0);
        expectNear(dvec3(mesh.positions.at(0)), places[0], 1e-6);
        expectNear(dvec3(mesh.positions.at(1000)), places[1], 1e-6);
        expectNear(dvec3(mesh.positions.at(3000)), places[2], 1e-6);
    }
}

}  // namespace
}  // namespace raig
