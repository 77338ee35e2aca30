/// Files read piece by piece: for those too large to be held twice.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>

namespace raig {

/// A regular file, open for reading from its beginning on. Throws inputError if it cannot be opened.
class InputFile {
public:
    explicit InputFile(const std::filesystem::path& path);
    ~InputFile();
    InputFile(const InputFile&) = delete;
    InputFile& operator=(const InputFile&) = delete;

    const std::filesystem::path& path() const { return path_; }
    /// In bytes, as it was when the file was opened.
    uint64_t size() const { return size_; }
    /// Fills `bytes` with the next ones of the file. Throws inputError if it cannot be read or ends before that.
    void read(std::span<std::byte> bytes);

private:
    std::filesystem::path path_;
    int descriptor_;
    uint64_t size_ = 0;
};

}  // namespace raig
