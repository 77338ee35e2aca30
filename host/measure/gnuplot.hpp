/// Figures by gnuplot.
#pragma once

#include <string>

namespace raig {

/// Runs gnuplot on a script. Throws inputError if it is not installed, or says that something is wrong, with what that says
/// last.
void runGnuplot(const std::string& script);

/// As a single-quoted string of a script.
std::string gnuplotText(const std::string& text);

}  // namespace raig
