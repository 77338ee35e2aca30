/// Two levels: a structure for each mesh that stands in several places, and a tree over the places.
///
/// Memory grows with the triangles that are stored and with the places, not with the triangles that the scene would have
/// written out; and each ray gets the same hit, to the bit, as from the scene written out. For that, triangles are placed
/// while tracing, by the very formula that writes instances out (shaders/shared/place.glsl), and tested in the world. Only
/// bounds are walked in a mesh's own space, with slack for what rounds on the way (shaders/instances.glsl).
///
/// What cannot be kept so is written out, into one more structure of the same kind:
///   - spheres, which take no more than an instance;
///   - meshes that stand in one place, or that the caller does not want kept;
///   - instances whose transform cannot be inverted, or so badly that the slack would swell (fits() in instance_record.hpp);
///   - triangles that are usable in some places of their mesh only (rounding may make slivers collinear, or keep them from
///     it), and those whose placing, in the structure's units of length, would leave the range of normal floats.
///
/// The layout is described in shaders/shared/structure.glsl; all structures of registry.def can be the bottoms.
/// Source: Wald, Benthin, Slusallek 2003, "Distributed Interactive Ray Tracing of Dynamic Scenes" (two levels).
#pragma once

#include "structures/structure.hpp"

namespace raig {

namespace shared {
#include "shared/place.glsl"
}  // namespace shared

/// A mesh in its own space: `triangles` name vertices of PlacedScene::positions, of which it uses
/// [firstVertex, firstVertex + vertices).
struct StoredMesh {
    std::span<const uvec3> triangles;
    uint32_t firstVertex = 0;
    uint32_t vertices = 0;
    bool keeps = true;  ///< false: its instances are to be written out
};

/// A mesh in its place. Its triangles have the ids from firstId on.
struct PlacedMesh {
    uint32_t mesh = 0;
    uint32_t firstId = 0;
    shared::Placement placement;
    bool mirrored = false;
};

/// What is written out in any case: a sphere of some instance, in the world.
struct PlacedPrimitive {
    Primitive primitive;
    uint32_t id = 0;
};

struct PlacedScene {
    std::span<const vec3> positions;
    std::vector<StoredMesh> meshes;
    std::vector<PlacedMesh> instances;
    std::vector<PlacedPrimitive> others;
    Box bounds;                   ///< of all usable primitives, in the world
    uint32_t leastTriangles = 1;  ///< that a mesh has which keeps: the rule by which StoredMesh::keeps was set; at least 1
};

/// Builds both levels, the bottoms by `type`; or, where nothing is kept, the one level of what is written out.
/// O(triangles, all places counted) time; memory for the triangles stored and written out, and some 0.2 to 1 kB an
/// instance, of which what walks read counts in the memory budget. Throws what the builder throws, and limitError where the
/// arrays exceed 2^32 elements or the budget.
Structure buildTwoLevels(const PlacedScene& scene, const StructureType& type, const BuildParams& params);

}  // namespace raig
