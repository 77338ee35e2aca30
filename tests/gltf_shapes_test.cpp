// KHR_implicit_shapes: spheres from glTF files, in meshes and in the world, and what is wrong with files that have them.
#include "base/error.hpp"
#include "scene/geometry.hpp"
#include "scene/validate.hpp"
#include "support/gltf_asset.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace raig {
namespace {

using nlohmann::json;
using test::GltfAsset;

const char* const name = "KHR_implicit_shapes";

json shapePrimitive(int shape) {
    return {{"extensions", {{name, {{"shape", shape}}}}}};
}

/// An asset with these shapes, which it requires.
GltfAsset assetOf(const json& shapes) {
    GltfAsset asset;
    asset.json["extensionsUsed"] = asset.json["extensionsRequired"] = json::array({name});
    asset.json["extensions"][name]["shapes"] = shapes;
    return asset;
}

json sphereShape(double radius) {
    return {{"type", "sphere"}, {"sphere", {{"radius", radius}}}};
}

bool hasRemark(const Scene& scene, const std::string& text) {
    return std::ranges::any_of(scene.remarks,
                               [&](const std::string& remark) { return remark.find(text) != std::string::npos; });
}

std::string refusal(const GltfAsset& asset) {
    try {
        asset.load();
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::badInput) << error.what();
        return error.what();
    }
    ADD_FAILURE() << "it is not refused";
    return "";
}

