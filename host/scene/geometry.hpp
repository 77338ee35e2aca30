/// The scene's triangles in the world, each instance written out: what rays meet.
#pragma once

#include "base/triangle.hpp"
#include "scene/scene.hpp"

#include <span>

namespace raig {

/// World-space triangles of all instances, in order of instance, then of the mesh's triangles: the index here is the
/// global id by which ties are settled. World positions are rounded once, from a product in double precision.
/// An instance that mirrors keeps its fronts: corners 1 and 2 of its triangles, and so u and v, change places there.
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

/// Where an instance puts a vertex: the product in double precision, rounded once.
inline vec3 placePoint(const dmat4& toWorld, const vec3& point) { return vec3(dvec3(toWorld * dvec4(point, 1.0))); }

/// Writes out every instance. Cost O(triangles). Throws limitError beyond 2^31 - 2 triangles.
Geometry flatten(const Scene& scene);

}  // namespace raig
