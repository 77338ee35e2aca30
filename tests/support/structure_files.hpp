/// A file of a structure in a folder of its own, and why it is refused.
#pragma once

#include "base/error.hpp"
#include "structures/structure_file.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <fstream>

namespace raig::test {

class OfStructureFiles : public testing::Test {
protected:
    using Bytes = std::vector<std::byte>;

    void SetUp() override { std::filesystem::create_directories(folder_); }
    void TearDown() override { std::filesystem::remove_all(folder_); }

    void write(const Bytes& bytes) const {
        std::ofstream(file_, std::ios::binary).write(reinterpret_cast<const char*>(bytes.data()), std::ssize(bytes));
    }
    /// Why the file as it lies there is refused over primitives or a PlacedScene: one line that names it and says what to
    /// do. Empty if it is not.
    template <class Over>
    std::string refusal(const Over& over) const {
        try {
            StructureFile(file_).read(over);
        } catch (const Error& error) {
            const std::string text = error.what();
            EXPECT_EQ(error.exitCode, ExitCode::badInput) << text;
            EXPECT_TRUE(text.starts_with(file_.string() + ": ")) << text;
            EXPECT_NE(text.find("--save-structure"), std::string::npos) << text;
            EXPECT_EQ(text.find('\n'), std::string::npos) << text;
            return text;
        }
        return "";
    }

    const std::filesystem::path folder_ =
        std::filesystem::path(testing::TempDir()) / ("structure_files." + std::to_string(::getpid()));
    const std::filesystem::path file_ = folder_ / "structure";
};

}  // namespace raig::test
