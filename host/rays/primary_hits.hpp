/// What the camera sees first in each pixel, beside the picture: distances, places, normals, ids, colours.
#pragma once

#include "rays/frame.hpp"
#include "rays/frame_types.hpp"

namespace raig {

using shared::PrimaryHit;

/// One a pixel that is rendered, row by row from the top, of the ray through the pixel's centre (that of a picture with one
/// sample) and the lens's: nothing is averaged. `pixel` counts in the whole picture, `primitive` a mesh's triangles in file
/// order, then its spheres; `instance` and `material` are indices into Scene::instances and Scene::materials. Where nothing
/// is hit depth is infinite, these three are NO_HIT, all else is 0. Without texture coordinates in the scene u and v are the
/// hit's own.
///
/// Surfaces that let rays pass by their alpha are hit where at least half of them is there (where they are cut out, all or
/// nothing is), as the picture sees them; else what is behind them is, past MOST_PASSES of them at most, then nothing. Depth
/// is from where the ray starts all the same.
struct PrimaryHits {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<PrimaryHit> pixels;
};

/// On the CPU, over all cores.
///
/// Requires  what renderPicture requires of scene, geometry, tracer and options.
/// Ensures   the same bits whatever the number of threads, and from every device whose arithmetic is IEEE 754's.
/// Cost      one ray a pixel, and one more for each surface that it passes; packing the scene as renderPicture does, and 64
///           bytes a pixel.
PrimaryHits findPrimaryHits(const Scene& scene, const Geometry& geometry, Tracer& tracer, const FrameOptions& options);

/// On a device, which `tracer` traces on.
PrimaryHits findPrimaryHits(Device& device, const Scene& scene, const Geometry& geometry, DeviceTracer& tracer,
                            const FrameOptions& options);

}  // namespace raig
