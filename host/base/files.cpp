#include "base/files.hpp"

#include "base/error.hpp"

#include <fcntl.h>
#include <sys/stat.h>
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
    const Descriptor file(::open(path.c_str(), O_RDONLY | O_CLOEXEC));
    struct stat status {};
    if (file.fd < 0 || ::fstat(file.fd, &status) != 0) throw inputError(path, "cannot be opened: {}", std::strerror(errno));
    if (!S_ISREG(status.st_mode)) throw inputError(path, "is not a regular file");
    const auto size = static_cast<size_t>(status.st_size);
    if (size > maxBytes)
        throw limitError("{}: holds {} bytes, more than the {} that can be read", path.string(), size, maxBytes);

    std::vector<std::byte> bytes(size);
    for (size_t done = 0; done < size;) {
        const ssize_t got = ::read(file.fd, bytes.data() + done, size - done);
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw inputError(path, "cannot be read: {}", std::strerror(errno));
        if (got == 0) throw inputError(path, "became shorter while it was read");
        done += static_cast<size_t>(got);
    }
    return bytes;
}

void writeFileAtomically(const std::filesystem::path& path, std::span<const std::byte> bytes) {
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
        for (size_t done = 0; done < bytes.size();) {
            const ssize_t put = ::write(file.fd, bytes.data() + done, bytes.size() - done);
            if (put < 0 && errno == EINTR) continue;
            if (put <= 0) throw fail("written");
            done += static_cast<size_t>(put);
        }
        if (::close(std::exchange(file.fd, -1)) != 0) throw fail("written");  // a full network disk says so only here
    }
    if (replace && ::rename(written.c_str(), target.c_str()) != 0) throw fail("put in place");
}

}  // namespace raig
