// What glTF files mean: each feature in an asset of its own, and the sample scenes against their manifest.
#include "base/error.hpp"
#include "scene/validate.hpp"
#include "support/gltf_asset.hpp"
#include "support/mesh_files.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <limits>

namespace raig {
namespace {

using nlohmann::json;
using test::GltfAsset;

constexpr double pi = 3.14159265358979323846;

size_t flattenedTriangles(const Scene& scene) {
    size_t count = 0;
    for (const Instance& instance : scene.instances) count += scene.meshes[instance.mesh].triangles.size();
    return count;
}

size_t storedTriangles(const Scene& scene) {
    size_t count = 0;
    for (const Mesh& mesh : scene.meshes) count += mesh.triangles.size();
    return count;
}

void expectNear(const dvec3& got, const dvec3& want, double tolerance) {
    for (int k = 0; k < 3; ++k) EXPECT_NEAR(got[k], want[k], tolerance) << "component " << k;
}

/// Splits a line of comma-separated values; the manifest quotes nothing.
std::vector<std::string> fieldsOf(const std::string& line) {
    std::vector<std::string> fields;
    std::stringstream stream(line);
    for (std::string field; std::getline(stream, field, ',');) fields.push_back(field);
    return fields;
}

TEST(Gltf, SampleScenesHaveTheTrianglesOfTheirManifest) {
    const std::filesystem::path folder = std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes";
    std::ifstream manifest(folder / "MANIFEST.csv");
    if (!manifest) GTEST_SKIP() << "no sample scenes at " << folder;
    int checked = 0;
    for (std::string line; std::getline(manifest, line);) {
        const std::vector<std::string> fields = fieldsOf(line);
        if (fields.size() < 13 || fields[0].starts_with("bad/")) continue;
        const std::string ending = std::filesystem::path(fields[0]).extension();
        if (ending != ".glb" && ending != ".gltf") continue;
        SCOPED_TRACE(fields[0]);
        const Scene scene = importGltf(folder / fields[0]);
        EXPECT_EQ(std::to_string(flattenedTriangles(scene)), fields[6]);
        EXPECT_TRUE(fields[12].starts_with("uniqtris=" + std::to_string(storedTriangles(scene)) + " ")) << fields[12];
        EXPECT_EQ(std::to_string(scene.cameras.size()), fields[9]);
        EXPECT_EQ(std::to_string(scene.lights.size()), fields[8]);
        EXPECT_EQ(findFault(scene), std::nullopt);
        ++checked;
    }
    EXPECT_GE(checked, 13);
}

TEST(Gltf, StripsAndFansGiveTheTrianglesOfTheSpecification) {
    GltfAsset asset;
    const int positions = asset.floats(std::vector<float>(15, 1.0f), "VEC3");
    const int order = asset.indices({4, 3, 2, 1, 0});
    const auto mesh = [&](int mode, bool isIndexed) {
        json primitive = {{"attributes", {{"POSITION", positions}}}, {"mode", mode}};
        if (isIndexed) primitive["indices"] = order;
        asset.mesh(primitive);
    };
    mesh(5, false), mesh(6, false), mesh(5, true), mesh(4, true);
    const Scene scene = asset.load();
    EXPECT_EQ(scene.meshes[0].triangles, (std::vector<uvec3>{{0, 1, 2}, {1, 3, 2}, {2, 3, 4}}));
    EXPECT_EQ(scene.meshes[1].triangles, (std::vector<uvec3>{{1, 2, 0}, {2, 3, 0}, {3, 4, 0}}));
    EXPECT_EQ(scene.meshes[2].triangles, (std::vector<uvec3>{{4, 3, 2}, {3, 1, 2}, {2, 1, 0}}));
    EXPECT_EQ(scene.meshes[3].triangles, (std::vector<uvec3>{{4, 3, 2}}));
}

TEST(Gltf, PointsAndLinesAreCountedAndLeftOut) {
    GltfAsset asset;
    const int positions = asset.floats(std::vector<float>(15, 1.0f), "VEC3");
    for (int mode = 0; mode < 4; ++mode) asset.mesh({{"attributes", {{"POSITION", positions}}}, {"mode", mode}});
    const Scene scene = asset.load();
    EXPECT_EQ(storedTriangles(scene), 0u);
    EXPECT_EQ(scene.otherPrimitives, 5u + 2u + 5u + 4u);
}

TEST(Gltf, PrimitivesAreConcatenatedAndShareTheirVertices) {
    GltfAsset asset;
    const int mesh = asset.triangle();
    json& primitives = asset.json["meshes"][mesh]["primitives"];
    primitives.push_back(primitives[0]);
    primitives[1]["material"] = 0;
    primitives.push_back({{"attributes",
                           {{"POSITION", asset.floats(std::vector<float>(9, 2.0f), "VEC3")},
                            {"COLOR_0", asset.floats({.1f, .2f, .3f, .4f, .5f, .6f, .7f, .8f, .9f}, "VEC3")}}}});
    asset.json["materials"] = {{{"name", "first"}}};
    const Scene scene = asset.load();
    ASSERT_EQ(scene.materials.size(), 2u);  // and the default
    EXPECT_EQ(scene.meshes[0].positions.size(), 6u);
    EXPECT_EQ(scene.meshes[0].triangles, (std::vector<uvec3>{{0, 1, 2}, {0, 1, 2}, {3, 4, 5}}));
    EXPECT_EQ(scene.meshes[0].materials, (std::vector<uint32_t>{1, 0, 1}));
    ASSERT_EQ(scene.meshes[0].colors.size(), 6u);
    EXPECT_EQ(scene.meshes[0].colors[0], vec3(1.0f));
    EXPECT_EQ(scene.meshes[0].colors[4], vec3(.4f, .5f, .6f));
}

TEST(Gltf, NodeTransformsMultiplyInDouble) {
    GltfAsset asset;
    const int mesh = asset.triangle();
    // 1e9 + 0.001 is exact to 1e-7 in double, and is 1e9 in float.
    const int child = asset.node({{"mesh", mesh}, {"translation", {0.001, 0, 0}}, {"scale", {2, 3, 4}}});
    const double h = std::sqrt(0.5);
    const int parent = asset.node({{"children", {child}}, {"translation", {1e9, 5, 0}}, {"rotation", {0, 0, h, h}}});
    asset.node({{"mesh", mesh}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}}});
    asset.json["scenes"] = {{{"nodes", {2, parent}}}};
    const Scene scene = asset.load();
    ASSERT_EQ(scene.instances.size(), 2u);
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(dvec3(scene.instances[0].toWorld[3]), dvec3(7, 8, 9));
    const dmat4& m = scene.instances[1].toWorld;  // a quarter turn about z: x to y, y to -x
    expectNear(dvec3(m[0]), {0, 2, 0}, 1e-12);
    expectNear(dvec3(m[1]), {-3, 0, 0}, 1e-12);
    expectNear(dvec3(m[2]), {0, 0, 4}, 1e-12);
    expectNear(dvec3(m[3]), {1e9, 5.001, 0}, 1e-6);
}

