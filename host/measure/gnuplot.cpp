#include "measure/gnuplot.hpp"

#include "base/error.hpp"

#include <fcntl.h>
#include <spawn.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cerrno>
#include <cstdio>
#include <cstring>
#include <memory>

extern char** environ;

namespace raig {

namespace {

struct Closer {
    void operator()(std::FILE* file) const { std::fclose(file); }
};
using File = std::unique_ptr<std::FILE, Closer>;

File temporary() {
    File file(std::tmpfile());
    if (!file) throw inputError("the folder for temporary files", "cannot be written: {}", std::strerror(errno));
    return file;
}

/// The last line that says something; gnuplot points at the place in lines above it.
std::string complaint(std::FILE* file) {
    std::rewind(file);
    char line[512];
    std::string last;
    while (std::fgets(line, sizeof line, file)) {
        std::string text(line);
        while (!text.empty() && (text.back() == '\n' || text.back() == ' ')) text.pop_back();
        if (!text.empty()) last = text;
    }
    return last;
}

}  // namespace

void runGnuplot(const std::string& script) {
    const File input = temporary(), errors = temporary();
    if (std::fwrite(script.data(), 1, script.size(), input.get()) != script.size() || std::fflush(input.get()) != 0)
        throw inputError("a temporary file", "cannot be written: {}", std::strerror(errno));
    std::rewind(input.get());
    posix_spawn_file_actions_t actions;
    posix_spawn_file_actions_init(&actions);
    posix_spawn_file_actions_adddup2(&actions, fileno(input.get()), 0);
    posix_spawn_file_actions_addopen(&actions, 1, "/dev/null", O_WRONLY, 0);
    posix_spawn_file_actions_adddup2(&actions, fileno(errors.get()), 2);
    const char* const arguments[] = {"gnuplot", "-d", nullptr};
    pid_t child = 0;
    const int failure = posix_spawnp(&child, "gnuplot", &actions, nullptr, const_cast<char* const*>(arguments), environ);
    posix_spawn_file_actions_destroy(&actions);
    if (failure != 0)
        throw inputError("gnuplot", "cannot be run ({}); install it: Debian's package is gnuplot-nox",
                         std::strerror(failure));
    int status = 0;
    while (::waitpid(child, &status, 0) < 0 && errno == EINTR) {
    }
    if (!WIFEXITED(status) || WEXITSTATUS(status) != 0)
        throw inputError("gnuplot", "could not draw a figure: {}", complaint(errors.get()));
}

std::string gnuplotText(const std::string& text) {
    std::string quoted = "'";
    for (const char c : text) {
        if (c == '\n' || c == '\r' || c == '\0')
            quoted += ' ';
        else
            quoted += c == '\'' ? std::string("''") : std::string(1, c);
    }
    return quoted + "'";
}

}  // namespace raig
