/// Which instances and triangles of a mesh can be kept in two levels, and where the instances lie.
#pragma once

#include "structures/two_level.hpp"

namespace raig {

/// An instance that is kept.
struct KeptInstance {
    uint32_t instance = 0;     ///< of PlacedScene::instances
    shared::Placement inner;   ///< from the bottom's unit to the scene's
    Box box;                   ///< around the triangles of the bottom, in the world
};

/// What is kept of a mesh: nothing if there are no instances.
struct KeptMesh {
    std::vector<KeptInstance> instances;
    std::vector<uint8_t> included;  ///< one a triangle of the mesh: 1 if it is in the bottom
    Box bounds;                     ///< of those
};

/// Looks at mesh `index` and its instances. O(vertices and triangles of the mesh, times instances).
KeptMesh keepMesh(const PlacedScene& scene, uint32_t index, std::span<const uint32_t> instances, float sceneUnit);

/// The triangle of the mesh in the world, as it would be written out.
Triangle writtenOut(const PlacedScene& scene, const PlacedMesh& placed, uint32_t triangle);

}  // namespace raig
