// The program as a person or a script meets it: exit codes, one line for each error, nothing else on standard output.
#include "support/program.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <string>
#include <vector>

namespace raig {

namespace {

using Arguments = std::vector<std::string>;

ProgramResult raig(const Arguments& arguments) { return runProgram(RAIG_PROGRAM, arguments); }

std::string joined(const Arguments& arguments) {
    std::string text = "raig";
    for (const std::string& argument : arguments) text += " '" + argument + "'";
    return text;
}

/// One line that says "raig: error:", no more on either stream.
void expectError(const Arguments& arguments, int exitCode, const std::string& mentions) {
    SCOPED_TRACE(joined(arguments));
    const ProgramResult result = raig(arguments);
    EXPECT_EQ(result.exitCode, exitCode) << result.errors;
    EXPECT_EQ(result.output, "");
    EXPECT_TRUE(result.errors.starts_with("raig: error: ")) << result.errors;
    EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
}

TEST(CommandLine, HelpNamesEveryCommandAndEveryCommandHasHelpWithExamples) {
    const ProgramResult help = raig({"--help"});
    EXPECT_EQ(help.exitCode, 0);
    EXPECT_EQ(help.errors, "");
    for (const std::string command : {"render", "trace", "compare", "bench", "stress", "info", "devices"}) {
        EXPECT_NE(help.output.find("\n  " + command + " "), std::string::npos) << command;
        const ProgramResult own = raig({command, "--help"});
        EXPECT_EQ(own.exitCode, 0) << command;
        EXPECT_EQ(own.errors, "") << command;
        EXPECT_NE(own.output.find("raig " + command), std::string::npos) << own.output;
        EXPECT_NE(own.output.find("\nExamples:\n  raig " + command), std::string::npos) << own.output;
        EXPECT_NE(own.output.find("--device"), std::string::npos) << own.output;
    }
}

TEST(CommandLine, NoFileIsReplacedThatIsReadOrWrittenToo) {
    const std::string scene = std::string(RAIG_SOURCE_DIR) + "/assets/cornell_box.gltf";
    expectError({"trace", scene, "--rays", "r.npy", "--hits", "./r.npy"}, 2, "would be read and replaced");
    expectError({"trace", scene, "--rays", "r.npy", "--hits", scene}, 2, "would be read and replaced");
    expectError({"render", scene, "-o", "a.png", "--save-structure", "a.png"}, 2, "would be written twice");
    expectError({"render", scene, "-o", "a.png", "--load-structure", "a.png"}, 2, "would be read and replaced");
    expectError({"compare", "a.png", "b.png", "-o", "b.png"}, 2, "would be read and replaced");
}

TEST(CommandLine, AnEmptyValueIsAnError) {
    const std::string scene = std::string(RAIG_SOURCE_DIR) + "/assets/cornell_box.gltf";
    expectError({"render", scene, "-o", "a.png", "--load-structure", ""}, 2, "--load-structure: the value is empty");
    expectError({"render", scene, "-o", "a.png", "--camera="}, 2, "--camera");
    expectError({"render", "", "-o", "a.png"}, 2, "the value is empty");
    expectError({"bench", scene, "--save-structure", "a.structure"}, 2, "--save-structure");
}

TEST(CommandLine, VersionIsOneLine) {
    const ProgramResult result = raig({"--version"});
    EXPECT_EQ(result.exitCode, 0);
    EXPECT_EQ(result.errors, "");
    EXPECT_TRUE(result.output.starts_with("raig ")) << result.output;
    EXPECT_EQ(result.output.find('\n'), result.output.size() - 1) << result.output;
}

TEST(CommandLine, WrongCommandsAreUsageErrorsThatNameTheRightOnes) {
    expectError({}, 2, "render, trace, compare, bench, chart, stress, info and devices");
    expectError({"paint"}, 2, "no command paint");
    expectError({"paint", "x", "--y"}, 2, "render, trace, compare, bench, chart, stress, info and devices");
    expectError({"--colour"}, 2, "--help");
    expectError({"ren\nder"}, 2, "no command");
}

TEST(CommandLine, MissingAndUnknownArgumentsAreUsageErrorsThatPointToHelp) {
    expectError({"render"}, 2, "raig render --help");
    expectError({"render", "x.glb"}, 2, "--output");
    expectError({"render", "x.glb", "y.glb", "-o", "a.png"}, 2, "y.glb");
    expectError({"render", "x.glb", "-o", "a.png", "--colour"}, 2, "--colour");
    expectError({"render", "x.glb", "-o", "a.png", "--spp"}, 2, "--spp");
    expectError({"render", "x.glb", "-o", "a.png", "--spp", "1", "--spp", "2"}, 2, "--spp");
    expectError({"trace", "x.glb", "--rays", "r.npy"}, 2, "--hits");
    expectError({"compare"}, 2, "raig compare --help");
    expectError({"compare", "a.png", "b.png", "c.png"}, 2, "c.png");
    expectError({"devices", "x"}, 2, "raig devices --help");
    expectError({"render", "", "-o", "a.png"}, 2, "empty");
}

/// An option of `render` with values that it must refuse.
struct Refused {
    std::string option;
    std::vector<std::string> values;
    std::string allowed;
};

TEST(CommandLine, NumbersAreTakenWholeAndInRangeOrNotAtAll) {
    const std::string whole = "a whole number from ";
    const std::vector<Refused> table = {
        {"--size", {"0x0", "0x5", "5x0", "5", "x", "5x", "x5", "5x5x5", "-5x5", "65537x1", "5.5x5", " 5x5", "5X5"},
         "WIDTHxHEIGHT"},
        {"--spp", {"-1", "0", "1.5", "1e3", "0x10", "+4", " 4", "4 ", "four", "65537", "99999999999999999999"}, whole + "1"},
        {"--max-depth", {"-1", "65", "8.0", "nan"}, whole + "0 to 64"},
        {"--min-contribution",
         {"nan", "inf", "-inf", "-0.5", "1.5", "1/0", "0/0", "1/", "/512", "1/2/3", "1 / 2", "2/1", "x"},
         "1/512"},
        {"--seed", {"-1", "4294967296", "0.5"}, whole + "0 to 4294967295"},
        {"--threads", {"-1", "1025", "two"}, whole + "0 to 1024"},
        {"--max-leaf", {"0", "-3", "256"}, whole + "1"},
    };
    for (const Refused& refused : table)
        for (const std::string& value : refused.values)
            expectError({"render", "nosuch.glb", "-o", "a.png", refused.option + "=" + value}, 2, refused.allowed);
    expectError({"render", "nosuch.glb", "-o", "a.png", "--spp", "-1"}, 2, "--spp -1");
    expectError({"render", "nosuch.glb", "-o", "a.png", "--accel", "quadtree"}, 2, "brute, bvh");
    expectError({"trace", "nosuch.glb", "--rays", "r", "--hits", "h", "--query", "first"}, 2, "closest or any");
    expectError({"render", "nosuch.glb", "-o", "a.png", "--instances", "yes"}, 2, "auto, keep or flatten");
}

TEST(CommandLine, PicturesToWriteAreRefusedBeforeAnythingIsRendered) {
    expectError({"render", "nosuch.glb", "-o", "a.jpeg"}, 2, ".png, .hdr, .exr or .pfm");
    expectError({"render", "nosuch.glb", "-o", "png"}, 2, ".png, .hdr, .exr or .pfm");
    expectError({"render", "nosuch.glb", "-o", "no/such/folder/a.png"}, 3, "no/such/folder");
    expectError({"compare", "a.png", "b.png", "-o", "a.gif"}, 2, ".png, .hdr, .exr or .pfm");
    expectError({"trace", "nosuch.glb", "--rays", "r.npy", "--hits", "no/such/folder/h.npy"}, 3, "no/such/folder");
}

TEST(CommandLine, ScenesThatCannotBeReadAreInputErrorsThatNameTheFile) {
    const std::filesystem::path folder = testing::TempDir() + "command_line_test";
    std::filesystem::create_directories(folder);
    const std::string output = folder / "out.png";
    const std::string junk = folder / "junk.glb";
    std::ofstream(junk) << "this is no scene";

    expectError({"render", "nosuch.glb", "-o", output}, 3, "nosuch.glb");
    expectError({"render", junk, "-o", output}, 3, "junk.glb");
    expectError({"render", folder, "-o", output}, 3, folder);
    expectError({"compare", "nosuch.glb"}, 3, "nosuch.glb");
    expectError({"compare", "nosuch.png", "other.png"}, 3, "nosuch.png");
    expectError({"trace", "nosuch.glb", "--rays", "r.npy", "--hits", folder / "h.npy"}, 3, "no");
    for (const std::filesystem::directory_entry& entry : std::filesystem::directory_iterator(folder))
        EXPECT_EQ(entry.path(), junk) << "nothing may be left behind";
    std::filesystem::remove_all(folder);
}

TEST(CommandLine, ResultsThatCannotBeWrittenAreErrors) {
    if (!std::filesystem::exists("/dev/full")) GTEST_SKIP() << "no /dev/full here";
    const ProgramResult result = runProgram(RAIG_PROGRAM, {"--help"}, /* outputFile= */ "/dev/full");
    EXPECT_EQ(result.exitCode, 3);
    EXPECT_NE(result.errors.find("standard output"), std::string::npos) << result.errors;
}

}  // namespace

}  // namespace raig
