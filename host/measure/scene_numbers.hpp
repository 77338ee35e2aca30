/// What a scene is like, in the numbers that decide which structure suits it.
#pragma once

#include "scene/geometry.hpp"
#include "structures/structure.hpp"

#include <string>
#include <vector>

namespace raig {

/// A primitive's extent is the longest side of its bounding box.
struct SceneNumbers {
    uint64_t triangles = 0;
    uint64_t spheres = 0;
    uint64_t usable = 0;  ///< triangles and spheres
    Box bounds;  ///< of the usable ones
    float largestExtent = 0.0f;
    float medianExtent = 0.0f;
    /// How many triangles, itself included, have their centres in the same cell as one of them has, on average, in a uniform
    /// grid of as many cells: some cube root of their number where they are spread evenly over surfaces.
    double crowding = 0.0;

    /// Largest to median extent; 1 without triangles.
    double sizesRatio() const;
    /// True where one uniform grid is slow ("teapot in a stadium"): its cells, fine enough for the scene, hold many times
    /// more triangles where these are than evenly spread ones would leave there.
    bool isUneven() const;
};

/// Cost O(n log n), in parallel in part.
SceneNumbers measureScene(std::span<const Primitive> triangles);

/// What the scene uses beyond plain triangles, in words that stay the same: "textures", "mirrors", "spot lights" ... Of the
/// materials, only those count that a triangle has.
std::vector<std::string> featuresOf(const Scene& scene, const Geometry& geometry);

/// How many materials a triangle has.
uint32_t countUsedMaterials(const Scene& scene, const Geometry& geometry);

}  // namespace raig
