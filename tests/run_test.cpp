// The script ./run on a tree of its own: a small project in C, so that each build takes a moment only.
#include "support/program.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <future>
#include <string>
#include <vector>

#include <unistd.h>

namespace raig {

namespace {

namespace fs = std::filesystem;

class Run : public testing::Test {
protected:
    void SetUp() override {
        fs::create_directories(tree / "host");
        fs::create_directories(tree / "shaders");
        fs::create_directories(tree / "tests");
        for (const char* const name : {"run", "CMakePresets.json"})
            fs::copy_file(fs::path(RAIG_SOURCE_DIR) / name, tree / name, fs::copy_options::overwrite_existing);
        write("CMakeLists.txt", "cmake_minimum_required(VERSION 3.25)\n"
                                "project(small LANGUAGES C)\n"
                                "add_executable(raig host/main.c)\n"
                                "enable_testing()\n"
                                "add_test(NAME Runs COMMAND raig)\n");
        writeProgram("one");
        const ProgramResult first = run({});
        if (first.errors.find("packages are missing") != std::string::npos) GTEST_SKIP() << first.errors;
        ASSERT_EQ(first.exitCode, 7) << first.errors;
    }
    void TearDown() override { fs::remove_all(top); }

    void write(const std::string& name, const std::string& text) { std::ofstream(tree / name) << text; }
    /// A program that prints its folder, `word` and its arguments, one a line, and exits with 7, or 0 as a test.
    void writeProgram(const std::string& word) {
        write("host/main.c", "#include <stdio.h>\n#include <stdlib.h>\n#include <unistd.h>\n"
                             "int main(int count, char** words) {\n"
                             "    char folder[4096];\n"
                             "    puts(getcwd(folder, sizeof folder));\n"
                             "    puts(\"" + word + "\");\n"
                             "    for (int i = 1; i < count; ++i) puts(words[i]);\n"
                             "    const char* const all = getenv(\"RAIG_LONG\");\n"
                             "    return all && *all ? 0 : 7;\n"
                             "}\n");
    }
    ProgramResult run(const std::vector<std::string>& arguments) const {
        return runProgram(tree / "run", arguments, /* outputFile= */ "", {{"RAIG_NO_INSTALL", "1"}, {"RAIG_LONG", ""}});
    }

    const std::string here = fs::current_path().string() + '\n';
    fs::path top = fs::path(testing::TempDir()) / ("run_test." + std::to_string(::getpid()));
    fs::path tree = top / "a tree";
};

TEST_F(Run, StartsTheProgramInTheCallersFolderWithItsArgumentsAndItsExitCode) {
    const ProgramResult result = run({"render", "a b", "", "*"});
    EXPECT_EQ(result.output, here + "one\nrender\na b\n\n*\n");
    EXPECT_EQ(result.exitCode, 7);
    EXPECT_EQ(result.errors, "") << "nothing is left to do, so nothing is said";
}

TEST_F(Run, BuildsWhatChangedAndOnlyThen) {
    writeProgram("two");
    const ProgramResult changed = run({});
    EXPECT_EQ(changed.output, here + "two\n");
    EXPECT_NE(changed.errors.find("run: building"), std::string::npos) << changed.errors;
    EXPECT_EQ(run({}).errors, "");
    write("tests/a_test.cpp", "");
    EXPECT_EQ(run({}).errors, "") << "the program is not built for the sake of a test";
}

// The program names the commit that it is built of.
TEST_F(Run, BuildsOnceAfterACommit) {
    fs::create_directories(tree / ".git/logs");
    write(".git/logs/HEAD", "");
    EXPECT_NE(run({}).errors.find("run: building"), std::string::npos);
    EXPECT_EQ(run({}).errors, "");
}

TEST_F(Run, ShowsWhyABuildFailedAndBuildsAgainOnceMended) {
    write("host/main.c", "int broken(\n");
    for (int i = 0; i < 2; ++i) {
        const ProgramResult result = run({});
        EXPECT_EQ(result.exitCode, 70);
        EXPECT_EQ(result.output, "");
        EXPECT_NE(result.errors.find("main.c:1"), std::string::npos) << result.errors;
    }
    writeProgram("three");
    EXPECT_EQ(run({}).output, here + "three\n");
}

TEST_F(Run, TestsPassOnTheirResultAndTheirCounts) {
    const ProgramResult failed = run({"test"});
    EXPECT_NE(failed.exitCode, 0);
    EXPECT_NE(failed.output.find("1 tests failed out of 1"), std::string::npos) << failed.output;
    const ProgramResult passed = run({"test", "--long"});  // sets RAIG_LONG
    EXPECT_EQ(passed.exitCode, 0);
    EXPECT_NE(passed.output.find("100% tests passed, 0 tests failed out of 1"), std::string::npos) << passed.output;
    EXPECT_NE(run({"test", "-R", "NoSuchTest"}).exitCode, 0) << "no test run is no success";
}

TEST_F(Run, TwoAtOnceBuildOnce) {
    writeProgram("four");
    std::future<ProgramResult> other = std::async(std::launch::async, [this] { return run({"other"}); });
    const ProgramResult mine = run({"mine"});
    EXPECT_EQ(mine.output, here + "four\nmine\n");
    EXPECT_EQ(other.get().output, here + "four\nother\n");
}

TEST_F(Run, WorksAfterTheTreeHasMoved) {
    const fs::path moved = top / "moved";
    fs::rename(tree, moved);
    tree = moved;
    const ProgramResult result = run({});
    EXPECT_EQ(result.output, here + "one\n") << result.errors;
    EXPECT_EQ(result.exitCode, 7);
}

}  // namespace

}  // namespace raig
