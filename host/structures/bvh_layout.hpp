/// How a tree lies in memory for each of the walks of bvh (see structures/bvh.hpp).
#pragma once

#include "structures/bvh_builders.hpp"
#include "structures/structure.hpp"

namespace raig::bvh {

/// Fills in structure.nodes, walk, header.walk and the grid of header, as `params` asks for; a remark where the memory
/// budget allows one copy of the tree only. Requires header.lo, hi and nodeCount, and options that bvh offers, the
/// arity among them.
/// Throws limitError if the nodes and references exceed the budget all the same.
/// O(nodes), the octants in parallel; other bounds than boxes take O(depth) looks at each triangle.
void layOut(const BinaryTree& tree, std::span<const Primitive> triangles, const BuildParams& params, Structure& structure);

/// Sets the grid of 16-bit planes over lo and hi: q stands for origin + q * step, so that 0 lies at or below lo and 65535 at
/// or above hi.
void setGrid(StructureHeader& header);

/// One node as it lies in memory, read back. Must not outlive the structure.
class LaidNode {
public:
    LaidNode(const Structure& structure, uint32_t octant, uint32_t index);

    uint32_t word() const;
    /// True if the bound holds the primitive, in the structure's unit, exactly (other bounds than boxes: in double).
    bool holds(const Primitive& primitive) const;
    /// False if a number of another bound than a box is too large, or an axis too long, for the margins of the walk.
    bool isTame() const;
    struct Extent {
        dvec3 lo, hi;
    };
    /// The box, exactly. Requires a walk whose bounds are boxes.
    Extent extent() const;

private:
    bool holds(const vec3& centre, float radius) const;

    const StructureHeader& header_;
    uint32_t octant_;
    const uvec4* texels_;
};

/// The number of copies of the tree: 1 or 8.
uint32_t copies(const Structure& structure);

/// Of a node: 1, 2 or 4, by header.walk.
uint32_t nodeTexels(const StructureHeader& header);

/// Throws limitError if that many texels of nodes, with the references, exceed the budget.
void checkBudget(uint64_t texels, const BinaryTree& tree, uint64_t memoryBudget);

/// Bytes of the references as walks read them.
uint64_t referenceBytes(const BinaryTree& tree);

/// Nodes of each copy with those at its end that stop a walk.
inline size_t nodesACopy(const StructureHeader& header) {
    return size_t{header.nodeCount} + shared::BVH_END_NODES;
}

inline constexpr uint32_t leafBit = 0x80000000u;

}  // namespace raig::bvh
