/// MTL's maps: which of a material's textures each becomes, and where it is looked up.
#include "reference/world.hpp"
#include "scene/geometry.hpp"
#include "support/mtl_files.hpp"

#include <random>

namespace raig {
namespace {

using namespace test;

/// Where an OBJ file's texture coordinates are looked up, as a file counts them: from the bottom.
vec2 lookedUp(const Texture& texture, const vec2& objUv) {
    const vec3 uv(objUv.x, 1.0f - objUv.y, 1.0f);
    return {glm::dot(texture.u, uv), 1.0f - glm::dot(texture.v, uv)};
}

// ---- Options -----------------------------------------------------------------------------------------------------------

TEST(MtlOptions, ScaleAndOffsetCountAsTheFileCounts) {
    struct Case {
        std::string options;
        vec2 scale, offset;
    };
    for (const Case& c : {Case{"-s 2 3 1 -o 0.25 0.5 9", {2.0f, 3.0f}, {0.25f, 0.5f}},
                          Case{"-o -0.25 0.125 -texres 64 -s -4 0.5", {-4.0f, 0.5f}, {-0.25f, 0.125f}},
                          Case{"-s 2", {2.0f, 1.0f}, {0.0f, 0.0f}}, Case{"-o 0.5", {1.0f, 1.0f}, {0.5f, 0.0f}}}) {
        const Scene scene = load("map_Kd " + c.options + " i.tga\n", {{"i.tga", tga(1, 1, {red})}});
        ASSERT_TRUE(scene.materials.at(0).baseColorTexture) << c.options;
        for (const vec2 uv : {vec2(0.0f, 0.0f), vec2(1.0f, 0.0f), vec2(0.25f, 0.75f), vec2(-2.0f, 5.0f)})
            EXPECT_EQ(lookedUp(*scene.materials[0].baseColorTexture, uv), c.scale * uv + c.offset) << c.options;
    }
}

TEST(MtlOptions, ThoseThatChangeNothingLeaveAPlainTexture) {
    for (const char* options : {"", "-s 1 1 1 -o 0 0 0 ", "-t 3 2 1 -boost 2 ", "-o -0 -0 "}) {
        const Scene scene = load("map_Kd " + std::string(options) + "i.tga\n", {{"i.tga", tga(1, 1, {red})}});
        EXPECT_EQ(scene.materials.at(0).baseColorTexture, Texture{}) << options;
    }
}

TEST(MtlOptions, OfOtherKindsAreSkipped) {
    const Scene scene =
        load("map_Kd -type sphere -texres 512 -cc on -mm 0 1 -imfchan z -unknown 3 i.tga\n", {{"i.tga", tga(1, 1, {red})}});
    EXPECT_EQ(scene.materials.at(0).baseColorTexture, Texture{});
    EXPECT_TRUE(scene.remarks.empty());
}

TEST(MtlOptions, WithMalformedOrAbsurdNumbersLeaveTheMapOutWithItsLine) {
    for (const char* options : {"-o nan", "-s 1 inf", "-o x", "-s 3e38", "-o 0 1e9", "-o 1 2 3 -s", "-bm x", "-bm 1e20"}) {
        const Scene scene = load("map_Kd " + std::string(options) + " i.tga\n", {{"i.tga", tga(1, 1, {red})}});
        EXPECT_TRUE(hasRemark(scene, "m.mtl:2: ")) << options;
        EXPECT_FALSE(scene.materials.at(0).baseColorTexture) << options;
    }
}

TEST(MtlOptions, WithoutAFileLeaveTheMapOutWithItsLine) {
    for (const char* map : {"map_Kd", "map_Ke -clamp", "map_d -clamp on", "map_d -imfchan i.tga", "norm --",
                            "map_Kd -clamp i.tga", "map_d -imfchan q i.tga"}) {
        const Scene scene = load(std::string(map) + "\n", {{"i.tga", tga(1, 1, {red})}});
        EXPECT_TRUE(hasRemark(scene, "m.mtl:2: ")) << map;
        EXPECT_TRUE(scene.images.empty()) << map;
    }
}

TEST(MtlOptions, GoOnOverLinesThatABackslashJoins) {
    const Scene scene = load("map_Kd -s 2 \\\n 3 \\\r\n i.tga\n", {{"i.tga", tga(1, 1, {red})}});
    ASSERT_TRUE(scene.materials.at(0).baseColorTexture);
    EXPECT_EQ(scene.materials[0].baseColorTexture->v.y, 3.0f);
    EXPECT_TRUE(scene.remarks.empty());
}

// ---- map_Ke ------------------------------------------------------------------------------------------------------------

TEST(MtlEmission, IsThePictureTimesKe) {
    const std::vector<File> files{{"e.tga", tga(1, 1, {red})}};
    const Material plain = load("map_Ke -clamp on e.tga\n", files).materials.at(0);
    EXPECT_EQ(plain.emission, vec3(1.0f));
    EXPECT_EQ(plain.emissionTexture, (Texture{0, Wrap::clamp, Wrap::clamp}));
    EXPECT_FALSE(plain.baseColorTexture);
    EXPECT_EQ(plain.baseColor, vec3(0.8f));
    EXPECT_EQ(load("Ke 2 3 4\nmap_Ke e.tga\n", files).materials.at(0).emission, vec3(2, 3, 4));
}

TEST(MtlEmission, IsNoneWhereKeIsBlack) {
    const Scene dark = load("Ke 0 0 0\nmap_Ke e.tga\n", {{"e.tga", tga(1, 1, {red})}});
    EXPECT_EQ(dark.materials.at(0).emission, vec3(0.0f));
    EXPECT_TRUE(dark.images.empty()) << "what no ray can see is not read";
}

TEST(MtlEmission, IsKeWhereThePictureIsMissing) {
    const Scene missing = load("map_Ke e.tga\n", {});
    EXPECT_EQ(missing.materials.at(0).emission, vec3(0.0f)) << "none is stated";
    EXPECT_TRUE(hasRemark(missing, "e.tga"));
    EXPECT_EQ(load("Ke 5 5 5\nmap_Ke e.tga\n", {}).materials.at(0).emission, vec3(5.0f));
}

TEST(MtlEmission, SharesItsImageWithMapKd) {
    const Scene scene = load("map_Kd e.tga\nmap_Ke -s 2 e.tga\n", {{"e.tga", tga(1, 1, {red})}});
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.materials.at(0).baseColorTexture, Texture{});
    EXPECT_EQ(scene.materials.at(0).emissionTexture->u.x, 2.0f);
}

// ---- norm --------------------------------------------------------------------------------------------------------------

TEST(MtlNormals, AreThePicturesTimesTheirStrength) {
    const Scene scene = load("norm -bm 3 -s 2 2 n.tga\n", {{"n.tga", tga(1, 1, {grey})}});
    const Material& m = scene.materials.at(0);
    ASSERT_TRUE(m.normalTexture);
    EXPECT_EQ(m.normalTexture->v, vec3(0.0f, 2.0f, -1.0f));
    EXPECT_EQ(m.normalScale, 3.0f);
    EXPECT_FALSE(m.baseColorTexture || m.emissionTexture || m.roughnessTexture);
    EXPECT_FALSE(load("norm n.tga\n", {}).materials.at(0).normalTexture);
}

/// Where the first triangle's normal points at its middle, as the normal texture has it.
dvec3 bentNormal(const Scene& scene) {
    const Geometry geometry = flatten(scene);
    const reference::World world(scene, geometry);
    const reference::Ray ray{dvec3(0.25, 0.25, 1.0), dvec3(0.0, 0.0, -1.0)};
    return reference::surfaceAt(world, ray, reference::Hit{1.0, 0.25, 0.25, 0}, 0.0).shadingNormal;
}

// Red is along the file's u and green along its v, which counts upwards.
TEST(MtlNormals, RedLeansAlongUAndGreenAlongV) {
    const auto normalBy = [](const Texel& texel) {
        return bentNormal(load("norm n.tga\n", {{"n.tga", tga(1, 1, {texel})}}));
    };
    EXPECT_GT(normalBy({218, 128, 218, 255}).x, 0.6);
    EXPECT_GT(normalBy({128, 218, 218, 255}).y, 0.6);
    EXPECT_LT(normalBy({128, 37, 218, 255}).y, -0.6);
}

TEST(MtlNormals, AreThoseOfMapBumpWhereItShowsSome) {
    const Texel up{128, 128, 255, 255}, aside{218, 128, 218, 255};
    std::vector<Texel> mostly(10, up);
    mostly[3] = black;
    for (const char* key : {"map_Bump", "map_bump", "bump"}) {
        const Scene scene = load(std::string(key) + " -bm 0.5 n.tga\n", {{"n.tga", tga(10, 1, mostly)}});
        EXPECT_EQ(scene.materials.at(0).normalTexture, Texture{}) << key;
        EXPECT_EQ(scene.materials.at(0).normalScale, 0.5f);
        EXPECT_TRUE(scene.remarks.empty());
    }
    const File normals{"n.tga", tga(1, 1, {aside})}, other{"b.tga", tga(1, 1, {up})};
    const Scene both = load("map_Bump -bm 7 b.tga\nnorm n.tga\n", {normals, other});
    EXPECT_EQ(both.materials.at(0).normalScale, 1.0f);
    ASSERT_EQ(both.images.size(), 1u);
    EXPECT_EQ(both.images[0].rgba[0], 218);
}

TEST(MtlNormals, AreNoHeights) {
    const Texel up{128, 128, 255, 255}, light{201, 201, 201, 255}, below{128, 128, 1, 255}, blue{0, 0, 255, 255};
    std::vector<Texel> half(10, up);
    half[3] = half[4] = grey;
    for (const std::vector<Texel>& texels : {std::vector<Texel>(10, grey), std::vector<Texel>(10, light), half,
                                             std::vector<Texel>(10, below), std::vector<Texel>(10, blue)}) {
        const Scene scene = load("map_Bump b.tga\n", {{"b.tga", tga(10, 1, texels)}});
        EXPECT_FALSE(scene.materials.at(0).normalTexture) << int{texels[0][0]};
        EXPECT_TRUE(scene.images.empty());
        EXPECT_TRUE(hasRemark(scene, "left out: map_Bump of heights"));
    }
}

TEST(Mtl, OtherMapsAreLeftOutWithOneRemark) {
    const Scene scene =
        load("map_Ka a.tga\nmap_Ks a.tga\nmap_ns b.tga\nmap_Ns b.tga\nmap_aat on\nrefl -type sphere r.tga\n", {});
    ASSERT_EQ(scene.remarks.size(), 1u);
    EXPECT_TRUE(hasRemark(scene, "left out: map_Ks, map_Ns, refl"));
}

// Each scene is checked as it is loaded.
TEST(Mtl, AnyMapsLeaveTheSceneValid) {
    const std::vector<std::string> starts{"map_Kd", "map_Ke", "map_d", "norm", "map_Bump", "bump", "map_Ks", "d", "Ke"},
        options{"", "-s 2 -3", "-o 2e8 -2e8", "-s 0 0 0", "-clamp on", "-imfchan l", "-imfchan m", "-bm -2", "-o", "0.5"},
        pictures{"a.tga", "b.tga", "c.tga", "broken.tga", "none.tga", "../a.tga", ""};
    const std::vector<File> files{{"a.tga", tga(3, 2, std::vector<Texel>(6, {128, 128, 255, 9}))},
                                  {"b.tga", tga(1, 5, std::vector<Texel>(5, grey))},
                                  {"c.tga", tga(1, 1, {white})},
                                  {"broken.tga", tga(4, 4, {white}).substr(0, 17)}};
    std::mt19937 random(5);
    const auto any = [&](const std::vector<std::string>& of) { return of[random() % of.size()]; };
    size_t cut = 0, bumpy = 0, glowing = 0;
    for (int round = 0; round < 1000; ++round) {
        std::string statements;
        for (int i = 0; i < 5; ++i) statements += any(starts) + " " + any(options) + " " + any(pictures) + "\n";
        const Material m = load(statements, files).materials.at(0);
        ASSERT_FALSE(HasFailure()) << statements;
        cut += m.alphaVaries;
        bumpy += m.normalTexture.has_value();
        glowing += m.emissionTexture.has_value();
    }
    EXPECT_TRUE(cut > 50 && bumpy > 50 && glowing > 50) << cut << ", " << bumpy << ", " << glowing;
}

}  // namespace
}  // namespace raig
