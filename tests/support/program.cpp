#include "support/program.hpp"

#include <fcntl.h>
#include <sys/wait.h>
#include <unistd.h>

#include <cstdio>
#include <cstdlib>
#include <stdexcept>

namespace raig {

namespace {

/// A file without a name: outlives the program that fills it, needs no thread to drain it.
class Capture {
public:
    Capture() : file(std::tmpfile()) {
        if (!file) throw std::runtime_error("no temporary file can be made");
    }
    Capture(const Capture&) = delete;
    Capture& operator=(const Capture&) = delete;
    ~Capture() { std::fclose(file); }

    int descriptor() const { return ::fileno(file); }
    std::string text() const {
        std::string all;
        std::rewind(file);
        for (int c; (c = std::fgetc(file)) != EOF;) all += static_cast<char>(c);
        return all;
    }

private:
    std::FILE* file;
};

}  // namespace

ProgramResult runProgram(const std::string& program, const std::vector<std::string>& arguments,
                         const std::string& outputFile, const Variables& changes) {
    std::vector<char*> argv{const_cast<char*>(program.c_str())};
    for (const std::string& argument : arguments) argv.push_back(const_cast<char*>(argument.c_str()));
    argv.push_back(nullptr);

    const Capture output, errors;
    const pid_t child = ::fork();
    if (child < 0) throw std::runtime_error("cannot fork to run " + program);
    if (child == 0) {
        const int named = outputFile.empty() ? output.descriptor() : ::open(outputFile.c_str(), O_WRONLY);
        const int empty = ::open("/dev/null", O_RDONLY);
        if (named < 0 || empty < 0 || ::dup2(empty, 0) < 0 || ::dup2(named, 1) < 0 || ::dup2(errors.descriptor(), 2) < 0)
            ::_exit(127);
        for (const auto& [name, value] : changes) ::setenv(name.c_str(), value.c_str(), 1);
        ::execv(program.c_str(), argv.data());
        ::_exit(127);
    }
    int status = 0;
    if (::waitpid(child, &status, 0) != child) throw std::runtime_error("cannot wait for " + program);
    const int code = WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
    if (code == 127) throw std::runtime_error(program + " cannot be started");
    return {code, output.text(), errors.text()};
}

}  // namespace raig
