// What glTF's textures become: images stored once, wraps, sets of coordinates and transforms.
#include "base/error.hpp"
#include "support/gltf_asset.hpp"
#include "support/mesh_files.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using nlohmann::json;
using test::GltfAsset;

// A PNG of two texels: red, and (0, 128, 0).
const std::string twoTexels =
    "data:image/"
    "png;base64,iVBORw0KGgoAAAANSUhEUgAAAAIAAAABCAYAAAD0In+KAAAAEUlEQVR42mP4z8Dwn6GB4T8AD3sDfumzMzcAAAAASUVORK5CYII=";

TEST(GltfTextures, TexturesAreStoredOnceWithTheirWrapModes) {
    GltfAsset asset;
    asset.json["images"] = {{{"uri", twoTexels}}};
    asset.json["samplers"] = {{{"wrapS", 33071}, {"wrapT", 33648}}};
    asset.json["textures"] = {{{"source", 0}, {"sampler", 0}}, {{"source", 0}}};
    const json first = {{"index", 0}, {"texCoord", 1}};
    const json second = {{"index", 1},
                         {"extensions", {{"KHR_texture_transform", {{"offset", {10, 20}}, {"scale", {2, 3}}}}}}};
    asset.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", first}}}},
                               {{"pbrMetallicRoughness", {{"baseColorTexture", second}}}}};
    const int positions = asset.floats(std::vector<float>(9, 0.0f), "VEC3");
    const int uvs0 = asset.floats({.1f, .2f, .3f, .4f, .5f, .6f}, "VEC2");
    const int uvs1 = asset.floats({1, 2, 3, 4, 5, 6}, "VEC2");
    for (int material = 0; material < 2; ++material)
        asset.mesh(
            {{"attributes", {{"POSITION", positions}, {"TEXCOORD_0", uvs0}, {"TEXCOORD_1", uvs1}}}, {"material", material}});
    const Scene scene = asset.load();
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.images[0].width, 2u);
    EXPECT_EQ(scene.images[0].rgba, (std::vector<uint8_t>{255, 0, 0, 255, 0, 128, 0, 255}));
    ASSERT_TRUE(scene.materials[0].baseColorTexture && scene.materials[1].baseColorTexture);
    EXPECT_EQ(scene.materials[0].baseColorTexture->wrapU, Wrap::clamp);
    EXPECT_EQ(scene.materials[0].baseColorTexture->wrapV, Wrap::mirror);
    EXPECT_EQ(scene.materials[1].baseColorTexture->wrapU, Wrap::repeat);
    EXPECT_EQ(scene.meshes[0].uvs[1], vec2(3, 4));
    EXPECT_EQ(scene.meshes[1].uvs[0], vec2(.1f, .2f));
    EXPECT_EQ(scene.materials[1].baseColorTexture->u, vec3(2, 0, 10));
    EXPECT_EQ(scene.materials[1].baseColorTexture->v, vec3(0, 3, 20));
}

