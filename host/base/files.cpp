#include "base/files.hpp"

#include "base/error.hpp"
#include "base/input_file.hpp"
#include "base/part_file.hpp"

#include <fcntl.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>
#include <utility>

namespace raig {

namespace {

/// A file descriptor that closes itself.
struct Descriptor {
    explicit Descriptor(int value) : fd(value) {}
    Descriptor(const Descriptor&) = delete;
    Descriptor& operator=(const Descriptor&) = delete;
    ~Descriptor() {
        if (fd >= 0) ::close(fd);
    }
    int fd;
};

/// Returns false, and errno says why, if not all could be written. 16 MiB at a time, as a signal waits for the end of a
/// write.
bool writeAll(int descriptor, std::span<const std::byte> bytes) {
    constexpr size_t most = size_t{16} << 20;
    while (!bytes.empty()) {
        const ssize_t put = ::write(descriptor, bytes.data(), std::min(most, bytes.size()));
        if (put < 0 && errno == EINTR) continue;
        if (put <= 0) return false;
        bytes = bytes.subspan(static_cast<size_t>(put));
    }
    return true;
}

bool writeAll(int descriptor, std::span<const std::span<const std::byte>> pieces) {
    return std::all_of(pieces.begin(), pieces.end(), [&](const auto& piece) { return writeAll(descriptor, piece); });
}

/// What errno says of `path`.
Error cannot(const std::filesystem::path& path, const char* what) {
    return inputError(path, "cannot be {}: {}", what, std::strerror(errno));
}

}  // namespace

std::vector<std::byte> readFile(const std::filesystem::path& path, size_t maxBytes) {
    InputFile file(path);
    if (file.size() > maxBytes)
        throw limitError("{}: holds {} bytes, more than the {} that can be read", path.string(), file.size(), maxBytes);
    std::vector<std::byte> bytes(file.size());
    file.read(bytes);
    return bytes;
}

void writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes) {
    writeFileAtomically(path, std::span(&bytes, 1));
}

void writeFileAtomically(const std::filesystem::path& path, std::span<const std::span<const std::byte>> pieces) {
    std::error_code none;
    const auto kind = std::filesystem::status(path, none).type();
    const bool replace = kind == std::filesystem::file_type::regular || kind == std::filesystem::file_type::directory ||
                         kind == std::filesystem::file_type::not_found || kind == std::filesystem::file_type::none;
    // Behind a link the file is replaced, not the link.
    std::filesystem::path target = std::filesystem::is_symlink(path, none) ? std::filesystem::canonical(path, none) : path;
    if (target.empty()) target = path;
    if (replace) {
        PartFile part(fmt::format("{}.{}.part", target.string(), ::getpid()));
        if (!part.ok() || !writeAll(part.descriptor(), pieces)) throw cannot(path, "written");
        if (!part.putInPlace(target)) throw cannot(path, "put in place");
    } else {
        // A device or a pipe cannot be replaced, and root could: /dev/null would become a file.
        Descriptor file(::open(path.c_str(), O_WRONLY | O_CLOEXEC));
        if (file.fd < 0 || !writeAll(file.fd, pieces) || ::close(std::exchange(file.fd, -1)) != 0)
            throw cannot(path, "written");
    }
}

}  // namespace raig
