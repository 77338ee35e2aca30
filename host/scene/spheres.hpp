/// Spheres that are none in the world.
#pragma once

#include "scene/scene.hpp"

namespace raig {

/// Replaces the spheres of instances that do not scale all lengths alike by meshes of 64 x 32 faces, placed as the rest of
/// their mesh: such a mesh is copied once, its primitives' numbers change there. Returns how many spheres were replaced, by
/// instance. Cost O(instances), and 3,968 triangles a sphere of a copied mesh. Requires that meshes are numbered as in
/// `file`. Throws limitError, with the mesh's place in `file`, before the copies would hold more than 2^21 such triangles.
size_t writeOutDeformedSpheres(Scene& scene, const std::string& file);

}  // namespace raig