TEST(GltfTextures, EachTextureKeepsItsTransformAndSetOfCoordinates) {
    GltfAsset asset;
    asset.json["images"] = {{{"uri", twoTexels}}};
    asset.json["textures"] = {{{"source", 0}}};
    const auto info = [](int set) { return json{{"index", 0}, {"texCoord", set}}; };
    json turned = info(7);
    turned["extensions"]["KHR_texture_transform"] = {{"rotation", 1.5707963267948966}, {"texCoord", 5}};
    json normal = info(2);
    normal["scale"] = 0.5;
    json occlusion = info(2);
    occlusion["strength"] = 0.25;
    asset.json["materials"] = {{{"emissiveFactor", {1, 2, 1}},
                                {"emissiveTexture", info(5)},
                                {"normalTexture", normal},
                                {"occlusionTexture", occlusion},
                                {"pbrMetallicRoughness", {{"metallicRoughnessTexture", turned}}}},
                               {{"pbrMetallicRoughness", {{"baseColorTexture", info(0)}}}, {"normalTexture", info(1)},
                                {"occlusionTexture", info(2)}}};
    const int positions = asset.floats(std::vector<float>(9, 0.0f), "VEC3");
    const int uvs2 = asset.floats({.1f, .2f, .3f, .4f, .5f, .6f}, "VEC2");
    const int uvs5 = asset.floats({1, 2, 3, 4, 5, 6}, "VEC2");
    const int tangents = asset.floats({3, 0, 0, 1, 0, 2, 0, -1, 0, 0, 0, 1}, "VEC4");
    asset.mesh({{"attributes",
                 {{"POSITION", positions}, {"TEXCOORD_2", uvs2}, {"TEXCOORD_5", uvs5}, {"TANGENT", tangents}}},
                {"material", 0}});
    const Scene scene = asset.load();
    const Material& m = scene.materials[0];
    ASSERT_TRUE(m.roughnessTexture && m.normalTexture && m.emissionTexture && m.occlusionTexture);
    EXPECT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(m.roughnessTexture->set, 0u) << "the first to be asked for";
    EXPECT_EQ(m.emissionTexture->set, 0u);
    EXPECT_EQ(m.normalTexture->set, 1u);
    EXPECT_EQ(m.occlusionTexture->set, 1u);
    EXPECT_EQ(scene.meshes[0].uvs[1], vec2(3, 4));
    EXPECT_EQ(scene.meshes[0].moreUvs[1], vec2(.3f, .4f));
    EXPECT_NEAR(glm::length(m.roughnessTexture->u - vec3(0, 1, 0)), 0.0, 1e-6);
    EXPECT_NEAR(glm::length(m.roughnessTexture->v - vec3(-1, 0, 0)), 0.0, 1e-6);
    EXPECT_EQ(m.emissionTexture->u, vec3(1, 0, 0));
    EXPECT_EQ(m.normalScale, 0.5f);
    EXPECT_EQ(m.occlusionStrength, 0.25f);
    EXPECT_EQ(scene.meshes[0].tangents, (std::vector<vec4>{{1, 0, 0, 1}, {0, 1, 0, -1}, {0, 0, 0, 0}}));
    EXPECT_TRUE(scene.materials[1].normalTexture && !scene.materials[1].occlusionTexture);
    EXPECT_TRUE(hasRemark(scene, "two sets"));
}

TEST(GltfTextures, ATransformBeyondWhatFloatsCanLookUpIsRefused) {
    for (const char* number : {"offset", "scale"}) {
        GltfAsset asset;
        asset.json["images"] = {{{"uri", twoTexels}}};
        asset.json["textures"] = {{{"source", 0}}};
        const json info = {{"index", 0}, {"extensions", {{"KHR_texture_transform", {{number, {1, 1e10}}}}}}};
        asset.json["materials"] = {{{"pbrMetallicRoughness", {{"baseColorTexture", info}}}}};
        try {
            asset.load();
            ADD_FAILURE() << number << " is taken";
        } catch (const Error& error) {
            EXPECT_NE(std::string(error.what()).find("/baseColorTexture: its texture transform"), std::string::npos);
        }
    }
}

TEST(GltfTextures, AnImageThatCannotBeUsedIsOnlyARemark) {
    for (const std::string uri : {"absent.png", "../outside.png", "data:image/png;base64,AAAA", "data:image/webp,junk"}) {
        GltfAsset asset;
        asset.json["images"] = {{{"uri", uri}}};
        asset.json["textures"] = {{{"source", 0}}, json::object()};
        for (int texture = 0; texture < 2; ++texture)
            asset.json["materials"].push_back({{"pbrMetallicRoughness", {{"baseColorTexture", {{"index", texture}}}}}});
        const Scene scene = asset.load();
        EXPECT_FALSE(scene.materials[0].baseColorTexture);
        EXPECT_FALSE(scene.materials[1].baseColorTexture);
        EXPECT_TRUE(hasRemark(scene, "a texture is left out")) << uri;
    }
}

}  // namespace
}  // namespace raig
