/// MTL's map_d: a surface's opacity by a picture, which becomes the alpha of its colour texture.
#include "scene/surface.hpp"
#include "support/mtl_files.hpp"

namespace raig {
namespace {

using namespace test;

/// The texels of the material's colour texture.
std::vector<Texel> colorsOf(const Scene& scene) {
    std::vector<Texel> texels;
    if (!scene.materials.at(0).baseColorTexture) return texels;
    const std::vector<uint8_t>& rgba = scene.images.at(scene.materials[0].baseColorTexture->image).rgba;
    for (size_t i = 0; i < rgba.size(); i += 4) texels.push_back({rgba[i], rgba[i + 1], rgba[i + 2], rgba[i + 3]});
    return texels;
}

const File leaf{"leaf.tga", tga(2, 1, {red, {0, 255, 0, 77}})};
const File shape{"shape.tga", tga(2, 1, {white, grey})};

TEST(MtlOpacity, BecomesTheAlphaOfTheColorPicture) {
    const Scene scene = load("map_Kd leaf.tga\nmap_d shape.tga\nd 0.5\n", {leaf, shape});
    const Material& m = scene.materials.at(0);
    EXPECT_EQ(colorsOf(scene), (std::vector<Texel>{{255, 0, 0, 255}, {0, 255, 0, 128}}));
    EXPECT_TRUE(m.alphaVaries);
    EXPECT_EQ(m.alpha, 0.5f);
    EXPECT_EQ(m.alphaCutoff, 0.0f);
    EXPECT_EQ(m.transmission, 0.0f) << "d < 1 makes no glass under a map";
    EXPECT_EQ(scene.images.size(), 1u) << "only what is looked up";
    EXPECT_TRUE(mayLetPass(scene, m));
}

TEST(MtlOpacity, WithoutAColorPictureIsThatOfAWhiteOne) {
    const Scene scene = load("map_d -clamp on -s 2 2 shape.tga\n", {shape});
    EXPECT_EQ(colorsOf(scene), (std::vector<Texel>{{255, 255, 255, 255}, {255, 255, 255, 128}}));
    EXPECT_EQ(scene.materials.at(0).baseColor, vec3(0.8f));
    EXPECT_EQ(scene.materials.at(0).baseColorTexture->wrapU, Wrap::clamp);
    EXPECT_EQ(scene.materials.at(0).baseColorTexture->u.x, 2.0f);
}

TEST(MtlOpacity, OfTheColorPictureItselfIsNoCopy) {
    for (const char* map_d : {"map_d leaf.tga\n", "map_d -imfchan m leaf.tga\n", "map_d ./x/../leaf.tga\n"}) {
        const Scene scene = load("map_Kd leaf.tga\n" + std::string(map_d), {leaf});
        EXPECT_EQ(scene.images.size(), 1u);
        EXPECT_EQ(colorsOf(scene).at(1), (Texel{0, 255, 0, 77}));
        EXPECT_TRUE(scene.materials.at(0).alphaVaries);
    }
}

TEST(MtlOpacity, OfTheColorPictureMayBeItsLuminance) {
    const Scene asked = load("map_Kd leaf.tga\nmap_d -imfchan l leaf.tga\n", {leaf});
    EXPECT_EQ(colorsOf(asked), (std::vector<Texel>{{255, 0, 0, 54}, {0, 255, 0, 182}}));
    const Scene noAlpha = load("map_Kd shape.tga\nmap_d shape.tga\n", {shape});
    EXPECT_EQ(colorsOf(noAlpha), (std::vector<Texel>{{255, 255, 255, 255}, {128, 128, 128, 128}}));
    EXPECT_TRUE(noAlpha.materials.at(0).alphaVaries);
}

TEST(MtlOpacity, IsTheChannelThatTheOptionNames) {
    const File file{"c.tga", tga(1, 1, {{200, 100, 50, 10}})};
    const File opaque{"c.tga", tga(1, 1, {{200, 100, 50, 255}})};
    const auto alphaBy = [](const std::string& option, const File& f) {
        return colorsOf(load("map_d " + option + " c.tga\n", {f})).at(0)[3];
    };
    EXPECT_EQ(alphaBy("-imfchan r", file), 200);
    EXPECT_EQ(alphaBy("-imfchan g", file), 100);
    EXPECT_EQ(alphaBy("-imfchan b", file), 50);
    EXPECT_EQ(alphaBy("-imfchan m", file), 10);
    EXPECT_EQ(alphaBy("-imfchan l", file), 117) << "0.2126 200 + 0.7152 100 + 0.0722 50";
    EXPECT_EQ(alphaBy("", file), 10) << "there is some alpha";
    EXPECT_EQ(alphaBy("", opaque), 117) << "there is none";
    EXPECT_EQ(alphaBy("-imfchan z", opaque), 117);
}

TEST(MtlOpacity, ThatIsWholeChangesNothing) {
    const File full{"full.tga", tga(1, 1, {white})};
    const Scene scene = load("map_Kd leaf.tga\nmap_d full.tga\n", {leaf, full});
    EXPECT_FALSE(scene.materials.at(0).alphaVaries);
    EXPECT_EQ(scene.images.size(), 1u);
    EXPECT_FALSE(mayLetPass(scene, scene.materials[0])) << "map_Kd's own alpha does not count";
    EXPECT_FALSE(load("map_d full.tga\n", {full}).materials.at(0).baseColorTexture);
}

TEST(MtlOpacity, SizesAreBroughtToTheLongerSides) {
    const Scene scene = load("map_Kd wide.tga\nmap_d high.tga\n",
                             {{"wide.tga", tga(4, 1, {red, black, white, grey})}, {"high.tga", tga(1, 2, {black, white})}});
    const Texels& image = scene.images.at(scene.materials.at(0).baseColorTexture.value().image);
    EXPECT_EQ(image.width, 4u);
    EXPECT_EQ(image.height, 2u);
    EXPECT_EQ(colorsOf(scene), (std::vector<Texel>{{255, 0, 0, 0},
                                                   {0, 0, 0, 0},
                                                   {255, 255, 255, 0},
                                                   {128, 128, 128, 0},
                                                   {255, 0, 0, 255},
                                                   {0, 0, 0, 255},
                                                   {255, 255, 255, 255},
                                                   {128, 128, 128, 255}}));
    const Scene finer = load("map_Kd small.tga\nmap_d large.tga\n", {{"small.tga", tga(2, 1, {black, white})},
                                                                     {"large.tga", tga(4, 1, {grey, black, white, grey})}});
    EXPECT_EQ(colorsOf(finer),
              (std::vector<Texel>{{0, 0, 0, 128}, {137, 137, 137, 0}, {225, 225, 225, 255}, {255, 255, 255, 128}}))
        << "a quarter and three quarters of white, as light";
}

TEST(MtlOpacity, IsPlacedAsTheColorIs) {
    const Scene scene = load("map_Kd -s 2 2 leaf.tga\nmap_d -clamp on shape.tga\n", {leaf, shape});
    EXPECT_EQ(scene.materials.at(0).baseColorTexture->u.x, 2.0f);
    EXPECT_EQ(scene.materials.at(0).baseColorTexture->wrapU, Wrap::repeat);
    EXPECT_TRUE(hasRemark(scene, "map_d is placed as map_Kd is"));
    EXPECT_TRUE(load("map_Kd -s 2 2 leaf.tga\nmap_d -s 2 2 shape.tga\n", {leaf, shape}).remarks.empty());
}

TEST(MtlOpacity, StandsBesideWhatCannotBeRead) {
    const Scene noColor = load("map_Kd none.tga\nmap_d shape.tga\n", {shape});
    EXPECT_EQ(colorsOf(noColor).at(1), (Texel{255, 255, 255, 128}));
    EXPECT_TRUE(hasRemark(noColor, "none.tga"));
    const Scene noOpacity = load("map_Kd leaf.tga\nmap_d none.tga\nd 0.25\n", {leaf});
    EXPECT_EQ(noOpacity.materials.at(0).baseColorTexture, Texture{});
    EXPECT_FALSE(noOpacity.materials.at(0).alphaVaries);
    EXPECT_EQ(noOpacity.materials.at(0).alpha, 0.25f);
    EXPECT_TRUE(hasRemark(noOpacity, "none.tga"));
    EXPECT_TRUE(hasRemark(load("map_d ../shape.tga\n", {}), "outside"));
}

// Two files of some kilobytes could ask for 2^28 texels.
TEST(MtlOpacity, IsLeftOutWhereItsPicturesWouldBeHuge) {
    const std::vector<Texel> line(16384, grey);
    const Scene scene =
        load("map_Kd w.tga\nmap_d h.tga\n", {{"w.tga", tga(16384, 1, line)}, {"h.tga", tga(1, 16384, line)}});
    EXPECT_TRUE(hasRemark(scene, "texels in all"));
    ASSERT_EQ(scene.images.size(), 1u);
    EXPECT_EQ(scene.images[0].width, 16384u);
    EXPECT_FALSE(scene.materials.at(0).alphaVaries);
}

TEST(MtlOpacity, LeavesGlassAsItIs) {
    const Scene scene = load("illum 7\nTf 1 1 1\nNi 1.5\nd 0.5\nmap_d shape.tga\n", {shape});
    EXPECT_EQ(scene.materials.at(0).transmission, 1.0f);
    EXPECT_FALSE(scene.materials.at(0).alphaVaries);
    EXPECT_EQ(scene.materials.at(0).alpha, 1.0f);
    EXPECT_TRUE(hasRemark(scene, "map_d is left out"));
}

// Each is a picture of its own, however many materials ask for it.
TEST(MtlOpacity, PairsOfPicturesAreJoinedOnce) {
    const Folder folder;
    folder.write(leaf.name, leaf.content);
    folder.write(shape.name, shape.content);
    folder.write("m.mtl",
                 "newmtl a\nmap_Kd leaf.tga\nmap_d shape.tga\nnewmtl b\nmap_d shape.tga\nmap_Kd leaf.tga\n"
                 "newmtl c\nmap_Kd leaf.tga\nnewmtl d\nmap_Kd shape.tga\nmap_d leaf.tga\n");
    const Scene scene = importObj(
        folder.write("s.obj",
                     "mtllib m.mtl\nv 0 0 0\nv 1 0 0\nv 0 1 0\nusemtl a\nf 1 2 3\nusemtl b\nf 1 2 3\nusemtl c\nf 1 2 3\n"
                     "usemtl d\nf 1 2 3\n"));
    EXPECT_EQ(findFault(scene), std::nullopt);
    EXPECT_EQ(scene.images.size(), 3u);
    EXPECT_EQ(scene.materials.at(0).baseColorTexture, scene.materials.at(1).baseColorTexture);
    EXPECT_NE(scene.materials.at(0).baseColorTexture, scene.materials.at(2).baseColorTexture);
    EXPECT_FALSE(scene.materials.at(2).alphaVaries);
    EXPECT_EQ(scene.images.at(scene.materials.at(3).baseColorTexture->image).rgba[7], 77);
}

}  // namespace
}  // namespace raig
