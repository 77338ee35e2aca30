// Integrators, as the command line asks for them: what is told of them, and what is refused in one line.
#include "image/image.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

namespace raig {
namespace {

const std::string box = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";

class IntegratorCommand : public testing::Test {
protected:
    ProgramResult run(const std::string& command, std::vector<std::string> arguments) const {
        const std::vector<std::string> all{command, box, "--size", "24x24", "--device", "cpu"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }
    /// The document of a run that went well.
    nlohmann::json document(const std::string& command, std::vector<std::string> arguments) const {
        arguments.push_back("--json");
        const ProgramResult result = run(command, arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return nlohmann::json::parse(result.output);
    }
    std::string picture(const std::string& name) const { return folder.write(name, "").string(); }

    const Folder folder;
};

TEST_F(IntegratorCommand, OfAmbientOcclusionTellsHowFarItLooks) {
    const std::string out = picture("out.pfm"), whitted = picture("whitted.pfm");
    const auto told = document("render", {"-o", out, "--integrator", "ao", "--spp", "4"});
    EXPECT_EQ(told["integrator"], "ao");
    const double distance = told["ao_distance"];  // a quarter of the picture's height in the box, or a little before it
    EXPECT_GT(distance, 0.25 * 540.0);
    EXPECT_LT(distance, 0.25 * 970.0);
    EXPECT_EQ(document("render", {"-o", out, "--integrator", "ao", "--crop", "3,4,5,6"})["ao_distance"], distance);
    const auto far = document("render", {"-o", out, "--integrator", "ao", "--ao-distance", "inf"});
    EXPECT_TRUE(far["ao_distance"].is_null());
    const auto usual = document("render", {"-o", whitted});
    EXPECT_EQ(usual["integrator"], "whitted");
    EXPECT_FALSE(usual.contains("ao_distance"));
    EXPECT_NE(readPicture(out).pixels, readPicture(whitted).pixels);
}

TEST_F(IntegratorCommand, IsTheReferencesToo) {
    for (const char* integrator : {"path", "ao"}) {
        const auto told = document("compare", {"--integrator", integrator, "--spp", "2"});
        EXPECT_EQ(told["integrator"], integrator);
        EXPECT_LT(told["pixels"]["max"], 1e-3);
    }
}

TEST_F(IntegratorCommand, OfPathsBringsLightThatIsReflected) {
    const std::string out = picture("out.pfm"), direct = picture("direct.pfm");
    const auto told = document("render", {"-o", out, "--integrator", "path", "--spp", "8"});
    EXPECT_EQ(told["integrator"], "path");
    EXPECT_GT(told["deepest"], 3);
    document("render", {"-o", direct, "--integrator", "path", "--spp", "8", "--max-depth", "0"});
    double all = 0.0, some = 0.0;
    for (const vec3& c : readPicture(out).pixels) all += c.y;
    for (const vec3& c : readPicture(direct).pixels) some += c.y;
    EXPECT_GT(all, 1.2 * some);
}

TEST_F(IntegratorCommand, WhatCannotBeIsRefusedInOneLine) {
    const auto expectRefused = [&](const std::vector<std::string>& arguments, const std::string& mentions) {
        std::vector<std::string> all{"-o", picture("refused.png")};
        all.insert(all.end(), arguments.begin(), arguments.end());
        const ProgramResult result = run("render", all);
        EXPECT_EQ(result.exitCode, 2) << mentions;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    };
    expectRefused({"--integrator", "bidirectional"}, "one of whitted, path, ao is wanted");
    for (const char* value : {"0", "-1", "nan", "near", "1e-60", "2m"})
        expectRefused({"--integrator", "ao", std::string("--ao-distance=") + value}, "a distance above 0");
    expectRefused({"--ao-distance", "3"}, "is for --integrator ao");
}

}  // namespace
}  // namespace raig
