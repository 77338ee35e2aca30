#include "app/written_files.hpp"

#include "app/animation_options.hpp"
#include "app/aov_options.hpp"
#include "base/error.hpp"

#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cstring>

namespace raig {

namespace {

/// Whether `made`, which is made with all folders above it, is in `folder` or is that.
bool comesWith(const std::filesystem::path& folder, const std::filesystem::path& made) {
    if (made.empty()) return false;
    const auto plain = [](const std::filesystem::path& path) {
        const std::filesystem::path normal = std::filesystem::absolute(path).lexically_normal();
        return normal.has_filename() ? normal : normal.parent_path();
    };
    const std::filesystem::path above = plain(folder), below = plain(made);
    return std::mismatch(above.begin(), above.end(), below.begin(), below.end()).first == above.end();
}

void checkIsNoFolder(const std::filesystem::path& file) {
    std::error_code ignored;
    if (std::filesystem::is_directory(file, ignored)) throw inputError(file, "cannot be written: it is a folder");
}

/// `made`: a folder that the command makes before it writes; empty if it makes none.
void checkFolderOf(const std::filesystem::path& file, const std::filesystem::path& made = {}) {
    if (file.empty()) return;
    const std::filesystem::path folder = file.has_parent_path() ? file.parent_path() : ".";
    std::error_code ignored;
    if (!std::filesystem::is_directory(folder, ignored)) {
        if (comesWith(folder, made)) return;
        throw inputError(file, "cannot be written: there is no folder {}; make it first", folder.string());
    }
    checkIsNoFolder(file);
    // Files are replaced, which is for the folder to allow; devices are written to.
    const bool replaces = !std::filesystem::exists(file, ignored) || std::filesystem::is_regular_file(file, ignored);
    if (replaces && ::access(folder.c_str(), W_OK | X_OK) != 0)
        throw inputError(file, "cannot be written: {}", std::strerror(errno));
}

/// Throws where a file that is to be written would replace one that is to be read, or another one to be written. Devices
/// and pipes may be read and written as often as one likes.
void checkFilesDiffer(const Options& options) {
    const auto isSame = [](const std::filesystem::path& a, const std::filesystem::path& b) {
        std::error_code ignored;
        if (std::filesystem::exists(a, ignored) && !std::filesystem::is_regular_file(a, ignored)) return false;
        return !a.empty() && !b.empty() &&
               (std::filesystem::absolute(a).lexically_normal() == std::filesystem::absolute(b).lexically_normal() ||
                std::filesystem::equivalent(a, b, ignored));
    };
    std::vector<std::filesystem::path> read = options.inputs;
    read.insert(read.end(), {options.rays, options.loadStructure});
    std::vector<std::filesystem::path> written = {options.output, options.hits, options.saveStructure, options.junit};
    for (const std::filesystem::path& file : aovFiles(options)) written.push_back(file);
    if (!options.folder.empty())
        written.insert(written.begin(), {options.folder / "index.html", options.folder / "stress.json"});
    for (size_t i = 0; i < written.size(); ++i) {
        for (const std::filesystem::path& input : read)
            if (isSame(written[i], input))
                throw usageError("{} would be read and replaced: name another file to write", written[i].string());
        for (size_t k = 0; k < i; ++k)
            if (isSame(written[i], written[k]))
                throw usageError("{} would be written twice: name another file", written[i].string());
    }
}

void checkFrames(const Options& options) {
    if (!options.frames) return;
    Options each = options;
    for (uint32_t frame = options.frames->first; frame <= options.frames->last; ++frame) {
        each.output = fileOf(options.output, frame);
        checkIsNoFolder(each.output);
        for (const std::filesystem::path& file : aovFiles(each)) checkIsNoFolder(file);
    }
}

}  // namespace

void checkWrittenFiles(const Options& options) {
    checkFilesDiffer(options);
    checkFolderOf(options.output);
    for (const std::filesystem::path& file : aovFiles(options)) checkFolderOf(file);
    checkFolderOf(options.hits);
    checkFolderOf(options.saveStructure);
    checkFolderOf(options.junit, options.folder);
    checkFrames(options);
}

}  // namespace raig
