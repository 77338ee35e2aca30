#include "structures/top_tree.hpp"

#include "structures/bvh_builders.hpp"

#include <algorithm>
#include <bit>

namespace raig {

namespace {

constexpr size_t mostForSweep = 4096;
constexpr size_t mostForCopies = size_t{1} << 16;  // 32 MiB

uint32_t copiesOf(uint64_t boxes) {
    return boxes <= mostForCopies ? 8 : 1;
}

uvec4 texel(const vec3& v, uint32_t word) {
    return {std::bit_cast<uint32_t>(v.x), std::bit_cast<uint32_t>(v.y), std::bit_cast<uint32_t>(v.z), word};
}

BinaryTree buildTree(std::span<const Box> boxes) {
    std::vector<BoxReference> references;
    for (uint32_t i = 0; i < boxes.size(); ++i) references.push_back({boxes[i].lo, i, boxes[i].hi, 0});
    const SahCosts costs{};
    return boxes.size() <= mostForSweep ? buildSweepSah(std::move(references), 1, costs)
                                        : buildBinnedSah(std::move(references), 1, costs);
}

/// Writes one copy, depth first, the child that is nearer in `octant` first. Returns the depth.
uint32_t writeCopy(const BinaryTree& tree, float unit, uint32_t octant, std::span<uvec4> nodes) {
    struct Entry {
        uint32_t node, depth;
        uint32_t parent;  ///< whose subtree it ends: its place; or none
    };
    constexpr uint32_t none = 0xffffffffu;
    std::vector<Entry> pending{{0, 1, none}};
    std::vector<uint32_t> ends(nodes.size() / 2, none);  // of each node: the ancestor whose subtree ends with its own
    uint32_t next = 0, depth = 0;
    while (!pending.empty()) {
        const Entry at = pending.back();
        pending.pop_back();
        depth = std::max(depth, at.depth);
        const BinaryNode& node = tree.nodes[at.node];
        const uint32_t place = next++;
        ends[place] = at.parent;
        nodes[2 * place] = texel(node.box.lo * unit, 0);
        nodes[2 * place + 1] = texel(node.box.hi * unit, 0);
        if (node.count > 0) {
            nodes[2 * place].w = shared::TOP_LEAF | tree.references[node.first].id;
            for (uint32_t done = at.parent; done != none; done = ends[done]) nodes[2 * done].w = next;
            continue;
        }
        const bool swapped = (octant >> node.axis & 1) != 0;
        pending.push_back({swapped ? node.left : node.right, at.depth + 1, place});
        pending.push_back({swapped ? node.right : node.left, at.depth + 1, none});
    }
    return depth;
}

}  // namespace

uint64_t topTreeBytes(uint64_t boxes) {
    return 2 * sizeof(uvec4) * copiesOf(boxes) * (2 * boxes - 1);
}

TopTree buildTopTree(std::span<const Box> boxes, float unit) {
    const BinaryTree tree = buildTree(boxes);
    TopTree top;
    top.nodeCount = static_cast<uint32_t>(2 * boxes.size() - 1);
    const uint32_t copies = copiesOf(boxes.size());
    top.apart = copies == 8 ? top.nodeCount : 0;
    top.nodes.resize(size_t{2} * copies * top.nodeCount);
    for (uint32_t octant = 0; octant < copies; ++octant)
        top.depth = writeCopy(tree, unit, octant, std::span(top.nodes).subspan(size_t{2} * octant * top.nodeCount,
                                                                               size_t{2} * top.nodeCount));
    const double whole = std::max(double{tree.nodes[0].box.halfArea()}, 1e-300);
    top.visits.resize(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i) top.visits[i] = boxes[i].halfArea() / whole;
    std::vector<uint32_t> pending{0};
    while (!pending.empty()) {
        const BinaryNode& node = tree.nodes[pending.back()];
        pending.pop_back();
        top.sahCost += node.box.halfArea() / whole;
        if (node.count == 0) pending.insert(pending.end(), {node.left, node.right});
    }
    return top;
}

}  // namespace raig
