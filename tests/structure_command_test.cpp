// Structures as the commands make, keep and choose them.
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <nlohmann/json.hpp>
#include <string>
#include <vector>

namespace raig {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

std::string bytesOf(const fs::path& path) {
    std::ifstream file(path, std::ios::binary);
    return {std::istreambuf_iterator<char>(file), {}};
}

class StructureCommands : public testing::Test {
protected:
    void SetUp() override { fs::create_directories(folder_); }
    void TearDown() override { fs::remove_all(folder_); }

    static ProgramResult raig(const Arguments& arguments) { return runProgram(RAIG_PROGRAM, arguments); }

    /// A small picture of a scene into the file `name`, on the CPU.
    ProgramResult render(const std::string& scene, const std::string& name, const Arguments& more) const {
        Arguments all = {"render", scene, "-o", folder_ / name, "--size", "24x24", "--spp", "1", "--device", "cpu"};
        all.insert(all.end(), more.begin(), more.end());
        return raig(all);
    }
    void expectRefusal(const ProgramResult& result, int exitCode, const std::string& mentions) const {
        EXPECT_EQ(result.exitCode, exitCode) << result.errors;
        const size_t at = result.errors.find("raig: error: ");
        ASSERT_NE(at, std::string::npos) << result.errors;
        EXPECT_EQ(result.errors.find('\n', at), result.errors.size() - 1) << result.errors;
        EXPECT_NE(result.errors.find(mentions, at), std::string::npos) << result.errors << " does not mention " << mentions;
    }

    const fs::path folder_ = fs::path(testing::TempDir()) / ("structure_command_test." + std::to_string(::getpid()));
    const std::string box_ = fs::path(RAIG_SOURCE_DIR) / "assets/cornell_box.gltf";
    const std::string spheres_ = fs::path(RAIG_SOURCE_DIR) / "assets/cornell_spheres.gltf";
    const std::string file_ = folder_ / "structure";
};

TEST_F(StructureCommands, SavedStructuresGiveTheSamePicture) {
    for (const std::string& scene : {box_, spheres_}) {
        const ProgramResult saved = render(scene, "built.pfm", {"--save-structure", file_, "--json"});
        ASSERT_EQ(saved.exitCode, 0) << saved.errors;
        const ProgramResult loaded = render(scene, "loaded.pfm", {"--load-structure", file_, "--json"});
        ASSERT_EQ(loaded.exitCode, 0) << loaded.errors;
        EXPECT_EQ(bytesOf(folder_ / "loaded.pfm"), bytesOf(folder_ / "built.pfm"));
        EXPECT_NE(loaded.errors.find("read from " + file_), std::string::npos) << loaded.errors;
        const auto before = nlohmann::json::parse(saved.output), after = nlohmann::json::parse(loaded.output);
        EXPECT_EQ(after["structure"], before["structure"]);
        EXPECT_GT(before["build_s"], 0.0);
        EXPECT_EQ(before["load_s"], 0.0);
        EXPECT_EQ(after["build_s"], 0.0);
        EXPECT_GT(after["load_s"], 0.0);
    }
}

TEST_F(StructureCommands, SavedStructuresOfOtherScenesAndKindsAreRefused) {
    ASSERT_EQ(render(box_, "a.pfm", {"--save-structure", file_, "--walk", "skip", "--max-leaf", "2"}).exitCode, 0);
    EXPECT_EQ(render(box_, "b.pfm", {"--load-structure", file_, "--accel", "bvh"}).exitCode, 0);
    EXPECT_EQ(render(box_, "b.pfm", {"--load-structure", file_, "--max-leaf", "2", "--walk", "skip"}).exitCode, 0);
    expectRefusal(render(spheres_, "c.pfm", {"--load-structure", file_}), 3, "another scene");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--accel", "brute"}), 3, "holds a bvh, not the brute");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--max-leaf", "3"}), 3, "--walk skip --max-leaf 2");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", folder_ / "none"}), 3, "cannot be opened");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", box_}), 3, "is no structure");
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_, "--save-structure", file_}), 2, "excludes");
    expectRefusal(render(box_, "c.pfm", {"--save-structure", folder_ / "no/folder"}), 3, "no folder");
    fs::resize_file(file_, fs::file_size(file_) - 1);
    expectRefusal(render(box_, "c.pfm", {"--load-structure", file_}), 3, file_);
    EXPECT_FALSE(fs::exists(folder_ / "c.pfm"));
    // What is wrong with the file's start is told before the scene is read.
    expectRefusal(render("nosuch.glb", "c.pfm", {"--load-structure", file_}), 3, file_);
}

}  // namespace
}  // namespace raig
