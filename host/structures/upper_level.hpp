/// The upper of two levels as it lies in memory (shaders/shared/structure.glsl): the top tree, the records of instances and
/// of bottoms, and the header. All of it follows from the scene and the bottoms' headers and sizes.
#pragma once

#include "structures/two_level_plan.hpp"

namespace raig {

/// Where the parts lie in the array of nodes, in uvec4; the top tree at 0, and the bottoms' nodes from `end` on.
struct UpperPlaces {
    uint64_t topTreeEnd = 0;
    uint64_t instances = 0;
    uint64_t bottoms = 0;
    uint64_t end = 0;
};

UpperPlaces upperPlaces(uint64_t instances, uint64_t bottoms);

/// What the upper level has of a bottom.
struct BottomShape {
    StructureHeader header;
    uint64_t nodes = 0, triangles = 0;  ///< uvec4 in its arrays
};

struct UpperLevel {
    UpperPlaces places;
    std::vector<uvec4> nodes;  ///< up to places.end
    StructureHeader header;
    std::vector<Bottom> bottoms;
    uint32_t instances = 0;
    uint32_t nodeCount = 0;      ///< of one copy of the top tree
    uint32_t depth = 0;          ///< of the top tree
    double sahCost = 0.0;        ///< of the top tree
    std::vector<double> visits;  ///< of each bottom: how often a random ray through the scene meets its instances
};

/// `shapes` are of the bottoms of plan.meshes, in this order. Requires that there be some; headers as builders make them;
/// and less than 2^32 nodes and triangles with those of the bottoms.
UpperLevel makeUpperLevel(const PlacedScene& scene, const TwoLevelPlan& plan, std::span<const BottomShape> shapes);

}  // namespace raig
