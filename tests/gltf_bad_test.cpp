// What is wrong with a glTF file is said in one line, or the scene is sound: nothing crashes, hangs, or passes unchecked.
#include "base/error.hpp"
#include "scene/validate.hpp"
#include "support/gltf_asset.hpp"

#include <gtest/gtest.h>

#include <chrono>
#include <functional>
#include <limits>
#include <random>

namespace raig {
namespace {

using nlohmann::json;
using test::GltfAsset;

std::filesystem::path badFolder() {
    return std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes/bad";
}

/// Imports and checks that the outcome is a sound scene or a one-line refusal (returned; empty if it loaded).
std::string importOrRefuse(const std::filesystem::path& path) {
    try {
        const Scene scene = importGltf(path);
        EXPECT_EQ(findFault(scene), std::nullopt);
        return "";
    } catch (const Error& error) {
        const std::string text = error.what();
        EXPECT_EQ(error.exitCode, ExitCode::badInput) << text;
        EXPECT_EQ(text.find('\n'), std::string::npos) << text;
        EXPECT_FALSE(text.empty());
        return text;
    }
}

std::string refusal(const GltfAsset& asset) {
    const test::TemporaryFolder folder;
    writeFileAtomically(folder.path / "asset.glb", asset.glb());
    return importOrRefuse(folder.path / "asset.glb");
}

TEST(BadGltf, EveryBadFileIsRefusedInOneLineOrLoadsSoundly) {
    if (!std::filesystem::exists(badFolder())) GTEST_SKIP() << "no bad files at " << badFolder();
    int count = 0;
    for (const auto& entry : std::filesystem::recursive_directory_iterator(badFolder())) {
        const std::string ending = entry.path().extension();
        if (ending != ".glb" && ending != ".gltf") continue;
        SCOPED_TRACE(entry.path());
        const auto start = std::chrono::steady_clock::now();
        importOrRefuse(entry.path());
        EXPECT_LT(std::chrono::steady_clock::now() - start, std::chrono::seconds(10));
        ++count;
    }
    EXPECT_GE(count, 200);
}

TEST(BadGltf, TheAuthoredFilesAreRefusedForTheirFault) {
    if (!std::filesystem::exists(badFolder())) GTEST_SKIP() << "no bad files at " << badFolder();
    const std::pair<const char*, const char*> cases[] = {
        {"glb_accessor_count_2e30.glb", "#/accessors/0: 1073741824 elements"},
        {"glb_bufferview_offset_wrap.glb", "#/bufferViews/0: reaches from byte 4294967280"},
        {"glb_index_value_oob.glb", "#/meshes/0/primitives/0/indices: index 2 names vertex 60000 of 3"},
        {"glb_json_length_lies.glb", "reaches beyond the end"},
        {"glb_node_cycle.glb", "is a child of node"},
        {"glb_required_unknown_extension.glb", "VENDOR_unknown_required"},
        {"glb_total_length_lies.glb", "says it holds 4294967280 bytes but has 588"},
        {"gltf_bad_base64.gltf", "#/buffers/0: its base64 data"},
        {"gltf_deep_json.gltf", "nested more than"},
        {"gltf_uri_path_traversal.gltf", "outside the scene's folder"},
    };
    for (const auto& [name, part] : cases) {
        const std::string text = importOrRefuse(badFolder() / "authored" / name);
        EXPECT_NE(text.find(part), std::string::npos) << name << ": '" << text << "'";
    }
    EXPECT_EQ(importOrRefuse(badFolder() / "authored/glb_ok_control.glb"), "");
    EXPECT_EQ(importOrRefuse(badFolder() / "authored/glb_zero_matrix.glb"), "");
}

/// An asset that uses most of what the importer reads, to be damaged.
GltfAsset richAsset() {
    GltfAsset asset;
    asset.json["extensionsUsed"] = {"KHR_lights_punctual", "EXT_mesh_gpu_instancing"};
    asset.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "point"}, {"intensity", 2.5}}}}}}};
    asset.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.125}}}}};
    asset.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorFactor", {0.5, 0.25, 0.125, 1}}}},
                                {"extensions",
                                 {{"KHR_materials_ior", {{"ior", 1.5}}},
                                  {"KHR_materials_emissive_strength", {{"emissiveStrength", 2.0}}}}}}};
    const int positions = asset.floats({0, 0, 0, 1, 0, 0, 0, 1, 0, 1, 1, 0}, "VEC3");
    asset.json["accessors"][positions]["sparse"] = {
        {"count", 2},
        {"indices", {{"bufferView", asset.view(std::vector<uint16_t>{1, 3})}, {"componentType", 5123}}},
        {"values", {{"bufferView", asset.view(std::vector<float>{7, 8, 9, 4, 5, 6})}}}};
    const int normals = asset.accessor(std::vector<int8_t>(12, 64), "VEC3", 5120, true);
    const int indices = asset.indices({0, 1, 2, 2, 1, 3});
    const int mesh =
        asset.mesh({{"attributes", {{"POSITION", positions}, {"NORMAL", normals}}}, {"indices", indices}, {"material", 0}});
    const int copies = asset.floats({1, 0, 0, 2, 0, 0}, "VEC3");
    const int leaf =
        asset.node({{"mesh", mesh},
                    {"rotation", {0, 0, 0, 1}},
                    {"scale", {1, 2, 3}},
                    {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", {{"TRANSLATION", copies}}}}}}}});
    const int view = asset.node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
    const int root = asset.node({{"children", {leaf, view}}, {"matrix", {1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0, 7, 8, 9, 1}}});
    asset.json["scenes"] = {{{"nodes", {root}}}};
    asset.json["scene"] = 0;
    return asset;
}

// EXT_mesh_gpu_instancing with what is wrong in it; beside each, what the error names.
TEST(BadGltf, InstancingThatIsNoneIsRefusedAndNamed) {
    const float infinity = std::numeric_limits<float>::infinity();
    const auto refusalOf = [](const std::function<nlohmann::json(GltfAsset&)>& attributesOf) {
        GltfAsset asset;
        const int mesh = asset.triangle();
        const nlohmann::json attributes = attributesOf(asset);
        asset.json["extensionsUsed"] = asset.json["extensionsRequired"] = {"EXT_mesh_gpu_instancing"};
        asset.node({{"mesh", mesh}, {"extensions", {{"EXT_mesh_gpu_instancing", {{"attributes", attributes}}}}}});
        const test::TemporaryFolder folder;
        writeFileAtomically(folder.path / "copies.glb", asset.glb());
        return importOrRefuse(folder.path / "copies.glb");
    };
    const std::string place = "#/nodes/0/extensions/EXT_mesh_gpu_instancing/attributes";
    const auto expect = [&](const std::string& part, const std::function<nlohmann::json(GltfAsset&)>& attributesOf) {
        const std::string text = refusalOf(attributesOf);
        EXPECT_NE(text.find(part), std::string::npos) << "'" << text << "' does not name " << part;
    };
    const std::vector<float> two = {0, 0, 0, 1, 1, 1}, turns = {0, 0, 0, 1, 0, 1, 0, 0};
    EXPECT_EQ(refusalOf([&](GltfAsset& a) -> nlohmann::json {
                  return {{"TRANSLATION", a.floats(two, "VEC3")}, {"ROTATION", a.floats(turns, "VEC4")},
                          {"SCALE", a.floats(two, "VEC3")}, {"_COLOR", a.floats(two, "VEC3")}};
              }),
              "");
    EXPECT_EQ(refusalOf([&](GltfAsset& a) -> nlohmann::json {
                  return {{"ROTATION", a.accessor(std::vector<int16_t>{0, 0, 0, 32767}, "VEC4", 5122, true)}};
              }),
              "");
    expect(place + ": the attributes have 2 and 1 elements", [&](GltfAsset& a) -> nlohmann::json {
        return {{"TRANSLATION", a.floats(two, "VEC3")}, {"SCALE", a.floats({1, 1, 1}, "VEC3")}};
    });
    expect(place + "/TRANSLATION", [&](GltfAsset& a) -> nlohmann::json {
        return {{"TRANSLATION", a.floats(turns, "VEC4")}};
    });
    expect(place + "/TRANSLATION: names accessor 99", [&](GltfAsset&) -> nlohmann::json { return {{"TRANSLATION", 99}}; });
    expect(place + "/SCALE", [&](GltfAsset&) -> nlohmann::json { return {{"SCALE", -1}}; });
    expect(place + "/SCALE", [&](GltfAsset& a) -> nlohmann::json {
        return {{"SCALE", a.accessor(std::vector<uint16_t>{1, 1, 1, 0}, "VEC3", 5123)}};
    });
    expect(place + "/ROTATION", [&](GltfAsset& a) -> nlohmann::json {
        return {{"ROTATION", a.accessor(std::vector<int16_t>{0, 0, 0, 32767}, "VEC4", 5122)}};
    });
    expect("the rotation is zero or not finite",
           [&](GltfAsset& a) -> nlohmann::json { return {{"ROTATION", a.floats({0, 0, 0, 0}, "VEC4")}}; });
    expect("is not finite", [&](GltfAsset& a) -> nlohmann::json {
        return {{"TRANSLATION", a.floats({0, infinity, 0}, "VEC3")}};
    });
    expect("is not finite", [&](GltfAsset& a) -> nlohmann::json {
        return {{"SCALE", a.floats({1, std::numeric_limits<float>::quiet_NaN(), 1}, "VEC3")}};
    });
}

TEST(BadGltf, EveryTruncationOfAGlbIsRefused) {
    const std::vector<std::byte> whole = richAsset().glb();
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path / "cut.glb";
    writeFileAtomically(path, whole);
    ASSERT_EQ(importOrRefuse(path), "");
    for (size_t length = 0; length < whole.size(); ++length) {
        writeFileAtomically(path, std::span(whole).first(length));
        ASSERT_NE(importOrRefuse(path), "") << length << " of " << whole.size() << " bytes";
    }
}

TEST(BadGltf, RandomByteChangesAreRefusedOrLoadSoundly) {
    const std::vector<std::byte> whole = richAsset().glb();
    const test::TemporaryFolder folder;
    const std::filesystem::path path = folder.path / "changed.glb";
    std::mt19937 random(20240607);
    int refused = 0;
    constexpr int rounds = 1000;
    for (int round = 0; round < rounds; ++round) {
        std::vector<std::byte> changed = whole;
        for (uint32_t change = 0; change <= round % 4u; ++change)
            changed[random() % whole.size()] = std::byte(random() & 0xff);
        writeFileAtomically(path, changed);
        SCOPED_TRACE(round);
        refused += !importOrRefuse(path).empty();
    }
    EXPECT_GT(refused, rounds / 4);
    EXPECT_LT(refused, rounds);
}

// Most random bytes only break the syntax. Here it stays whole, and each value in turn is replaced by others.
TEST(BadGltf, AnyValueInTheJsonMayBeAnything) {
    const json values = {-1,   0,    1,    3,   65535,   5125,          2147483648u,   4294967297u,
                         1e18, -0.5, 1e39, "x", nullptr, json::array(), json::object()};
    const json flat = richAsset().json.flatten();
    int refused = 0, rounds = 0;
    for (const auto& [pointer, value] : flat.items()) {
        for (const json& other : values) {
            GltfAsset asset = richAsset();
            asset.json[json::json_pointer(pointer)] = other;
            SCOPED_TRACE(pointer + " = " + other.dump());
            refused += !refusal(asset).empty();
            ++rounds;
        }
    }
    EXPECT_GT(refused, rounds / 4);
}

TEST(BadGltf, WhatIsBrokenIsNamed) {
    const std::tuple<const char*, json, const char*> cases[] = {
        {"/accessors/0/count", 5, "#/accessors/0: 5 elements of 12 bytes"},
        {"/accessors/0/count", uint64_t{1} << 53, "#/accessors/0"},
        {"/accessors/0/count", uint64_t{1} << 63, "#/accessors/0/count"},
        {"/accessors/0/byteOffset", 4, "#/accessors/0"},
        {"/accessors/0/bufferView", 99, "#/accessors/0: names bufferView 99"},
        {"/accessors/0/componentType", 5124, "#/accessors/0: has component type 5124"},
        {"/accessors/0/sparse/count", 3, "#/accessors/0/sparse/indices"},
        {"/accessors/0/sparse/indices/componentType", 5126, "#/accessors/0/sparse/indices"},
        {"/accessors/1/count", 3, "#/meshes/0/primitives/0/attributes/NORMAL: has 3"},
        {"/accessors/2/componentType", 5122, "#/meshes/0/primitives/0/indices"},
        {"/bufferViews/0/byteStride", 8, "#/accessors/0: elements of 12 bytes overlap"},
        {"/bufferViews/0/buffer", 1, "#/bufferViews/0: names buffer 1"},
        {"/meshes/0/primitives/0/mode", 7, "#/meshes/0/primitives/0/mode"},
        {"/meshes/0/primitives/0/material", 1, "#/meshes/0/primitives/0/material"},
        {"/nodes/0/mesh", -1, "#/nodes/0/mesh"},
        {"/nodes/0/children", {2}, "#/scenes/0/nodes"},
        {"/nodes/0/rotation", {0, 0, 0, 0}, "#/nodes/0/rotation"},
        {"/nodes/0/scale", {1, 2}, "#/nodes/0/scale"},
        {"/nodes/2/matrix/3", 1, "#/nodes/2/matrix"},
        {"/nodes/2/matrix/0", 1e308, "#/nodes/0: its transform"},
        {"/cameras/0/perspective/yfov", 0, "#/cameras/0/perspective/yfov"},
        {"/cameras/0/perspective/yfov", 4, "#/cameras/0/perspective/yfov"},
        {"/extensions/KHR_lights_punctual/lights/0/intensity", -1, "/lights/0"},
        {"/extensions/KHR_lights_punctual/lights/0/type", "area\nlight", "area?light"},
        {"/nodes/1/extensions/KHR_lights_punctual/light", 1, "names light 1 of 1"},
        {"/materials/0/extensions/KHR_materials_ior/ior", -1, "#/materials/0/extensions/KHR_materials_ior/ior"},
        {"/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength", -1,
         "#/materials/0/extensions/KHR_materials_emissive_strength/emissiveStrength"},
        {"/scene", 1, "#/scene: names scene 1"},
        {"/asset/version", "1.0", "#/asset/version"},
    };
    for (const auto& [pointer, value, part] : cases) {
        GltfAsset asset = richAsset();
        asset.json[json::json_pointer(pointer)] = value;
        if (std::string(pointer) == "/nodes/2/matrix/0") asset.json["nodes"][0]["scale"] = {1e308, 1, 1};
        const std::string text = refusal(asset);
        EXPECT_NE(text.find(part), std::string::npos) << pointer << " = " << value << ": '" << text << "'";
    }
}

// Products of what is beyond would overflow in the look-up.
TEST(BadGltf, TexturesArePlacedByNumbersThatFloatsCanLookUp) {
    const auto assetWith = [](const json& info, float uv) {
        GltfAsset asset = richAsset();
        asset.json["images"] = {{{"uri", "none.png"}}};
        asset.json["textures"] = {{{"source", 0}}};
        asset.json["materials"][0]["normalTexture"] = info;
        const int uvs = asset.floats(std::vector<float>(8, uv), "VEC2");
        asset.json["meshes"][0]["primitives"][0]["attributes"]["TEXCOORD_0"] = uvs;
        return asset;
    };
    const json strong = {{"index", 0}, {"scale", 1e20}};
    EXPECT_NE(refusal(assetWith(strong, 1.0f)).find("#/materials/0/normalTexture/scale: is beyond"), std::string::npos);
    EXPECT_EQ(refusal(assetWith({{"index", 0}, {"scale", -1e5}}, 1e30f)), "") << "the coordinates count as 0";
}

TEST(BadGltf, CyclesAreFoundOutsideTheSceneToo) {
    GltfAsset asset = richAsset();
    asset.node({{"children", {4}}}), asset.node({{"children", {3}}});
    EXPECT_NE(refusal(asset).find("cycle"), std::string::npos);
}

TEST(BadGltf, UrisStayInTheScenesFolder) {
    for (const std::string uri : {"../a.bin", "/etc/hostname", "x/../../a.bin", "%2e%2e/a.bin", "file:///etc/hostname",
                                  "http://a/b", "a%00b", "a%0Ab", "", "..", "."}) {
        GltfAsset asset;
        asset.json["buffers"] = {{{"uri", uri}, {"byteLength", 1}}};
        EXPECT_NE(refusal(asset).find("asset.glb#/buffers/0: "), std::string::npos) << uri << ": " << refusal(asset);
    }
    GltfAsset asset;
    asset.json["buffers"] = {{{"uri", "absent.bin"}, {"byteLength", 1}}};
    EXPECT_NE(refusal(asset).find("absent.bin"), std::string::npos);
}

TEST(BadGltf, ZeroElementsWithoutBytesAreBounded) {
    GltfAsset asset;
    asset.json["accessors"] = {{{"componentType", 5126}, {"type", "VEC3"}, {"count", 1 << 30}}};
    asset.mesh({{"attributes", {{"POSITION", 0}}}});
    EXPECT_NE(refusal(asset).find("#/accessors/0"), std::string::npos);
}

/// A picture of 8 x 8 texels of 24 bits, in the simplest format there is.
std::vector<std::byte> smallBmp() {
    std::vector<std::byte> file;
    const auto put = [&](uint32_t value, int size) {
        for (int i = 0; i < size; ++i) file.push_back(static_cast<std::byte>(value >> 8 * i & 0xff));
    };
    put(0x4d42, 2), put(54 + 192, 4), put(0, 4), put(54, 4);             // file header
    put(40, 4), put(8, 4), put(8, 4), put(1, 2), put(24, 2), put(0, 4);  // size, width, height, planes, bits, compression
    for (const uint32_t word : {192u, 0u, 0u, 0u, 0u}) put(word, 4);
    for (uint32_t i = 0; i < 192; ++i) put(i, 1);
    return file;
}

TEST(DecodeImage, RandomBytesAreRefusedOrDecoded) {
    std::vector<std::vector<std::byte>> pictures{smallBmp()};
    const std::filesystem::path samples = badFolder() / "../gltf/VertexColorTest";
    if (std::filesystem::exists(samples))
        for (const auto& entry : std::filesystem::directory_iterator(samples))
            if (entry.path().extension() == ".png") pictures.push_back(readFile(entry.path()));
    std::mt19937 random(5);
    for (const std::vector<std::byte>& whole : pictures) {
        ASSERT_GT(decodeImage(whole, "whole").width, 0u);
        for (int round = 0; round < 200; ++round) {
            std::vector<std::byte> changed(whole.begin(),
                                           whole.begin() + (round % 2 ? whole.size() : random() % whole.size()));
            for (int change = 0; change < 3 && !changed.empty(); ++change)
                changed[random() % changed.size()] = std::byte(random() & 0xff);
            try {
                const Texels texels = decodeImage(changed, "changed");
                EXPECT_EQ(texels.rgba.size(), size_t{texels.width} * texels.height * 4);
            } catch (const Error& error) {
                EXPECT_TRUE(std::string(error.what()).starts_with("changed: "));
            }
        }
    }
}

TEST(DecodeImage, TexelsAreRgbaFromTheTop) {
    const Texels texels = decodeImage(smallBmp(), "bmp");
    ASSERT_EQ(texels.width, 8u);
    ASSERT_EQ(texels.height, 8u);
    // Stored from the bottom row, blue first: the top left texel is bytes 168, 169, 170.
    EXPECT_EQ((std::vector<uint8_t>(texels.rgba.begin(), texels.rgba.begin() + 4)),
              (std::vector<uint8_t>{170, 169, 168, 255}));
}

}  // namespace
}  // namespace raig
