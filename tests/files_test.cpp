// Files are written whole or not at all: whatever fails, and whatever signal ends the program meanwhile.
#include "base/files.hpp"
#include "base/error.hpp"
#include "base/part_file.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <sys/resource.h>
#include <sys/stat.h>
#include <sys/wait.h>
#include <unistd.h>

#include <chrono>
#include <csignal>
#include <filesystem>
#include <fstream>
#include <functional>
#include <thread>

namespace raig {
namespace {

namespace fs = std::filesystem;
using namespace std::chrono_literals;

class Files : public testing::Test {
protected:
    void SetUp() override {
        fs::remove_all(folder_);
        fs::create_directory(folder_);
    }
    void TearDown() override { fs::remove_all(folder_); }

    std::vector<fs::path> parts() const {
        std::vector<fs::path> found;
        for (const auto& entry : fs::directory_iterator(folder_))
            if (entry.path().extension() == ".part") found.push_back(entry.path());
        return found;
    }

    const fs::path folder_ = fs::path(testing::TempDir()) / fmt::format("raig_files_{}", ::getpid());
};

pid_t inChild(const std::function<void()>& work) {
    const pid_t child = ::fork();
    if (child != 0) return child;
    work();
    ::_exit(0);
}

/// Waits until `holds`, and not for ever.
bool waitUntil(const std::function<bool()>& holds) {
    for (int tries = 0; tries < 60'000; ++tries, std::this_thread::sleep_for(1ms))
        if (holds()) return true;
    return false;
}

/// How `child` ended: by which signal, or 0 if by itself.
int endOf(pid_t child) {
    int status = 0;
    EXPECT_EQ(::waitpid(child, &status, 0), child);
    return WIFSIGNALED(status) ? WTERMSIG(status) : 0;
}

void writeForEver(const fs::path& path, size_t bytes) {
    const std::vector<std::byte> data(bytes, std::byte{7});
    for (;; std::this_thread::sleep_for(1ms)) writeFileAtomically(path, data);
}

TEST_F(Files, SignalsThatEndTheProgramLeaveNoHalfAFile) {
    constexpr size_t bytes = size_t{4} << 20;
    for (int round = 0; round < 9; ++round) {
        const int signal = std::array{SIGHUP, SIGINT, SIGTERM}[static_cast<size_t>(round) % 3];
        const pid_t child = inChild([&] {
            removePartFilesOnSignals();
            std::thread(writeForEver, folder_ / "one", bytes).detach();
            std::thread(writeForEver, folder_ / "small", 1).detach();
            writeForEver(folder_ / "other", bytes);
        });
        EXPECT_TRUE(waitUntil([&] { return fs::exists(folder_ / "one") && !parts().empty(); }));
        std::this_thread::sleep_for(1ms * round);
        ASSERT_EQ(::kill(child, signal), 0);
        EXPECT_EQ(endOf(child), signal);
        for (const fs::path& part : parts()) ADD_FAILURE() << part << " was left by signal " << signal;
        EXPECT_EQ(fs::file_size(folder_ / "one"), bytes);
        fs::remove(folder_ / "one");
    }
}

TEST_F(Files, SignalsThatAreIgnoredStayIgnored) {
    const pid_t child = inChild([] {
        std::signal(SIGHUP, SIG_IGN);
        removePartFilesOnSignals();
        std::raise(SIGHUP);
    });
    EXPECT_EQ(endOf(child), 0);
}

TEST_F(Files, TheProgramRemovesThemToo) {
    const pid_t child = inChild([&] {
        const std::string scene = RAIG_SOURCE_DIR "/assets/cornell_box.gltf", picture = folder_ / "out.png";
        ::execl(RAIG_PROGRAM, RAIG_PROGRAM, "render", scene.c_str(), "-o", picture.c_str(), "--size", "8192x8192",
                "--device", "cpu", "--quiet", nullptr);
    });
    const auto catches = [&](int signal) {
        std::ifstream status(fmt::format("/proc/{}/status", child));
        for (std::string word; status >> word;)
            if (word == "SigCgt:" && status >> word) return (std::stoull(word, nullptr, 16) >> (signal - 1) & 1) != 0;
        return false;
    };
    EXPECT_TRUE(waitUntil([&] { return catches(SIGINT) && catches(SIGTERM); }));
    ::kill(child, SIGTERM);
    EXPECT_EQ(endOf(child), SIGTERM);
    EXPECT_TRUE(fs::is_empty(folder_));
}

TEST_F(Files, WritesThatFailLeaveTheOldFileAndNothingElse) {
    const fs::path path = folder_ / "file";
    writeFileAtomically(path, std::vector<std::byte>(10));
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const auto oldHandler = std::signal(SIGXFSZ, SIG_IGN);
    const rlimit small{1 << 20, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    EXPECT_THROW(writeFileAtomically(path, std::vector<std::byte>(2 << 20)), Error);
    ::setrlimit(RLIMIT_FSIZE, &before);
    std::signal(SIGXFSZ, oldHandler);
    EXPECT_EQ(fs::file_size(path), 10u);
    EXPECT_TRUE(parts().empty());
}

TEST_F(Files, OfAProgramThatMayNotWriteSoMuchAreNotHalf) {
    rlimit before{};
    ASSERT_EQ(::getrlimit(RLIMIT_FSIZE, &before), 0);
    const rlimit small{1 << 12, before.rlim_max};
    ASSERT_EQ(::setrlimit(RLIMIT_FSIZE, &small), 0);
    const ProgramResult result = runProgram(
        RAIG_PROGRAM, {"render", RAIG_SOURCE_DIR "/assets/cornell_box.gltf", "-o", folder_ / "out.pfm", "--size", "64x64",
                       "--device", "cpu", "--quiet"});
    ::setrlimit(RLIMIT_FSIZE, &before);
    EXPECT_EQ(result.exitCode, 3);
    EXPECT_NE(result.errors.find("out.pfm: cannot be written"), std::string::npos) << result.errors;
    EXPECT_TRUE(fs::is_empty(folder_));
}

// Opening one for reading would wait until someone writes.
TEST_F(Files, AreNoPipes) {
    const fs::path pipe = folder_ / "pipe.gltf";
    ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
    EXPECT_THROW(readFile(pipe, 1000), Error);
}

TEST_F(Files, CannotBeWrittenOverAFolder) {
    fs::create_directory(folder_ / "here");
    EXPECT_THROW(writeFileAtomically(folder_ / "here", std::vector<std::byte>(1)), Error);
    EXPECT_THROW(writeFileAtomically(folder_ / "no" / "folder", std::vector<std::byte>(1)), Error);
    EXPECT_TRUE(parts().empty());
}

}  // namespace
}  // namespace raig
