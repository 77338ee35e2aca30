/// MTL's maps: which of a material's textures each becomes, and where it is looked up.
#include "reference/world.hpp"
#include "scene/geometry.hpp"
#include "support/mtl_files.hpp"

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

TEST(MtlOptions, WithMalformedNumbersLeaveTheMapOutWithItsLine) {
    for (const char* options : {"-o nan", "-s 1 inf", "-o x", "-s 3e38 3e38 -o 0 3e38", "-o 1 2 3 -s", "-bm x"}) {
        const Scene scene = load("map_Kd " + std::string(options) + " i.tga\n", {{"i.tga", tga(1, 1, {red})}});
        EXPECT_TRUE(hasRemark(scene, "m.mtl:2: ")) << options;
        EXPECT_FALSE(scene.materials.at(0).baseColorTexture) << options;
    }
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

TEST(MtlEmission, IsNoneWhereKeIsBlackOrThePictureIsMissing) {
    const Scene dark = load("Ke 0 0 0\nmap_Ke e.tga\n", {{"e.tga", tga(1, 1, {red})}});
    EXPECT_EQ(dark.materials.at(0).emission, vec3(0.0f));
    EXPECT_TRUE(dark.images.empty()) << "what no ray can see is not read";
    const Scene missing = load("map_Ke e.tga\n", {});
    EXPECT_EQ(missing.materials.at(0).emission, vec3(0.0f));
    EXPECT_TRUE(hasRemark(missing, "e.tga"));
    EXPECT_EQ(load("Ke 5 5 5\nmap_Ke e.tga\n", {}).materials.at(0).emission, vec3(5.0f)) << "as far as it is known";
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

TEST(Mtl, OtherMapsAreLeftOutWithOneRemark) {
    const Scene scene =
        load("map_Ka a.tga\nmap_Ks a.tga\nmap_bump b.tga\nbump b.tga\nmap_aat on\nrefl -type sphere r.tga\n", {});
    ASSERT_EQ(scene.remarks.size(), 1u);
    EXPECT_TRUE(hasRemark(scene, "left out: map_Bump, map_Ks, refl"));
}

}  // namespace
}  // namespace raig
