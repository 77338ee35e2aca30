/// How the light of a picture is shown: the options of `raig render`, and what becomes of them.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --exposure and --tonemap. They throw usageError for what there is not.
void addToneOptions(CLI::App& command, Options& options);

/// The lines of --help that tell what these options do, and to which files.
extern const char* const toneHelp;

/// Throws usageError where a curve is asked for in a file that keeps light as it is.
void checkToneOptions(const Options& options);

/// Exposes `image` and bends its light as is asked for. Returns the exposure in stops.
double showLight(const Options& options, Image& image);

}  // namespace raig
