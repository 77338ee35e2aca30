/// The scene's triangles and spheres in the world, each instance written out: what rays meet.
#pragma once

#include "base/triangle.hpp"
#include "scene/scene.hpp"

#include <optional>
#include <span>

namespace raig {

/// World-space primitives of all instances, in order of instance, then of the mesh's primitives: the index here is the
/// global id by which ties are settled. World positions are rounded once, from a product in double precision.
/// An instance that mirrors keeps its fronts: corners 1 and 2 of its triangles, and so u and v, change places there.
/// Vertices are stored once an instance. `normals`, `uvs` and `colors` are empty if no mesh has them.
struct Geometry {
    std::vector<vec3> positions;
    std::vector<vec3> normals;          ///< unit, or zero where the mesh has none: use the face's own
    std::vector<vec2> uvs;
    std::vector<vec3> colors;
    std::vector<uvec3> triangles;  ///< by global id; of a sphere (its index in `spheres`, noVertex, noVertex)
    std::vector<Sphere> spheres;
    std::vector<uint32_t> materials;      ///< one a primitive
    std::vector<uint32_t> firstTriangle;  ///< id of each instance's first primitive, and the total at the end
    Box bounds;                           ///< of the usable primitives
    Dropped dropped;

    static constexpr uint32_t noVertex = 0xffffffffu;
    bool isSphere(uint32_t id) const { return triangles[id].y == noVertex; }
    const Sphere& sphere(uint32_t id) const { return spheres[triangles[id].x]; }
    size_t triangleCount() const { return triangles.size() - spheres.size(); }

    struct Place {
        uint32_t instance;
        uint32_t primitive;
    };
    /// The instance and the primitive of its mesh that global primitive `index` is. Cost O(log instances).
    Place place(uint32_t index) const;
};

/// Where an instance puts a vertex: the product in double precision, rounded once.
inline vec3 placePoint(const dmat4& toWorld, const vec3& point) { return vec3(dvec3(toWorld * dvec4(point, 1.0))); }

/// The factor by which a transform scales all lengths; nothing if they differ by more than 2^-16 of it, as rounded rotations
/// do not. 0 for one that maps everything to a point.
std::optional<double> uniformScale(const dmat4& toWorld);

/// Where an instance puts a sphere: the centre as a vertex, the radius in double precision, rounded once.
/// Requires a uniform scale.
Sphere placeSphere(const dmat4& toWorld, const Sphere& sphere);

/// Writes out every instance. Cost O(primitives). Throws limitError beyond 2^31 - 2 primitives.
Geometry flatten(const Scene& scene);

}  // namespace raig
