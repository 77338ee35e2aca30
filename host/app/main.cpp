/// The program: parses the command line, runs one command, and turns whatever went wrong into one line and an exit code.
#include "app/commands.hpp"
#include "app/options.hpp"
#include "base/error.hpp"
#include "base/log.hpp"
#include "base/part_file.hpp"

#include <tbb/global_control.h>

#include <cerrno>
#include <csignal>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <new>

namespace raig {

namespace {

/// What no Error foresaw: a bug in raig. EX_SOFTWARE of sysexits.h, apart from the codes with a meaning.
constexpr int bugExitCode = 70;

int runCommand(const Options& options) {
    switch (options.command) {
        case Command::render: return render(options);
        case Command::trace: return trace(options);
        case Command::compare: return compare(options);
        case Command::bench: return bench(options);
        case Command::chart: return chart(options);
        case Command::stress: return stress(options);
        case Command::info: return info(options);
        case Command::devices: return devices(options);
    }
    RAIG_CHECK(!"a command of the list");
    return bugExitCode;
}

/// Runs with as many threads as asked for; lavapipe reads its number of threads when the first device is made.
int runWithThreads(const Options& options) {
    if (options.threads == 0) return runCommand(options);
    ::setenv("LP_NUM_THREADS", std::to_string(options.threads).c_str(), /* overwrite= */ 1);
    const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, options.threads);
    return runCommand(options);
}

/// A result that was not written is an error, unless its reader left on purpose, as `head` does.
void flushOutput() {
    if (std::fflush(stdout) == 0 && !std::ferror(stdout)) return;
    if (errno != EPIPE) throw inputError("standard output", "cannot be written: {}", std::strerror(errno));
}

int run(int argc, const char* const* argv) {
    const std::optional<Options> options = parseOptions(argc, argv);
    int code = static_cast<int>(ExitCode::done);
    if (options) {
        log::setQuiet(options->quiet);
        code = runWithThreads(*options);
    }
    flushOutput();
    return code;
}

}  // namespace

}  // namespace raig

int main(int argc, char** argv) {
    // A closed pipe must not end a long run before its files are written: writes to it fail instead, and are looked at.
    std::signal(SIGPIPE, SIG_IGN);
    std::signal(SIGXFSZ, SIG_IGN);  // nor must a limit on the size of files leave half of one
    raig::removePartFilesOnSignals();
    try {
        return raig::run(argc, argv);
    } catch (const raig::Error& error) {
        raig::log::errorText("error", error.what());
        return static_cast<int>(error.exitCode);
    } catch (const std::bad_alloc&) {
        raig::log::errorText("error", "memory ran out; try a smaller scene or picture, or a machine with more");
        return static_cast<int>(raig::ExitCode::limit);
    } catch (const std::exception& error) {
        raig::log::errorText("bug", std::string(error.what()) + "; please report it with the command line");
        return raig::bugExitCode;
    }
}
