// What is seen, as the command line asks for it: views and parts, and what is refused in one line.
#include "image/image.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>

namespace raig {
namespace {

const std::string box = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";

class ViewCommand : public testing::Test {
protected:
    std::string pathOf(const std::string& name) { return folder.write(name, "").string(); }

    /// The picture that `raig render` writes of `scene`, in 40 x 30.
    Image picture(const std::string& scene, std::vector<std::string> arguments) {
        const std::string file = pathOf("picture.pfm");
        const std::vector<std::string> all{"render", scene, "-o",       file,  "--size", "40x30",
                                           "--spp",  "1",   "--device", "cpu", "--quiet"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        const ProgramResult result = runProgram(RAIG_PROGRAM, arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return readPicture(file);
    }
    void expectRefused(const std::string& scene, std::vector<std::string> arguments, const std::string& mentions) {
        const std::vector<std::string> all{"render", scene, "-o", pathOf("refused.png"), "--device", "cpu", "--quiet"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        const ProgramResult result = runProgram(RAIG_PROGRAM, arguments);
        EXPECT_EQ(result.exitCode, 2) << mentions;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    }

    const Folder folder;
};

TEST_F(ViewCommand, TheCamerasOwnNumbersGiveItsOwnPicture) {
    const Image own = picture(box, {});
    const Image given = picture(box, {"--eye", "278,273,-800", "--at", "278,273,0", "--up", "0,1,0"});
    EXPECT_EQ(given.pixels, own.pixels);
    EXPECT_NE(picture(box, {"--eye", "278,273,-900"}).pixels, own.pixels);
    EXPECT_NE(picture(box, {"--eye=-278,273,-800"}).pixels, own.pixels) << "numbers may be negative";
    EXPECT_NE(picture(box, {"--at", "-278,273,0"}).pixels, own.pixels) << "in a word of their own, too";
    EXPECT_NE(picture(box, {"--fov", "60"}).pixels, own.pixels);
}

TEST_F(ViewCommand, UpsideDownIsTheSamePictureTurned) {
    const Image own = picture(box, {}), turned = picture(box, {"--up", "0,-1,0"});
    size_t same = 0;
    for (size_t i = 0; i < own.pixels.size(); ++i)
        same += glm::length(own.pixels[i] - turned.pixels[own.pixels.size() - 1 - i]) < 0.2f;
    EXPECT_GT(same, own.pixels.size() * 9 / 10) << "but for noise of the lamp, and edges";
}

// A scene of one square that faces +z, without camera or light.
TEST_F(ViewCommand, TheHeadlightShinesWhereTheCameraLooks) {
    const std::string square = folder.write("square.obj", "v -1 -1 0\nv 1 -1 0\nv 1 1 0\nv -1 1 0\nf 1 2 3 4\n").string();
    const Image front = picture(square, {"--eye", "0,0,3"}), back = picture(square, {"--eye", "0,0,-3"});
    EXPECT_GT(front.at(20, 15).x, 0.5f);
    EXPECT_EQ(front.at(20, 15), back.at(20, 15)) << "it looks at the middle of the scene from both sides";
}

TEST_F(ViewCommand, APartHasTheBitsOfTheWhole) {
    const Image whole = picture(box, {}), part = picture(box, {"--crop", "9,4,21,13"});
    ASSERT_EQ(part.width, 21u);
    ASSERT_EQ(part.height, 13u);
    for (uint32_t y = 0; y < 13; ++y)
        for (uint32_t x = 0; x < 21; ++x) EXPECT_EQ(part.at(x, y), whole.at(9 + x, 4 + y));
}

TEST_F(ViewCommand, APictureWithoutASizeHasTheShapeThatTheCameraAsksFor) {
    auto file = nlohmann::json::parse(std::ifstream(box));
    const auto sizeOf = [&](const nlohmann::json& aspect) {
        file["cameras"][0]["perspective"]["aspectRatio"] = aspect;
        const std::string scene = folder.write("shaped.gltf", file.dump()).string();
        const ProgramResult result = runProgram(RAIG_PROGRAM, {"render", scene, "-o", pathOf("shaped.pfm"), "--device",
                                                               "cpu", "--spp", "1", "--max-depth", "0", "--json"});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const auto json = nlohmann::json::parse(result.output);
        return std::pair(json["width"].get<int>(), json["height"].get<int>());
    };
    EXPECT_EQ(sizeOf(1.0), std::pair(512, 512));
    EXPECT_EQ(sizeOf(4.0), std::pair(1024, 256));
    EXPECT_EQ(sizeOf(16.0 / 9.0), std::pair(683, 384));
    EXPECT_EQ(sizeOf(1e-12), std::pair(1, 65536));
    const std::string wide = pathOf("shaped.gltf");
    file["cameras"][0]["perspective"]["aspectRatio"] = 4.0;
    folder.write("shaped.gltf", file.dump());
    expectRefused(wide, {"--crop", "0,0,8,257"}, "is not in the picture, which has 1024 x 256 pixels");
    const ProgramResult part =
        runProgram(RAIG_PROGRAM, {"render", wide, "-o", pathOf("part.pfm"), "--device", "cpu", "--crop", "1000,200,24,56"});
    EXPECT_EQ(part.exitCode, 0) << part.errors;
}

TEST_F(ViewCommand, CompareTakesViewsAndParts) {
    const ProgramResult result =
        runProgram(RAIG_PROGRAM, {"compare", box, "--size", "64x64", "--crop", "20,10,24,30", "--eye", "300,200,-700",
                                  "--at", "278,273,0", "--fov", "50", "--device", "cpu", "--quiet", "--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const auto json = nlohmann::json::parse(result.output);
    EXPECT_EQ(json["crop"], (nlohmann::json{{"x", 20}, {"y", 10}, {"width", 24}, {"height", 30}}));
    EXPECT_EQ(json["pixels"]["compared"], 24 * 30);
    EXPECT_EQ(json["families"]["camera"]["rays"], 24 * 30);
}

TEST_F(ViewCommand, TheReferenceHasTheSameLens) {
    const std::string spheres = RAIG_SOURCE_DIR "/assets/cornell_spheres.gltf";
    const ProgramResult result =
        runProgram(RAIG_PROGRAM, {"compare", spheres, "--size", "48x48", "--spp", "8", "--aperture", "60", "--focus", "950",
                                  "--quiet", "--json", "--fail-above", "rmse=3e-6", "--fail-above", "max=3e-4"});
    EXPECT_EQ(result.exitCode, 0) << result.errors << result.output;
    EXPECT_EQ(nlohmann::json::parse(result.output)["hits"]["wrong"], 0);
}

TEST_F(ViewCommand, FocusIsOnWhatTheCameraLooksAtUnlessGiven) {
    const Image sharp = picture(box, {}), given = picture(box, {"--aperture", "50", "--focus", "1080"});
    EXPECT_NE(given.pixels, sharp.pixels);
    EXPECT_EQ(picture(box, {"--aperture", "50", "--at", "278,273,280"}).pixels, given.pixels);
    EXPECT_EQ(picture(box, {"--aperture", "0"}).pixels, sharp.pixels);
    expectRefused(box, {"--aperture", "50"}, "looks at no point in particular");
    expectRefused(box, {"--focus", "50"}, "--aperture");
    expectRefused(box, {"--aperture", "50", "--focus", "1e-9"}, "a million times");
    for (const char* value : {"-1", "nan", "inf", "2e18", "wide"})
        expectRefused(box, {std::string("--aperture=") + value}, "the lens's diameter");
    for (const char* value : {"0", "-1", "nan", "near"})
        expectRefused(box, {"--aperture", "1", std::string("--focus=") + value}, "a distance above 0");
    EXPECT_EQ(picture(box, {"--aperture", "1", "--focus", "inf"}).width, 40u);
}

TEST_F(ViewCommand, WhatCannotBeSeenIsRefusedInOneLine) {
    for (const char* value : {"1,2", "1,2,3,4", "1,2,x", "1, 2,3", "nan,0,0", "inf,0,0", "1e19,0,0", "1;2;3", ","})
        for (const std::string option : {"--eye", "--at", "--up"}) expectRefused(box, {option + "=" + value}, "X,Y,Z");
    for (const char* value : {"0", "-30", "180", "179.999999", "nan", "1e-50", "45deg"})
        expectRefused(box, {std::string("--fov=") + value}, "--fov");
    for (const char* value : {"0,0,0,1", "0,0,1,0", "1,2,3", "1,2,3,4,5", "-1,0,1,1", "0.5,0,1,1", "4294967296,0,1,1"})
        expectRefused(box, {std::string("--crop=") + value}, "X,Y,WIDTH,HEIGHT");
    for (const char* value : {"0,0,513,1", "0,512,1,1", "4294967295,0,2,1"})
        expectRefused(box, {std::string("--crop=") + value}, "512 x 512");
    expectRefused(box, {"--eye", "1,2,3", "--at", "1,2,3"}, "is where the camera stands");
    expectRefused(box, {"--at", "278,273,-800"}, "is where the camera stands");
    expectRefused(box, {"--eye", "0,5,0", "--at", "0,0,0", "--up", "0,2,0"}, "looks along it");
    expectRefused(box, {"--up", "0,0,1"}, "looks along it");
    expectRefused(box, {"--up", "0,0,0"}, "no direction");
    const std::string parallel = folder
                                     .write("parallel.gltf", R"({"asset": {"version": "2.0"}, "scene": 0,
        "scenes": [{"nodes": [0]}], "nodes": [{"camera": 0}], "cameras": [{"type": "orthographic", "name": "plan",
        "orthographic": {"xmag": 1, "ymag": 1, "znear": 0, "zfar": 9}}]})")
                                     .string();
    expectRefused(parallel, {"--fov", "40"}, "--fov: the camera plan is orthographic");
    EXPECT_EQ(picture(parallel, {"--eye", "1,2,3", "--at", "0,0,0"}).width, 40u);
}

}  // namespace
}  // namespace raig
