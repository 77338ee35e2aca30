/// What `raig compare` found, as tables and lines.
#pragma once

#include "measure/compare_scene.hpp"

#include <string>

namespace raig {

/// One table of one row, on standard output.
void printPictures(const PictureDifference& difference);

/// Rays by family, how far their t are off, the first that differs, pixels, and what was left out, on standard output.
/// `walker`: the structure, its walk and the device, in words.
void printScene(const SceneComparison& scene, const std::string& walker);

/// One line: the ray's family, number and level, what each says of it, and the ray as numbers that `raig trace` takes:
/// [ox, oy, oz, tmin, dx, dy, dz, tmax].
std::string describe(const Placed<HitComparison::Difference>& first, const std::string& walker);
std::string describe(const Placed<BitComparison::Difference>& first, const std::string& walker);

}  // namespace raig
