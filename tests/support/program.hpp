/// Running programs from tests.
#pragma once

#include <string>
#include <utility>
#include <vector>

namespace raig {

struct ProgramResult {
    int exitCode = -1;   ///< 128 + N if signal N ended it
    std::string output;  ///< all of standard output
    std::string errors;  ///< all of standard error
};

using Variables = std::vector<std::pair<std::string, std::string>>;

/// Runs `program` with `arguments`, an empty standard input and `changes` made to the environment, and waits for it to end.
/// Standard output goes to `outputFile` if that is named. Throws std::runtime_error if the program cannot be started.
ProgramResult runProgram(const std::string& program, const std::vector<std::string>& arguments,
                         const std::string& outputFile = "", const Variables& changes = {});

}  // namespace raig