TEST(Gltf, OnlyNodesOfTheDefaultSceneArePlaced) {
    GltfAsset asset;
    const int mesh = asset.triangle();
    for (int i = 0; i < 3; ++i) asset.node({{"mesh", mesh}, {"translation", {i, 0, 0}}});
    EXPECT_EQ(asset.load().instances.size(), 3u);  // no scene: all roots
    asset.json["scenes"] = {{{"nodes", {0, 1}}}, {{"nodes", {2}}}};
    EXPECT_EQ(asset.load().instances.size(), 2u);  // no default: scene 0
    asset.json["scene"] = 1;
    const Scene scene = asset.load();
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].toWorld[3].x, 2.0);
}

TEST(Gltf, AChainOfNodesMayBeAnyLength) {
    GltfAsset asset;
    const int mesh = asset.triangle();
    constexpr int length = 20'000;
    for (int i = 0; i + 1 < length; ++i) asset.node({{"children", {i + 1}}, {"translation", {1, 0, 0}}});
    asset.node({{"mesh", mesh}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.instances.size(), 1u);
    EXPECT_EQ(scene.instances[0].toWorld[3].x, length - 1.0);
}

TEST(Gltf, GpuInstancingGivesOneInstanceACopy) {
    GltfAsset asset;
    const int mesh = asset.triangle();
    const int translations = asset.floats({1, 0, 0, 2, 0, 0, 3, 0, 0}, "VEC3");
    const int scales = asset.floats({1, 1, 1, 2, 2, 2, 3, 3, 3}, "VEC3");
    asset.node({{"mesh", mesh},
                {"translation", {0, 10, 0}},
                {"extensions",
                 {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", translations}, {"SCALE", scales}}}}}}}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.instances.size(), 3u);
    EXPECT_EQ(scene.meshes.size(), 1u);
    EXPECT_EQ(dvec3(scene.instances[2].toWorld[3]), dvec3(3, 10, 0));
    EXPECT_EQ(scene.instances[2].toWorld[1].y, 3.0);
}

TEST(Gltf, CamerasStandWhereTheirNodesAre) {
    GltfAsset asset;
    asset.json["cameras"] = {
        {{"type", "perspective"}, {"perspective", {{"yfov", 1}, {"znear", 0.1}, {"aspectRatio", 1.5}}}},
        {{"type", "orthographic"}, {"orthographic", {{"xmag", 3}, {"ymag", 2}, {"znear", 0}, {"zfar", 9}}}}};
    const double h = std::sqrt(0.5);  // a quarter turn about y: -z to -x
    asset.node({{"camera", 0}, {"translation", {1, 2, 3}}, {"rotation", {0, h, 0, h}}, {"scale", {2, 5, 7}}});
    asset.node({{"camera", 1}, {"scale", {-1, 1, 1}}});
    asset.node({{"camera", 1}, {"scale", {0, 0, 0}}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.cameras.size(), 2u);
    EXPECT_TRUE(hasRemark(scene, "camera"));
    EXPECT_EQ(scene.cameras[0].eye, vec3(1, 2, 3));
    expectNear(dvec3(scene.cameras[0].forward), {-1, 0, 0}, 1e-7);
    expectNear(dvec3(scene.cameras[0].up), {0, 1, 0}, 1e-7);
    expectNear(dvec3(scene.cameras[0].right), {0, 0, -1}, 1e-7);
    EXPECT_FLOAT_EQ(scene.cameras[0].yfov, 1.0f);
    EXPECT_FLOAT_EQ(scene.cameras[0].aspect, 1.5f);
    EXPECT_TRUE(scene.cameras[1].orthographic);
    EXPECT_EQ(scene.cameras[1].xmag, 3.0f);
    EXPECT_EQ(scene.cameras[1].right, vec3(-1, 0, 0));  // mirrored
}

TEST(Gltf, LightsShineAlongTheirNodes) {
    GltfAsset asset;
    const json lights = {{{"type", "point"}, {"intensity", 10}, {"color", {1, 0.5, 0}}, {"range", 4}},
                         {{"type", "spot"}, {"spot", {{"innerConeAngle", 0.25}, {"outerConeAngle", 0.5}}}},
                         {{"type", "directional"}, {"intensity", 3}}};
    asset.json["extensions"] = {{"KHR_lights_punctual", {{"lights", lights}}}};
    for (int i = 0; i < 3; ++i)  // half a turn about y: -z to z
        asset.node({{"translation", {i, 2, 3}},
                    {"rotation", {0, 1, 0, 0}},
                    {"extensions", {{"KHR_lights_punctual", {{"light", i}}}}}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.lights.size(), 3u);
    EXPECT_EQ(scene.lights[0].intensity, vec3(10, 5, 0));
    EXPECT_EQ(scene.lights[0].range, 4.0f);
    EXPECT_EQ(scene.lights[1].type, Light::Type::spot);
    EXPECT_EQ(scene.lights[1].position, vec3(1, 2, 3));
    EXPECT_EQ(scene.lights[1].outerConeAngle, 0.5f);
    EXPECT_EQ(scene.lights[2].type, Light::Type::directional);
    expectNear(dvec3(scene.lights[2].direction), {0, 0, 1}, 1e-7);
}

TEST(Gltf, MaterialsAndTheirExtensionsAreRead) {
    GltfAsset asset;
    asset.json["materials"] = {
        {{"alphaMode", "BLEND"},
         {"pbrMetallicRoughness",
          {{"baseColorFactor", {0.1, 0.2, 0.3, 0.4}}, {"metallicFactor", 0.5}, {"roughnessFactor", 0.25}}},
         {"emissiveFactor", {1, 0.5, 0}},
         {"extensions",
          {{"KHR_materials_transmission", {{"transmissionFactor", 1}}},
           {"KHR_materials_ior", {{"ior", 1.33}}},
           {"KHR_materials_volume", {{"attenuationColor", {0.5, 1, 1}}, {"attenuationDistance", 5'000'000'000}}},
           {"KHR_materials_emissive_strength", {{"emissiveStrength", 4}}}}}},
        {{"pbrMetallicRoughness", {{"baseColorFactor", {1, 1, 1, 0.5}}}},
         {"extensions", {{"KHR_materials_unlit", json::object()}}}}};
    const Scene scene = asset.load();
    const Material& glass = scene.materials.at(0);
    EXPECT_EQ(glass.baseColor, vec3(0.1f, 0.2f, 0.3f));
    EXPECT_EQ(glass.alpha, 0.4f);
    EXPECT_EQ(glass.metallic, 0.5f);
    EXPECT_EQ(glass.roughness, 0.25f);
    EXPECT_EQ(glass.transmission, 1.0f);
    EXPECT_EQ(glass.ior, 1.33f);
    EXPECT_FALSE(glass.thin);
    EXPECT_EQ(glass.attenuationColor, vec3(0.5f, 1, 1));
    EXPECT_EQ(glass.attenuationDistance, 5e9f);  // beyond an int
    EXPECT_EQ(glass.emission, vec3(4, 2, 0));
    const Material& plain = scene.materials.at(1);
    EXPECT_EQ(plain.alpha, 1.0f);  // opaque, whatever the factor
    EXPECT_EQ(plain.metallic, 0.0f);
    EXPECT_TRUE(plain.thin);
    EXPECT_TRUE(hasRemark(scene, "unlit"));
}

TEST(Gltf, SparseValuesReplaceThoseBelowThem) {
    GltfAsset asset;
    const int positions = asset.floats({0, 0, 0, 1, 0, 0, 0, 1, 0}, "VEC3");
    asset.json["accessors"][positions]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", asset.view(std::vector<uint16_t>{0, 2})}, {"componentType", 5123}}},
        {"values", {{"bufferView", asset.view(std::vector<float>{7, 8, 9, 4, 5, 6})}}}};
    asset.mesh({{"attributes", {{"POSITION", positions}}}});
    EXPECT_EQ(asset.load().meshes[0].positions, (std::vector<vec3>{{7, 8, 9}, {1, 0, 0}, {4, 5, 6}}));
    asset.json["accessors"][positions].erase("bufferView");  // then all others are zero
    EXPECT_EQ(asset.load().meshes[0].positions, (std::vector<vec3>{{7, 8, 9}, {0, 0, 0}, {4, 5, 6}}));
}

TEST(Gltf, IntegersAreNormalizedAsTheSpecificationSays) {
    GltfAsset asset;
    asset.json["extensionsUsed"] = {"KHR_mesh_quantization"};
    const int positions = asset.accessor(std::vector<int8_t>{-128, 127, 0, -127, 64, 1, 0, 0, 0}, "VEC3", 5120, true);
    const int colors = asset.accessor(std::vector<uint8_t>{255, 0, 51, 255, 0, 0, 0, 255, 0, 0, 0, 255}, "VEC4", 5121, true);
    const int uvs = asset.accessor(std::vector<uint16_t>{65535, 0, 13107, 0, 0, 0}, "VEC2", 5123, true);
    asset.mesh({{"attributes", {{"POSITION", positions}, {"COLOR_0", colors}, {"TEXCOORD_0", uvs}}}});
    const Scene scene = asset.load();
    EXPECT_EQ(scene.meshes[0].positions[0], vec3(-1, 1, 0));
    EXPECT_EQ(scene.meshes[0].positions[1], vec3(-1, 64 / 127.0f, 1 / 127.0f));
    EXPECT_EQ(scene.meshes[0].colors[0], vec3(1, 0, 0.2f));
    EXPECT_EQ(scene.meshes[0].uvs[1], vec2(0.2f, 0));
    asset.json.erase("extensionsUsed");
    EXPECT_THROW(asset.load(), Error);  // only quantized meshes may have integer positions
}

TEST(Gltf, NonFiniteNormalsBecomeZeroAndPositionsAreKept) {
    GltfAsset asset;
    const float nan = std::numeric_limits<float>::quiet_NaN(), inf = std::numeric_limits<float>::infinity();
    const int positions = asset.floats({nan, 0, 0, inf, 0, 0, 0, 1, 0}, "VEC3");
    const int normals = asset.floats({nan, 0, 1, 0, 0, 5, inf, 0, 0}, "VEC3");
    asset.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}});
    const Scene scene = asset.load();
    EXPECT_TRUE(std::isnan(scene.meshes[0].positions[0].x));
    EXPECT_EQ(scene.meshes[0].normals, (std::vector<vec3>{{0, 0, 0}, {0, 0, 1}, {0, 0, 0}}));
}

TEST(Gltf, BuffersMayBeFilesBesideTheScene) {
    const test::TemporaryFolder folder;
    const float corners[9] = {0, 0, 0, 1, 0, 0, 0, 1, 0};
    writeFileAtomically(folder.path / "a b+c.bin", std::as_bytes(std::span(corners)));
    GltfAsset asset;
    asset.json["buffers"] = {{{"uri", "./a%20b+c.bin"}, {"byteLength", 36}}};
    asset.json["bufferViews"] = {{{"buffer", 0}, {"byteLength", 36}}};
    asset.json["accessors"] = {{{"bufferView", 0}, {"componentType", 5126}, {"type", "VEC3"}, {"count", 3}}};
    asset.mesh({{"attributes", {{"POSITION", 0}}}});
    EXPECT_EQ(asset.loadFrom(folder.path).meshes[0].positions[1], vec3(1, 0, 0));
}

}  // namespace
}  // namespace raig
