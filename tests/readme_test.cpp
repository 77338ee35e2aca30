// The README's own commands, run in order as a newcomer would.
#include "support/program.hpp"

#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <cstdint>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <limits>
#include <set>
#include <sstream>
#include <string>
#include <vector>

namespace raig {

namespace {

namespace fs = std::filesystem;

/// What `line` runs in a shell block, or as a step of a YAML block; empty if that is not raig.
std::string commandOf(const std::string& line, bool isYaml) {
    std::string text = line;
    if (isYaml) {
        text.erase(0, std::min(text.find_first_not_of(' '), text.size()));
        for (const std::string prefix : {"- ", "run: "})
            if (text.starts_with(prefix)) text.erase(0, prefix.size());
    }
    if (!text.starts_with("./run ") || text.starts_with("./run test")) return "";
    return text.substr(6, text.find(" > ") - 6);
}

/// The arguments of each command "./run COMMAND ..." in the README's shell and YAML blocks, once each, but for ./run test:
/// this is one.
std::vector<std::vector<std::string>> readmeCommands() {
    std::ifstream file(fs::path(RAIG_SOURCE_DIR) / "README.md");
    std::vector<std::vector<std::string>> commands;
    std::set<std::string> seen;
    std::string block;
    for (std::string line; std::getline(file, line);) {
        if (line.starts_with("```")) block = line;
        if (block != "```sh" && block != "```yaml") continue;
        const std::string command = commandOf(line, block == "```yaml");
        if (command.empty() || !seen.insert(command).second) continue;
        std::istringstream words(command);
        commands.emplace_back(std::istream_iterator<std::string>(words), std::istream_iterator<std::string>());
    }
    return commands;
}

/// What the README's Python lines make, in fewer rays: a NumPy file of float32 [count, 8], all straight on.
void writeRays(const fs::path& path, uint32_t count) {
    std::string header = "{'descr': '<f4', 'fortran_order': False, 'shape': (" + std::to_string(count) + ", 8), }";
    header.resize(117, ' ');  // magic, version, length, header and line end fill two times 64 bytes
    header += '\n';
    std::ofstream file(path, std::ios::binary);
    file << "\x93NUMPY\x01" << '\0' << static_cast<char>(header.size()) << '\0' << header;
    const float ray[8] = {278.0f, 273.0f, -800.0f, 0.0f, 0.01f, 0.02f, 1.0f, std::numeric_limits<float>::infinity()};
    for (uint32_t i = 0; i < count; ++i) file.write(reinterpret_cast<const char*>(ray), sizeof ray);
}

TEST(Readme, EveryCommandOfItRuns) {
    const fs::path folder = fs::path(testing::TempDir()) / ("readme_test." + std::to_string(::getpid()));
    fs::create_directories(folder);
    fs::create_directory_symlink(fs::path(RAIG_SOURCE_DIR) / "assets", folder / "assets");
    const fs::path before = fs::current_path();
    fs::current_path(folder);
    writeRays("rays.npy", 10);

    const std::vector<std::vector<std::string>> commands = readmeCommands();
    EXPECT_GE(commands.size(), 17u);
    for (const std::vector<std::string>& command : commands) {
        std::string line;
        for (const std::string& word : command) line += ' ' + word;
        const ProgramResult result = runProgram(RAIG_PROGRAM, command);
        EXPECT_EQ(result.exitCode, 0) << "raig" << line << '\n' << result.errors;
        EXPECT_EQ(result.errors.find("error:"), std::string::npos) << "raig" << line << '\n' << result.errors;
    }
    for (const char* const file : {"out.png", "box.exr", "deep.png", "hits.npy", "difference.png", "again.png",
                                 "report/index.html", "report/stress.json", "stress.xml", "pictures.xml", "compare.xml"})
        EXPECT_TRUE(fs::is_regular_file(file)) << file;

    fs::current_path(before);
    fs::remove_all(folder);
}

TEST(Readme, PointsToFilesThatExist) {
    std::ifstream file(fs::path(RAIG_SOURCE_DIR) / "README.md");
    const std::string text(std::istreambuf_iterator<char>(file), {});
    for (size_t at = text.find("]("); at != text.npos; at = text.find("](", at + 1)) {
        const std::string target = text.substr(at + 2, text.find(')', at) - at - 2);
        EXPECT_TRUE(fs::exists(fs::path(RAIG_SOURCE_DIR) / target)) << target;
    }
}

}  // namespace

}  // namespace raig
