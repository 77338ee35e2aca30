/// How light is followed: the options of `raig render`, and of `raig compare` of a scene, and what becomes of them.
#pragma once

#include "app/setup.hpp"
#include "rays/frame.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --integrator and --ao-distance. They throw usageError for what is none.
void addIntegratorOptions(CLI::App& command, Options& options);

/// The lines of --help that tell what integrators do.
extern const char* const integratorHelp;

/// Throws usageError for options of an integrator that was not asked for.
void checkIntegratorOptions(const Options& options);

/// Puts what is asked for into `frame`, whose camera is that of the picture. Ambient occlusion looks as far as is asked for,
/// else as suitableReach() says.
void setIntegrator(const Options& options, Setup& setup, FrameOptions& frame);

/// In words: "ambient occlusion up to 2.5".
std::string integratorText(const FrameOptions& frame);

}  // namespace raig
