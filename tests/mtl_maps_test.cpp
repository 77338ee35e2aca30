/// MTL's maps: which of a material's textures each becomes, and where it is looked up.
#include "scene/import.hpp"
#include "scene/obj.hpp"
#include "scene/validate.hpp"
#include "support/mesh_files.hpp"

namespace raig {
namespace {

/// Red, green, blue, alpha.
using Texel = std::array<uint8_t, 4>;

/// A TGA file, row by row from the top.
std::string tga(uint8_t width, uint8_t height, const std::vector<Texel>& texels) {
    std::string bytes{0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, static_cast<char>(width), 0, static_cast<char>(height), 0, 32, 0x28};
    for (const Texel& t : texels)
        for (const uint8_t byte : {t[2], t[1], t[0], t[3]}) bytes += static_cast<char>(byte);
    return bytes;
}

const Texel red{255, 0, 0, 255}, grey{128, 128, 128, 255}, black{0, 0, 0, 255}, white{255, 255, 255, 255};

struct File {
    std::string name, content;
};

/// A triangle of material m, as these statements make it, beside these files.
Scene load(const std::string& statements, const std::vector<File>& files) {
    const Folder folder;
    folder.write("m.mtl", "newmtl m\n" + statements);
    for (const File& file : files) folder.write(file.name, file.content);
    const Scene scene = importObj(folder.write(
        "s.obj", "mtllib m.mtl\nusemtl m\nv 0 0 0\nv 1 0 0\nv 0 1 0\nvt 0 0\nvt 1 0\nvt 0 1\nf 1/1 2/2 3/3\n"));
    EXPECT_EQ(findFault(scene), std::nullopt);
    return scene;
}

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

TEST(MtlOptions, WithMalformedNumbersLeaveTheMapOutWithItsLine) {
    for (const char* options : {"-o nan", "-s 1 inf", "-o x", "-s 3e38 3e38 -o 0 3e38", "-o 1 2 3 -s"}) {
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

}  // namespace
}  // namespace raig
