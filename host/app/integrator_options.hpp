/// How light is followed: the options of `raig render`, and of `raig compare` of a scene, and what becomes of them.
#pragma once

#include "app/options.hpp"
#include "rays/frame.hpp"
#include "scene/geometry.hpp"

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

/// Puts what is asked for into `frame`. Ambient occlusion looks as far as is asked for, else a quarter of the diagonal of
/// the scene's box.
void setIntegrator(const Options& options, const Geometry& geometry, FrameOptions& frame);

/// In words: "ambient occlusion up to 2.5".
std::string integratorText(const FrameOptions& frame);

}  // namespace raig
