// How a picture is sampled, as the command line asks for it: what is told of it, and what is refused in one line.
#include "image/image.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <chrono>
#include <cmath>
#include <fstream>
#include <iterator>

namespace raig {
namespace {

const std::string box = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";

class SamplingCommand : public testing::Test {
protected:
    ProgramResult render(const std::string& output, std::vector<std::string> arguments) const {
        const std::vector<std::string> all{"render", box, "-o", output, "--size", "40x30", "--exposure", "0",
                                           "--device", "cpu"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }
    /// The document of a run that went well, and its picture.
    nlohmann::json document(std::vector<std::string> arguments, Image& image) const {
        const std::string file = folder.write("picture.pfm", "").string();
        arguments.push_back("--json");
        const ProgramResult result = render(file, arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        image = readPicture(file);
        return nlohmann::json::parse(result.output);
    }
    void expectRefused(const std::vector<std::string>& arguments, const std::string& mentions) const {
        const ProgramResult result = render(folder.write("refused.png", "").string(), arguments);
        EXPECT_EQ(result.exitCode, 2) << mentions;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    }

    const Folder folder;
};

TEST_F(SamplingCommand, AdaptiveTellsWhatItSpentAndWhatIsUnsettled) {
    Image adaptive, uniform;
    const auto told = document({"--adaptive", "0.05", "--spp", "64"}, adaptive);
    EXPECT_EQ(told["samples"], 64);
    EXPECT_EQ(told["tolerance"], 0.05);
    EXPECT_EQ(told["samples_a_pixel"]["min"], 8);
    EXPECT_EQ(told["samples_a_pixel"]["max"], 64);
    EXPECT_GT(told["samples_a_pixel"]["mean"], 8.0);
    EXPECT_LT(told["samples_a_pixel"]["mean"], 32.0);
    EXPECT_GT(told["unsettled_pixels"], 0) << "the lamp's edges";
    EXPECT_EQ(told["closest_rays"], std::llround(told["samples_a_pixel"]["mean"].get<double>() * 40 * 30))
        << "one a sample, as nothing reflects";
    const auto all = document({"--spp", "8"}, uniform);
    EXPECT_EQ(all["samples_a_pixel"], (nlohmann::json{{"min", 8}, {"mean", 8.0}, {"max", 8}}));
    EXPECT_FALSE(all.contains("tolerance"));
    EXPECT_NE(adaptive.pixels, uniform.pixels);
    document({"--adaptive", "1e6"}, adaptive);
    EXPECT_EQ(adaptive.pixels, uniform.pixels) << "whoever asks for nothing gets the first samples";
}

// Few samples do where light comes from points; soft light, or a lens, gets as many as it needs.
TEST_F(SamplingCommand, WithNothingSaidSamplesAreAsManyAsLightAsksFor) {
    Image usual, given;
    const auto soft = document({}, usual);
    EXPECT_EQ(soft["tolerance"], 0.03);
    EXPECT_EQ(soft["samples"], 64);
    document({"--adaptive", "0.03", "--spp", "64"}, given);
    EXPECT_EQ(usual.pixels, given.pixels);
    EXPECT_EQ(document({"--spp", "4"}, given)["samples_a_pixel"]["mean"], 4.0);
    EXPECT_FALSE(document({"--time", "0.5"}, given).contains("tolerance"));

    const auto mesh = folder.write("mesh.obj", "v 0 0 0\nv 1 0 0\nv 0 1 0\nf 1 2 3\n").string();
    const auto documentOf = [&](std::vector<std::string> arguments) {
        const std::vector<std::string> all{"render", mesh,       "-o",  folder.write("mesh.pfm", "").string(),
                                           "--size", "8x8", "--json", "--device", "cpu", "--quiet"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        return nlohmann::json::parse(runProgram(RAIG_PROGRAM, arguments).output);
    };
    EXPECT_EQ(documentOf({})["samples"], 4) << "a headlight";
    EXPECT_FALSE(documentOf({}).contains("tolerance"));
    EXPECT_EQ(documentOf({"--aperture", "0.1"})["tolerance"], 0.03);
}

TEST_F(SamplingCommand, TheFileSaysHowItWasMade) {
    const std::string file = folder.write("picture.png", "").string();
    const ProgramResult result = render(file, {"--adaptive", "0.05", "--spp", "64", "--seed", "3"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_NE(result.errors.find("tolerance 0.05, at most 64"), std::string::npos) << result.errors;
    std::ifstream stream(file, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(stream), {}};
    EXPECT_NE(bytes.find("seed 3; tolerance 0.05, at most 64"), std::string::npos);
}

TEST_F(SamplingCommand, TheMapOfSamplesIsAView) {
    Image map, uniform;
    const auto told = document({"--adaptive", "0.05", "--spp", "64", "--view", "samples"}, map);
    EXPECT_EQ(told["view"], (nlohmann::json{{"name", "samples"}, {"min", 8.0}, {"max", 64.0}}));
    EXPECT_NE(map.at(20, 4), map.at(20, 15)) << "the lamp's edge, and the wall";
    EXPECT_EQ(document({"--spp", "3", "--view", "samples"}, uniform)["view"]["max"], 3.0);
    EXPECT_EQ(uniform.at(20, 4), uniform.at(20, 15));
}

TEST_F(SamplingCommand, TimeIsKeptAndTellsHowToMakeThePictureAgain) {
    Image timed, again;
    const auto start = std::chrono::steady_clock::now();
    const auto told = document({"--time", "1"}, timed);
    const double seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    EXPECT_GE(told["samples"], 1);
    EXPECT_LT(seconds, 20.0) << "with much for a busy machine";
    document({"--spp", std::to_string(told["samples"].get<int>())}, again);
    EXPECT_EQ(timed.pixels, again.pixels);
    const auto soft = document({"--time", "1000", "--adaptive", "0.05", "--spp", "64"}, timed);
    EXPECT_EQ(soft["samples"], 64);
    document({"--adaptive", "0.05", "--spp", "64"}, again);
    EXPECT_EQ(timed.pixels, again.pixels);
}

TEST_F(SamplingCommand, TheReferenceHasTheSameFilters) {
    for (const char* filter : {"tent", "gauss"}) {
        const ProgramResult result = runProgram(
            RAIG_PROGRAM, {"compare", RAIG_SOURCE_DIR "/assets/cornell_spheres.gltf", "--size", "32x32", "--spp", "8",
                           "--filter", filter, "--quiet", "--json", "--fail-above", "rmse=1e-5"});
        EXPECT_EQ(result.exitCode, 0) << result.errors << result.output;
    }
    Image own, given;
    EXPECT_EQ(document({"--filter", "gauss"}, own)["filter"], "gauss");
    EXPECT_EQ(document({}, given)["filter"], "box");
    EXPECT_NE(own.pixels, given.pixels);
    expectRefused({"--filter", "sinc"}, "box, tent or gauss");
}

TEST_F(SamplingCommand, WhatCannotBeIsRefusedInOneLine) {
    for (const char* value : {"0", "-1", "nan", "inf", "1e-400", "fine", "0.01x", "1/100"})
        expectRefused({std::string("--adaptive=") + value}, "an error above 0");
    for (const char* value : {"0", "-1", "nan", "inf", "1e7", "soon"})
        expectRefused({std::string("--time=") + value}, "seconds above 0");
    expectRefused({"--adaptive", "0.01", "--spp", "7"}, "8 or more");
}

}  // namespace
}  // namespace raig
