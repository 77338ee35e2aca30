// Scenes that move, as the command line asks for them: a moment, an animation, and one picture a frame.
#include "image/image.hpp"
#include "support/mesh_files.hpp"
#include "support/moving_assets.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

using test::GltfAsset;

class AnimationCommand : public testing::Test {
protected:
    AnimationCommand() {
        writeFileAtomically(scene, test::bendingBar().glb());
        GltfAsset far;
        far.json["extensionsUsed"] = {"KHR_lights_punctual"};
        far.json["extensions"] = {{"KHR_lights_punctual", {{"lights", {{{"type", "directional"}}}}}}};
        far.json["cameras"] = {{{"type", "perspective"}, {"perspective", {{"yfov", 0.75}, {"znear", 0.125}}}}};
        far.node({{"mesh", far.triangle()}});
        const int view = far.node({{"camera", 0}, {"extensions", {{"KHR_lights_punctual", {{"light", 0}}}}}});
        test::animate(far, 0, view, "translation", {0, 1}, {0, 0, 2, 0, 0, 4}, "VEC3");
        writeFileAtomically(cameraMoves, far.glb());
    }
    ProgramResult run(std::vector<std::string> arguments) {
        const std::vector<std::string> more{"--device", "cpu", "--quiet"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }
    std::vector<std::byte> picture(const std::string& of, std::vector<std::string> arguments) {
        const std::string file = (folder.path / "picture.pfm").string();
        arguments.insert(arguments.begin(), {"render", of, "-o", file, "--size", "24x24", "--spp", "1"});
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return readFile(file);
    }
    void expectRefused(const std::vector<std::string>& arguments, const std::string& mentions) {
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.exitCode, 2) << mentions;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    }

    const test::TemporaryFolder folder;
    const std::string scene = (folder.path / "bar.glb").string();
    const std::string cameraMoves = (folder.path / "view.glb").string();
    const std::string out = (folder.path / "out.pfm").string();
};

TEST_F(AnimationCommand, AMomentIsShownAndTheRestPoseWithoutOne) {
    const auto rest = picture(scene, {}), start = picture(scene, {"--time-at", "0"});
    const auto middle = picture(scene, {"--time-at", "1"}), end = picture(scene, {"--time-at", "2"});
    EXPECT_EQ(rest, start) << "the bar is straight in both";
    EXPECT_NE(start, middle);
    EXPECT_NE(middle, end);
    EXPECT_EQ(end, picture(scene, {"--time-at", "77", "--animation", "bend"}));
    EXPECT_EQ(start, picture(scene, {"--time-at=-1"}));
}

TEST_F(AnimationCommand, FramesAreThePicturesOfTheirMoments) {
    const std::vector<std::string> view = {"--eye", "0.2,1,4", "--at", "0.2,1,0"};
    const auto with = [&](std::vector<std::string> more) {
        more.insert(more.end(), view.begin(), view.end());
        return more;
    };
    const ProgramResult result = run(with({"render", scene, "-o", out, "--size", "24x24", "--spp", "1", "--frames", "2:4",
                                           "--fps", "2", "--json", "--aov", "depth"}));
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const nlohmann::json frames = nlohmann::json::parse(result.output).at("frames");
    ASSERT_EQ(frames.size(), 3u);
    for (int k = 0; k < 3; ++k) {
        const std::string number = "000" + std::to_string(2 + k);
        EXPECT_EQ(frames[k]["time"], 1.0 + 0.5 * k);
        EXPECT_EQ(frames[k]["output"], (folder.path / ("out." + number + ".pfm")).string());
        EXPECT_EQ(readFile(folder.path / ("out." + number + ".pfm")),
                  picture(scene, with({"--time-at", std::to_string(1.0 + 0.5 * k)})))
            << number;
        EXPECT_TRUE(std::filesystem::exists(folder.path / ("out." + number + ".depth.exr")));
    }
    EXPECT_FALSE(std::filesystem::exists(out));
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out.0005.pfm"));
}

