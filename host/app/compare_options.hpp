/// The options of `raig compare` that no other command has: what its result is held to, and how it is told.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --fail-above, --fail-below, --ppd and --junit. They throw usageError for a metric that there is not.
void addCompareOptions(CLI::App& command, Options& options);

/// The group of options that say how a scene is rendered.
constexpr const char* optionsOfScenes = "Of scenes";

/// Throws usageError where one of those is given, as two pictures are compared as they are.
void checkOptionsOfPictures(const CLI::App& command);

/// Throws usageError where two pictures are held to what only scenes have, or are to be told in JUnit's XML and held to
/// nothing.
void checkBoundsOfPictures(const Options& options);

}  // namespace raig
