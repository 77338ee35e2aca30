/// AOVs as layers of a file, and as pictures to look at.
#pragma once

#include "app/aov.hpp"
#include "image/views.hpp"
#include "rays/primary_hits.hpp"

namespace raig {

/// What AOVs are taken from: those of the picture need its levels and costs, the others the hits.
struct AovSources {
    uint32_t width = 0, height = 0;
    uint32_t samples = 0;  ///< of each pixel, unless the picture knows better
    const Picture& picture;
    const PrimaryHits& hits;
};

/// Requires the part of `sources` that it is taken from to be there. Cost O(pixels).
Layer layerOf(Aov aov, const AovSources& sources);

/// Its false colours: magma for numbers; for ids colours by their hash; 0.5 + 0.5 n for normals; the fractional part for
/// texture coordinates, and for positions that of a period, a power of two, which fits some 8 to 16 times into what is seen;
/// the colour itself for albedo. Black where nothing is hit. `range` is of numbers. Requires the same.
struct AovView {
    Image image;
    std::optional<std::pair<double, double>> range;
};
AovView viewOf(Aov aov, const AovSources& sources);

}  // namespace raig
