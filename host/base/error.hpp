/// Three kinds of wrong: a bug is a RAIG_CHECK, always on; wrong input or a missing device is an Error with an exit
/// code; an expected absence is std::optional.
#pragma once

#include <fmt/format.h>

#include <stdexcept>
#include <string>

namespace raig {

/// What the program exits with, by meaning.
enum class ExitCode : int {
    done = 0,
    fellShort = 1,  ///< a comparison, bench or stress check fell short
    usage = 2,      ///< wrong command line
    badInput = 3,   ///< a file that cannot be used
    noDevice = 4,   ///< no usable device, or the device was lost
    limit = 5,      ///< memory or a buffer limit was reached
};

/// An error of the user's or the machine's making. Its text is one line: what, where, what to do.
class Error : public std::runtime_error {
public:
    Error(ExitCode code, const std::string& text) : std::runtime_error(text), exitCode(code) {}
    ExitCode exitCode;
};

template <class... Args>
[[nodiscard]] Error usageError(fmt::format_string<Args...> format, Args&&... args) {
    return {ExitCode::usage, fmt::format(format, std::forward<Args>(args)...)};
}

/// `place` is the file, with a line ("scene.obj:12") or a JSON pointer ("scene.gltf#/nodes/3") where there is one.
template <class... Args>
[[nodiscard]] Error inputError(const std::string& place, fmt::format_string<Args...> format, Args&&... args) {
    return {ExitCode::badInput, place + ": " + fmt::format(format, std::forward<Args>(args)...)};
}

template <class... Args>
[[nodiscard]] Error deviceError(fmt::format_string<Args...> format, Args&&... args) {
    return {ExitCode::noDevice, fmt::format(format, std::forward<Args>(args)...)};
}

template <class... Args>
[[nodiscard]] Error limitError(fmt::format_string<Args...> format, Args&&... args) {
    return {ExitCode::limit, fmt::format(format, std::forward<Args>(args)...)};
}

/// Prints the failed condition and its place on standard error and aborts.
[[noreturn]] void checkFailed(const char* file, int line, const std::string& what);

}  // namespace raig

/// Aborts with file, line and condition unless `condition` holds; in every build.
#define RAIG_CHECK(condition)                                                  \
    do {                                                                       \
        if (!(condition)) ::raig::checkFailed(__FILE__, __LINE__, #condition); \
    } while (false)

/// As RAIG_CHECK for a comparison; prints both values.
#define RAIG_CHECK_OP(left, op, right)                                                                       \
    do {                                                                                                     \
        const auto& raigLeft = (left);                                                                       \
        const auto& raigRight = (right);                                                                     \
        if (!(raigLeft op raigRight))                                                                        \
            ::raig::checkFailed(__FILE__, __LINE__,                                                          \
                                fmt::format("{} ({}) {} {} ({})", #left, raigLeft, #op, #right, raigRight)); \
    } while (false)
