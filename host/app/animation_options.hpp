/// When a scene that moves is looked at: the options of the commands that read one, and what becomes of them.
#pragma once

#include "app/options.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --time-at and --animation. They throw usageError for what is no number.
void addMomentOptions(CLI::App& command, Options& options);

/// Adds --frames and --fps, of `raig render`.
void addFrameOptions(CLI::App& command, Options& options);

/// The lines of --help that tell what these options do.
extern const char* const animationHelp;

/// Throws usageError for what cannot be: an animation at no moment, or a structure of many moments in one file.
void checkAnimationOptions(const Options& options);

/// Of a picture of --frames, its moment, and its file: that of --output with the number before its ending, four digits at
/// least ("out.0012.png").
double secondsOf(const Options& options, uint32_t frame);
std::filesystem::path fileOf(const std::filesystem::path& output, uint32_t frame);

}  // namespace raig