// Its structure is kept; only what is seen of it changes.
TEST_F(AnimationCommand, ACameraMayMoveAloneThroughFrames) {
    const ProgramResult result =
        run({"render", cameraMoves, "-o", out, "--size", "24x24", "--spp", "1", "--frames", "0:1", "--fps", "1"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_EQ(readFile(folder.path / "out.0000.pfm"), picture(cameraMoves, {"--time-at", "0"}));
    EXPECT_EQ(readFile(folder.path / "out.0001.pfm"), picture(cameraMoves, {"--time-at", "1"}));
    EXPECT_NE(readFile(folder.path / "out.0000.pfm"), readFile(folder.path / "out.0001.pfm"));
}

TEST_F(AnimationCommand, InfoTellsWhatCanBePlayedAndMeasuresTheMoment) {
    const auto boundsAt = [&](const std::vector<std::string>& more) {
        std::vector<std::string> arguments{"info", scene, "--json"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        const ProgramResult result = run(arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const nlohmann::json told = nlohmann::json::parse(result.output)["scene"];
        EXPECT_EQ(told["animations"], nlohmann::json::parse(R"([{"name": "bend", "seconds": 2.0}])"));
        return told["bounds"].dump();
    };
    EXPECT_EQ(boundsAt({}), boundsAt({"--time-at", "0"}));
    EXPECT_NE(boundsAt({}), boundsAt({"--time-at", "2"}));
}

TEST_F(AnimationCommand, WhatCannotBeIsRefusedInOneLine) {
    const std::string still = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";
    const Folder files;
    const std::string mesh = files.write("a.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").string();
    expectRefused({"render", scene, "-o", out, "--time-at", "nan"}, "--time-at nan");
    expectRefused({"render", scene, "-o", out, "--time-at", "1s"}, "--time-at 1s");
    expectRefused({"render", scene, "-o", out, "--animation", "bend"}, "--animation bend: at which moment");
    expectRefused({"render", scene, "-o", out, "--time-at", "0", "--animation", "walk"}, "it has: 0 bend");
    expectRefused({"render", still, "-o", out, "--time-at", "0"}, "has no animation");
    expectRefused({"render", mesh, "-o", out, "--time-at", "0"}, "has no animation");
    expectRefused({"render", mesh, "-o", out, "--frames", "0:1"}, "has no animation");
    for (const char* const frames : {"3", "3:2", "0:1000000", "-1:2", "0:", ":", "a:b", "0:1:2"})
        expectRefused({"render", scene, "-o", out, std::string("--frames=") + frames}, "FIRST:LAST is wanted");
    expectRefused({"render", scene, "-o", out, "--fps", "24"}, "--frames");
    expectRefused({"render", scene, "-o", out, "--frames", "0:1", "--fps", "0"}, "--fps 0");
    expectRefused({"render", scene, "-o", out, "--frames", "0:1", "--time-at", "1"}, "leave --time-at out");
    expectRefused({"render", scene, "-o", out, "--frames", "0:1", "--save-structure", out + ".s"}, "--save-structure");
    expectRefused({"info", scene, "--animation", "0"}, "at which moment");
}

// Nobody should wait for a hundred frames to learn that the last has no place.
TEST_F(AnimationCommand, AFrameWithoutAPlaceIsToldOfBeforeTheFirst) {
    std::filesystem::create_directory(folder.path / "out.0003.pfm");
    const ProgramResult result = run({"render", scene, "-o", out, "--size", "8x8", "--frames", "2:3"});
    EXPECT_EQ(result.exitCode, 3);
    EXPECT_NE(result.errors.find("out.0003.pfm: cannot be written: it is a folder"), std::string::npos) << result.errors;
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out.0002.pfm"));
    std::filesystem::create_directory(folder.path / "out.0001.depth.exr");
    const ProgramResult beside =
        run({"render", scene, "-o", out, "--size", "8x8", "--frames", "0:1", "--aov", "depth"});
    EXPECT_NE(beside.errors.find("out.0001.depth.exr: cannot be written"), std::string::npos) << beside.errors;
    EXPECT_FALSE(std::filesystem::exists(folder.path / "out.0000.pfm"));
}

}  // namespace
}  // namespace raig
