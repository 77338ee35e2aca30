/// The promises of scene.hpp, checked: what every importer must deliver and all that follows may rely on.
#pragma once

#include "scene/scene.hpp"

#include <optional>
#include <string>

namespace raig {

/// Names the first broken promise of scene.hpp ("mesh 3: triangle 7 names vertex 12 of 9"), or nothing if all hold.
///
/// Requires  nothing of the scene; it may be uncompleted (no camera, no instance, no triangle).
/// Ensures   with nothing returned: every index (instance, triangle, material, image) is in range; attribute arrays are
/// empty
///           or as long as positions; one material index a triangle, and at least one material; every number but a mesh
///           position is finite; normals are unit length or zero; directions are unit, cameras' axes are orthonormal;
///           toWorld is affine; colours, intensities and distances are not negative; images have 4 bytes a texel.
/// Cost      O(vertices + triangles + texels' bookkeeping); allocates nothing but the message.
std::optional<std::string> findFault(const Scene& scene);

}  // namespace raig
