#include "base/files.hpp"

#include "base/error.hpp"
#include "base/input_file.hpp"

#include <fcntl.h>
#include <unistd.h>

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
    // A device or a pipe cannot be replaced, and root could: /dev/null would become a file.
    const std::string written = replace ? fmt::format("{}.{}.part", target.string(), ::getpid()) : path.string();
    const auto fail = [&](const char* what) {
        const int reason = errno;
        if (replace) ::unlink(written.c_str());
        return inputError(path, "cannot be {}: {}", what, std::strerror(reason));
    };
    {
        const int create = replace ? O_CREAT | O_TRUNC : 0;
        Descriptor file(::open(written.c_str(), O_WRONLY | O_CLOEXEC | create, 0666));
        if (file.fd < 0) throw fail("written");
        for (std::span<const std::byte> bytes : pieces)
            while (!bytes.empty()) {
                const ssize_t put = ::write(file.fd, bytes.data(), bytes.size());
                if (put < 0 && errno == EINTR) continue;
                if (put <= 0) throw fail("written");
                bytes = bytes.subspan(static_cast<size_t>(put));
            }
        if (::close(std::exchange(file.fd, -1)) != 0) throw fail("written");  // a full network disk says so only here
    }
    if (replace && ::rename(written.c_str(), target.c_str()) != 0) throw fail("put in place");
}

}  // namespace raig
