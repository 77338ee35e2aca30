/// Files while they are being written: under a name of their own, which goes when the writing fails or a signal ends the
/// program.
#pragma once

#include <string>

namespace raig {

/// A new file that is removed with this object, unless it was put in place before.
class PartFile {
public:
    /// Creates or empties the file `path`; ok() says whether that went well, errno why not.
    explicit PartFile(std::string path);
    ~PartFile();
    PartFile(const PartFile&) = delete;
    PartFile& operator=(const PartFile&) = delete;

    bool ok() const { return descriptor_ >= 0; }
    int descriptor() const { return descriptor_; }
    /// Closes the file and renames it to `target`. Returns false, and errno says why, if either fails.
    bool putInPlace(const std::string& target);

private:
    friend void removePartFiles(int signal);

    std::string path_;
    int descriptor_ = -1;
    bool exists_ = false;
    PartFile* next_ = nullptr;
};

/// From here on SIGHUP, SIGINT and SIGTERM remove all part files before they end the program as they always do. Those that
/// are ignored stay ignored. For programs to call, once, at their start.
void removePartFilesOnSignals();

}  // namespace raig
