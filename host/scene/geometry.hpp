/// The scene's triangles and spheres in the world: what rays meet.
#pragma once

#include "base/triangle.hpp"
#include "scene/placement.hpp"
#include "scene/scene.hpp"

#include <optional>
#include <span>

namespace raig {

/// Primitives of all instances, in order of instance, then of the mesh's primitives: the index in this order is the global
/// id by which ties are settled. World positions and normals are those of shaders/shared/place.glsl.
/// An instance that mirrors keeps its fronts: corners 1 and 2 of its triangles, and so u and v, change places there.
///
/// Written out (flatten), the arrays hold every instance's vertices and primitives, in the world: the index of a primitive
/// is its global id. As instances (gatherInstances), they hold every mesh once, in its own space, corners in the mesh's
/// order, and `placed` says where it stands; only spheres are in the world in either form, each instance's.
/// `normals`, `tangents`, `uvs`, `moreUvs`, `colors` and `alphas` are empty if no mesh has them.
struct Geometry {
    std::vector<vec3> positions;
    std::vector<vec3> normals;            ///< unit, or zero where the mesh has none: use the face's own
    std::vector<vec4> tangents;           ///< as a mesh's; zero where it has none
    std::vector<vec2> uvs;
    std::vector<vec2> moreUvs;
    std::vector<vec3> colors;
    std::vector<float> alphas;
    std::vector<uvec3> triangles;         ///< of a sphere (its index, noVertex, noVertex), in `spheres` or, kept, the mesh
    std::vector<Sphere> spheres;
    std::vector<uint32_t> materials;      ///< one a primitive
    std::vector<uint32_t> firstTriangle;  ///< id of each instance's first primitive, and the total at the end
    Box bounds;                           ///< of the usable primitives, in the world
    Dropped dropped;

    /// What is stored of a mesh: ranges of the arrays.
    struct Stored {
        uint32_t firstVertex = 0, vertices = 0;
        uint32_t firstTriangle = 0, triangles = 0;
        uint32_t spheres = 0;  ///< their entries follow the triangles'
    };
    /// One a scene's instance.
    struct Placed {
        uint32_t mesh = 0;
        uint32_t firstSphere = 0;
        bool mirrored = false;
        Placement placement;
        NormalPlacement normalPlacement;
    };
    std::vector<Stored> stored;  ///< one a mesh of the scene; empty if written out
    std::vector<Placed> placed;  ///< empty if written out

    static constexpr uint32_t noVertex = 0xffffffffu;
    bool isInstanced() const { return !stored.empty(); }
    uint32_t primitiveCount() const { return firstTriangle.empty() ? 0 : firstTriangle.back(); }
    size_t triangleCount() const { return primitiveCount() - spheres.size(); }

    /// Of a primitive with this id. Requires the form that is written out.
    bool isSphere(uint32_t id) const { return triangles[id].y == noVertex; }
    const Sphere& sphere(uint32_t id) const { return spheres[triangles[id].x]; }

    struct Place {
        uint32_t instance;
        uint32_t primitive;
    };
    /// The instance and the primitive of its mesh that global primitive `index` is. Cost O(log instances).
    Place place(uint32_t index) const;
    /// The index in `triangles` and `materials` of a place.
    size_t storedTriangle(const Place& place) const;
    bool isSphere(const Place& place) const { return triangles[storedTriangle(place)].y == noVertex; }
    /// The corners, in the world, of a triangle.
    struct Corners {
        vec3 a, b, c;
    };
    Corners corners(const Place& place) const;
};

/// The factor by which a transform scales all lengths; nothing if they differ by more than 2^-16 of it, as rounded rotations
/// do not. 0 for one that maps everything to a point.
std::optional<double> uniformScale(const dmat4& toWorld);

/// Where an instance puts a sphere: the centre as a vertex, the radius in double precision, rounded once.
/// Requires a uniform scale.
Sphere placeSphere(const dmat4& toWorld, const Sphere& sphere);

/// Throws limitError if the instances have more than 2^31 - 2 primitives in all: no structure can number them. Cost
/// O(instances).
void checkPrimitiveCount(const Scene& scene);

/// Writes out every instance. Cost O(primitives). Throws limitError as checkPrimitiveCount does, and beyond 2^32 - 3
/// vertices.
Geometry flatten(const Scene& scene);

/// Keeps every instance. The same ids, bounds and counts as flatten's. Cost O(primitives, written out), memory O(triangles
/// of the meshes, and spheres written out). Throws limitError as flatten does, but counts a mesh's vertices once.
Geometry gatherInstances(const Scene& scene);

}  // namespace raig
