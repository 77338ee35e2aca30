/// The options of `raig render` that ask for more of each pixel than its colour.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// --aov and --view.
void addAovOptions(CLI::App& command, Options& options);

/// Examples of them, and what they mean, for the end of the help.
std::string aovExamples();
std::string aovHelp();

/// The files beside the picture that AOVs are written to: none where the picture is an exr, whose layers they are then.
std::vector<std::filesystem::path> aovFiles(const Options& options);

}  // namespace raig