TEST(GltfShapes, SpheresFollowTheTrianglesOfTheirMesh) {
    GltfAsset asset = assetOf(json::array(
        {sphereShape(2.0), {{"type", "sphere"}}, {{"type", "sphere"}, {"sphere", json::object()}}, sphereShape(3)}));
    asset.json["materials"] = json::array({json::object(), json::object()});
    json first = shapePrimitive(0), second = shapePrimitive(3);
    first["material"] = 1;
    const json triangle = {{"attributes", {{"POSITION", asset.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3")}}},
                           {"material", 0}};
    asset.mesh(first);
    asset.json["meshes"][0]["primitives"] = json::array({first, triangle, second, shapePrimitive(1), shapePrimitive(2)});
    asset.node({{"mesh", 0}, {"translation", {5, 6, 7}}, {"rotation", {0, 0.6, 0, 0.8}}, {"scale", {-2, 2, 2}}});
    const Scene scene = asset.load();
    EXPECT_EQ(findFault(scene), std::nullopt);
    const Mesh& mesh = scene.meshes[0];
    ASSERT_EQ(mesh.spheres.size(), 4u);
    ASSERT_EQ(mesh.triangles.size(), 1u);
    EXPECT_EQ(mesh.materials, (std::vector<uint32_t>{0, 1, 2, 2, 2}));  // 2: the default
    const float radii[] = {2.0f, 3.0f, 0.5f, 0.5f};
    const Geometry geometry = flatten(scene);
    ASSERT_EQ(geometry.triangles.size(), 5u);
    EXPECT_EQ(geometry.triangleCount(), 1u);
    EXPECT_FALSE(geometry.isSphere(0));
    for (uint32_t i = 0; i < 4; ++i) {
        ASSERT_TRUE(geometry.isSphere(1 + i));
        EXPECT_EQ(geometry.sphere(1 + i).centre, vec3(5, 6, 7));
        EXPECT_FLOAT_EQ(geometry.sphere(1 + i).radius, 2.0f * radii[i]);
        EXPECT_EQ(geometry.place(1 + i).primitive, 1 + i);
    }
    EXPECT_TRUE(geometry.bounds.contains(Box{vec3(-1, 0, 1), vec3(11, 12, 13)}));
}

TEST(GltfShapes, OtherShapesAreLeftOutAndCounted) {
    GltfAsset asset =
        assetOf(json::array({{{"type", "box"}, {"box", {{"size", {1, 2, 3}}}}}, {{"type", "capsule"}}, sphereShape(1.0)}));
    asset.mesh(shapePrimitive(0));
    asset.json["meshes"][0]["primitives"] = json::array({shapePrimitive(0), shapePrimitive(1), shapePrimitive(2)});
    asset.node({{"mesh", 0}});
    const Scene scene = asset.load();
    EXPECT_EQ(scene.meshes[0].spheres.size(), 1u);
    EXPECT_EQ(scene.otherPrimitives, 2u);
    EXPECT_TRUE(hasRemark(scene, "box"));
    EXPECT_TRUE(hasRemark(scene, "capsule"));
}

// What a sphere is scaled to by a node that does not scale evenly is no sphere: it is written out, for that node only.
TEST(GltfShapes, SpheresThatAreDeformedBecomeTriangles) {
    GltfAsset asset = assetOf(json::array({sphereShape(1.0)}));
    asset.mesh(shapePrimitive(0));
    asset.node({{"mesh", 0}, {"scale", {2, 2, 2}}});
    asset.node({{"mesh", 0}, {"scale", {1, 2, 3}}, {"translation", {10, 0, 0}}});
    asset.node({{"mesh", 0}, {"matrix", {1, 0, 0, 0, 0.5, 1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1}}});  // sheared
    const Scene scene = asset.load();
    EXPECT_EQ(findFault(scene), std::nullopt);
    EXPECT_TRUE(hasRemark(scene, "scales unevenly")) << "said once, with how often";
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_TRUE(scene.meshes[1].spheres.empty());
    EXPECT_EQ(scene.meshes[1].triangles.size(), 3968u);
    const Geometry geometry = flatten(scene);
    EXPECT_EQ(geometry.spheres.size(), 1u);
    EXPECT_EQ(geometry.dropped.zeroArea, 0u);
    for (uint32_t id = geometry.firstTriangle[1]; id < geometry.firstTriangle[2]; ++id) {
        const uvec3 t = geometry.triangles[id];
        dvec3 corners[3];
        for (int i = 0; i < 3; ++i) {
            const dvec3 p = (dvec3(geometry.positions[t[i]]) - dvec3(10, 0, 0)) / dvec3(1, 2, 3);
            EXPECT_NEAR(glm::length(p), 1.0, 1e-6);
            corners[i] = p;
        }
        EXPECT_GT(glm::dot(glm::cross(corners[1] - corners[0], corners[2] - corners[0]), corners[0]), 0.0) << "outwards";
        EXPECT_GT(glm::dot(dvec3(geometry.normals[t.x]), corners[0]), 0.0);
    }
}

/// An asset of one mesh of so many spheres, placed by one node that stretches it.
GltfAsset stretchedAsset(size_t spheres) {
    GltfAsset asset = assetOf(json::array({sphereShape(1.0)}));
    asset.mesh(shapePrimitive(0));
    asset.json["meshes"][0]["primitives"] = std::vector<json>(spheres, shapePrimitive(0));
    asset.node({{"mesh", 0}, {"scale", {1, 2, 1}}});
    return asset;
}

// Many instances share the triangles that their spheres become, and are counted without going through them one by one.
TEST(GltfShapes, SpheresThatManyInstancesDeformAreWrittenOutOnce) {
    GltfAsset asset = stretchedAsset(100);
    const char* const instancing = "EXT_mesh_gpu_instancing";
    asset.json["extensionsUsed"].push_back(instancing);
    asset.json["accessors"] = {{{"componentType", 5126}, {"count", 200000}, {"type", "VEC3"}}};  // zeros
    asset.json["nodes"][0]["extensions"][instancing]["attributes"]["TRANSLATION"] = 0;
    const Scene scene = asset.load();
    ASSERT_EQ(scene.meshes.size(), 2u);
    EXPECT_EQ(scene.meshes[1].triangles.size(), 100u * 3968u);
    EXPECT_EQ(scene.instances.size(), 200000u);
    EXPECT_TRUE(hasRemark(scene, "written out as triangles (20000000 times)"));
}

TEST(GltfShapes, MoreDeformedSpheresThanAreWrittenOutAreALimit) {
    // The second mesh takes them beyond it, and nothing is written out of it.
    GltfAsset asset = stretchedAsset(29);
    asset.mesh(shapePrimitive(0));
    asset.json["meshes"][1]["primitives"] = std::vector<json>(500, shapePrimitive(0));
    asset.node({{"mesh", 1}, {"scale", {1, 2, 1}}});
    try {
        asset.load();
        FAIL() << "529 spheres were written out";
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::limit);
        EXPECT_NE(std::string(error.what()).find("asset.glb#/meshes/1: "), std::string::npos) << error.what();
        EXPECT_NE(std::string(error.what()).find("at most 528"), std::string::npos) << error.what();
    }
    asset.json["nodes"][1]["scale"] = {2, 2, 2};
    EXPECT_EQ(asset.load().meshes.size(), 3u) << "those of a node that scales evenly count for nothing";
}

TEST(GltfShapes, WhatSpheresCannotHaveIsTold) {
    GltfAsset asset = assetOf(json::array({sphereShape(1.0)}));
    asset.json["materials"] = json::array({{{"emissiveFactor", {1, 1, 1}}}});
    json primitive = shapePrimitive(0);
    primitive["material"] = 0;
    asset.mesh(primitive);
    asset.node({{"mesh", 0}});
    Scene scene = asset.load();
    EXPECT_TRUE(hasRemark(scene, "lights nothing"));
    completeScene(scene);
    EXPECT_EQ(scene.lights.size(), 1u) << "it is no light, so there is a headlight";
}

TEST(GltfShapes, BadFilesAreRefusedByPointer) {
    const auto refusalOf = [](const json& shapes, const json& primitive) {
        GltfAsset asset = assetOf(shapes);
        asset.mesh(primitive);
        asset.node({{"mesh", 0}});
        return refusal(asset);
    };
    const json good = json::array({sphereShape(1.0)}), use = shapePrimitive(0);
    const auto expectIn = [](const std::string& message, const std::string& part) {
        EXPECT_NE(message.find(part), std::string::npos) << message;
    };
    expectIn(refusalOf(good, shapePrimitive(1)),
             "#/meshes/0/primitives/0/extensions/KHR_implicit_shapes/shape: names shape 1 of 1");
    expectIn(refusalOf(json::array(), use), "names shape 0 of 0");
    expectIn(refusalOf(good, {{"extensions", {{name, json::object()}}}}), "KHR_implicit_shapes/shape: is missing");
    expectIn(refusalOf(good, {{"extensions", {{name, {{"shape", -1}}}}}}), "KHR_implicit_shapes/shape: must be");
    expectIn(refusalOf(good, {{"extensions", {{name, {{"shape", "0"}}}}}}), "KHR_implicit_shapes/shape: must be");
    for (const double radius : {0.0, -1.0, 1e300, 1e-60})
        expectIn(refusalOf(json::array({sphereShape(radius)}), use),
                 "#/extensions/KHR_implicit_shapes/shapes/0/sphere/radius: is");
    expectIn(refusalOf(json::array({{{"type", "sphere"}, {"sphere", {{"radius", "big"}}}}}), use), "sphere/radius: must be");
    expectIn(refusalOf(json::array({{{"type", "sphere"}, {"sphere", {{"radius", {1, 2}}}}}}), use),
             "sphere/radius: must be");
    expectIn(refusalOf(json::array({{{"sphere", {{"radius", 1}}}}}), use),
             "#/extensions/KHR_implicit_shapes/shapes/0/type: is missing");
    expectIn(refusalOf(json::array({{{"type", 7}}}), use), "shapes/0/type: must be");
    expectIn(refusalOf(json::array({{{"type", "sphere"}, {"sphere", 7}}}), use), "shapes/0/sphere: must be");
    expectIn(refusalOf(json::array({7}), use), "shapes/0: must be");
    expectIn(refusalOf(json{{"type", "sphere"}}, use), "shapes: must be");
}

}  // namespace
}  // namespace raig
