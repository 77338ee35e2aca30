/// What two levels of a scene are made of: which instances are kept, and which primitives each bottom is built over.
#pragma once

#include "structures/kept_mesh.hpp"

namespace raig {

/// What is written out: primitives in the world, all usable, and their ids.
struct WrittenOut {
    std::vector<Primitive> primitives;
    std::vector<uint32_t> ids;
};

struct TwoLevelPlan {
    float unit = 1.0f;           ///< the scene's
    std::vector<KeptMesh> kept;  ///< one a mesh
    WrittenOut out;
    std::vector<uint32_t> meshes;  ///< of each bottom; Bottom::writtenOut comes first, if anything is

    /// True if no instance is kept: then what is written out is all, if there is anything.
    bool isOneLevel() const { return meshes.empty() || (meshes.size() == 1 && meshes.front() == Bottom::writtenOut); }
    /// Of all instances in the upper level; what is written out is one.
    uint64_t instanceCount() const;
};

/// Pure: it depends on nothing but the scene. O(triangles, all places counted).
TwoLevelPlan planTwoLevels(const PlacedScene& scene);

/// What the bottom of `mesh` is built over, ids being indices: what is written out; or the mesh's own triangles, where those
/// that are not included are such that every builder leaves them out. The result is in the plan, or in `storage`.
std::span<const Primitive> primitivesUnder(const PlacedScene& scene, const TwoLevelPlan& plan, uint32_t mesh,
                                           std::vector<Primitive>& storage);

}  // namespace raig
