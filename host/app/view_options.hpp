/// What is seen of a scene: the options of `raig render`, and of `raig compare` of a scene, and what becomes of them.
#pragma once

#include "app/options.hpp"
#include "rays/frame.hpp"

namespace CLI {
class App;
}

namespace raig {

/// Adds --size, --camera, --eye, --at, --up, --fov, --crop, --aperture and --focus. They throw usageError for what is no
/// number or out of range. Without --size there are side x side pixels, or as many in the shape that the camera asks for.
void addViewOptions(CLI::App& command, Options& options, uint32_t side);

/// The lines of --help that tell what these options do to each other.
extern const char* const viewHelp;

/// Throws usageError for what cannot be, whatever the scene: a part that is not in the picture, an eye where it looks.
void checkViewOptions(const Options& options);

/// The frame that is asked for; the camera of `scene` that it is seen by is changed as is asked for, and headlights shine
/// where it looks. Throws usageError if there is no such camera, or it cannot be changed so.
FrameOptions frameOptions(const Options& options, Scene& scene, uint32_t defaultSamples);

}  // namespace raig
