/// The layout of bvh whose nodes hold the boxes of all their children (--walk trail): for the walk of
/// shaders/structures/trail.glsl.
///
/// A node has 2, 4 or 8 slots for its children. Only inner nodes are there: a leaf is a word of its parent's, and a tree of
/// one leaf is a node with one child. Nodes are in depth-first order. Texels of a node, by the bits of a plane and the
/// slots:
///
///     32 bits, 2      lo, lo, hi, hi along x; y; z; then the words
///     32 bits, 4      the low planes along x, the high ones; y; z; then the words; and for 8 slots, the same of the others
///     16 bits, 2      lo | hi << 16 along x of both, along y of both; along z of both, then the words
///     16 bits, 4      lo | hi << 16 along x; y; z; then the words; and for 8 slots, the same of the others
///     8 bits          first the node's own grid: its lower corner, and an exponent of 8 bits an axis, biased by 127
///     8 bits, 2       lo, lo, hi, hi along x, y, z, and the first word; the second word, 0, 0, 0
///     8 bits, 4       low planes along x (8 bits a child), high ones; the same along y; the same along z, 0, 0; the words
///     8 bits, 8       as 4, but z of the last four instead of 0, 0; then x and y of these; and their words
///
/// After the nodes, four links a texel: the parent's number << 3 | slot, of each node in turn. A word is a node's number, a
/// leaf as in the other layouts, or noChild. Planes of 16 bits lie on the grid over the scene, as those of the other layouts
/// do; those of 8 bits at corner + q * 2^exponent, with the least exponent that spans the node's box. All are rounded
/// outwards. Source: Ylitie, Karras, Laine 2017, "Efficient Incoherent Ray Traversal on GPUs Through Compressed Wide BVHs"
/// (8 bits).
#pragma once

#include "structures/bvh_layout.hpp"

#include <array>
#include <optional>
#include <string>

namespace raig::bvh {

inline constexpr uint32_t noChild = 0xffffffffu;

/// header.walk for trees of this arity and these bits of a plane.
uint32_t trailWalk(uint32_t arity, uint32_t precision);
inline bool isTrail(const StructureHeader& header) {
    return header.walk >= shared::WALK_TRAIL;
}
uint32_t trailArity(const StructureHeader& header);
uint32_t trailPrecision(const StructureHeader& header);
/// Of a node.
uint32_t trailTexels(const StructureHeader& header);

/// Fills in structure.nodes and header.nodeCount. Requires header.walk, lo, hi and the grid, and a tree of at most that
/// arity. Throws limitError if nodes and references exceed the budget. O(nodes), in parallel but for their numbers.
void layOutTrail(const BinaryTree& tree, uint64_t memoryBudget, Structure& structure);

/// One node as it lies in memory, read back. Must not outlive the structure.
class TrailNode {
public:
    TrailNode(const Structure& structure, uint32_t index);

    uint32_t word(uint32_t slot) const;
    using Extent = LaidNode::Extent;
    /// The box of a child, exactly.
    Extent extent(uint32_t slot) const;
    /// False if the node's own grid reaches farther than is laid: the margins of the walk would not cover its roundings.
    bool isTame() const;

private:
    std::array<uint32_t, 2> planes(uint32_t slot, int axis) const;

    const StructureHeader& header_;
    const uvec4* texels_;
};

/// The word of a child.
uint32_t& trailWord(Structure& structure, uint32_t index, uint32_t slot);

/// The parent << 3 | slot of a node.
uint32_t trailLink(const Structure& structure, uint32_t index);

/// bvh::findFault for this layout, but for the references.
std::optional<std::string> findTrailFault(const Structure& structure, std::span<const Primitive> triangles);

}  // namespace raig::bvh
