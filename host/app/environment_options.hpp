/// Light from a picture of all directions: options of `raig render`, and of `raig compare` of a scene.
#pragma once

#include "app/options.hpp"
#include "scene/scene.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --environment, --environment-scale and --environment-rotate. They throw usageError for what is out of range.
void addEnvironmentOptions(CLI::App& command, Options& options);

/// The lines of --help that tell what these options do.
extern const char* const environmentHelp;

/// Lights `scene` by the picture that is asked for, if one is, and says so. Pixels that are negative or not finite count as
/// black, and are told. Throws what reading the picture throws.
void setEnvironment(const Options& options, Scene& scene);

}  // namespace raig
