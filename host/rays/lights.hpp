/// The triangles that emit light, and with what probability a shading point asks each.
#pragma once

#include "scene/geometry.hpp"
#include "structures/structure.hpp"

#include <vector>

namespace raig {

struct Emitter {
    uint32_t triangle = 0;    ///< global id
    float area = 0.0f;
    float cumulated = 0.0f;   ///< probability of this emitter or one before it; exactly 1 for the last
};

/// The usable triangles (no spheres) of emitting materials, in order of their ids, each picked with a probability
/// proportional to its area times the luminance (0.2126 R + 0.7152 G + 0.0722 B) of its emission, of which a texture counts
/// by its mean. Summed in double, rounded
/// once. Empty if nothing emits. Cost O(triangles) where a material emits, else O(materials).
std::vector<Emitter> listEmitters(const Scene& scene, const Geometry& geometry);

/// One byte a primitive of geometry.triangles: 1 where the surface lets light through, and so is no obstacle to shadow rays.
/// Empty if there are none.
std::vector<uint8_t> findSeeThrough(const Scene& scene, const Geometry& geometry);

/// Marks the references to them as no obstacle to shadow rays. Requires a structure of the geometry's triangles, of one
/// level or two; of two, geometry.isInstanced(). O(references), for those with global ids O(log instances) each.
void markSeeThrough(const Scene& scene, const Geometry& geometry, Structure& structure);

}  // namespace raig
