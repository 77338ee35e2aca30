#include "base/input_file.hpp"

#include "base/error.hpp"

#include <fcntl.h>
#include <sys/stat.h>
#include <unistd.h>

#include <cerrno>
#include <cstring>

namespace raig {

InputFile::InputFile(const std::filesystem::path& path)
    : path_(path),
      descriptor_(::open(path.c_str(), O_RDONLY | O_CLOEXEC | O_NONBLOCK)) {  // a pipe would wait for its writer
    struct stat status {};
    const bool opened = descriptor_ >= 0 && ::fstat(descriptor_, &status) == 0;
    if (opened && S_ISREG(status.st_mode)) {
        size_ = static_cast<uint64_t>(status.st_size);
        return;
    }
    const int reason = errno;
    if (descriptor_ >= 0) ::close(descriptor_);
    if (opened) throw inputError(path, "is not a regular file");
    throw inputError(path, "cannot be opened: {}", std::strerror(reason));
}

InputFile::~InputFile() {
    ::close(descriptor_);
}

void InputFile::read(std::span<std::byte> bytes) {
    while (!bytes.empty()) {
        const ssize_t got = ::read(descriptor_, bytes.data(), bytes.size());
        if (got < 0 && errno == EINTR) continue;
        if (got < 0) throw inputError(path_, "cannot be read: {}", std::strerror(errno));
        if (got == 0) throw inputError(path_, "became shorter while it was read");
        bytes = bytes.subspan(static_cast<size_t>(got));
    }
}

}  // namespace raig
