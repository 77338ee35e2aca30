/// The scene's triangles in the world, each instance written out: what rays meet.
#pragma once

#include "scene/scene.hpp"

#include <span>

namespace raig {

/// The largest magnitude of a coordinate that rays can meet: beyond it a squared distance overflows a float.
inline constexpr float largestCoordinate = 1.844e18f;

/// World-space triangles of all instances, in order of instance, then of the mesh's triangles: the index here is the
/// global id by which ties are settled. World positions are rounded once, from a product in double precision.
/// Vertices are stored once an instance. `normals`, `uvs` and `colors` are empty if no mesh has them.
struct Geometry {
    std::vector<vec3> positions;
    std::vector<vec3> normals;          ///< unit, or zero where the mesh has none: use the face's own
    std::vector<vec2> uvs;
    std::vector<vec3> colors;
    std::vector<uvec3> triangles;
    std::vector<uint32_t> materials;    ///< one a triangle
    std::vector<uint32_t> firstTriangle;///< of each instance, and the total at the end
    Box bounds;                         ///< of the usable triangles
    Dropped dropped;

    struct Place {
        uint32_t instance;
        uint32_t primitive;
    };
    /// The instance and the triangle of its mesh that global triangle `index` is. Cost O(log instances).
    Place place(uint32_t index) const;
};

/// True if a ray can hit the triangle: corners finite, within largestCoordinate, and not collinear (in exact arithmetic
/// on the float corners, up to rounding in double).
bool isUsable(const vec3& a, const vec3& b, const vec3& c);

/// Writes out every instance. Cost O(triangles). Throws limitError beyond 2^31 - 2 triangles.
Geometry flatten(const Scene& scene);

}  // namespace raig
