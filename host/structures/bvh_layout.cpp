#include "structures/bvh_layout.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <bit>

namespace raig::bvh {

namespace {

constexpr float gridSteps = 65535.0f;

uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}

/// The grid of 16-bit planes: q stands for origin + q * step, so that 0 lies at or below lo and 65535 at or above hi.
void setGrid(StructureHeader& header) {
    const vec3 extent = header.hi - header.lo;
    const float widest = std::max({extent.x, extent.y, extent.z});
    for (int axis = 0; axis < 3; ++axis) {
        // A flat axis gets steps too, small ones; one part in 2^20 makes up for all rounding here.
        header.gridStep[axis] = std::max(extent[axis], widest * 0x1p-16f) / gridSteps * (1.0f + 0x1p-20f);
        header.gridOrigin[axis] = header.lo[axis];
    }
}

/// The largest q at or below, or the smallest at or above, a coordinate: exact in double.
uint32_t quantise(double coordinate, double origin, double step, bool upwards) {
    const double q = (coordinate - origin) / step;
    double whole = upwards ? std::ceil(q) : std::floor(q);
    if (upwards && origin + whole * step < coordinate) whole += 1.0;
    if (!upwards && origin + whole * step > coordinate) whole -= 1.0;
    return static_cast<uint32_t>(std::clamp(whole, 0.0, 65535.0));
}

/// A box as 16-bit planes: of each axis the lower one, and the upper one << 16.
uvec3 quantised(const Box& sceneBox, const StructureHeader& header) {
    uvec3 planes(0u);
    for (int axis = 0; axis < 3; ++axis) {
        const double origin = header.gridOrigin[axis], step = header.gridStep[axis];
        planes[axis] = quantise(sceneBox.lo[axis] * header.unit, origin, step, false) |
                       quantise(sceneBox.hi[axis] * header.unit, origin, step, true) << 16;
    }
    return planes;
}

bool isNegative(uint32_t octant, int axis) {
    return ((octant >> axis) & 1u) != 0;
}

/// Writes one copy of the tree, depth first, children in the order that suits `octant`.
class CopyWriter {
public:
    CopyWriter(const BinaryTree& tree, std::span<const uvec3> planes, Structure& structure, uint32_t octant)
        : tree_(tree), planes_(planes), structure_(structure), octant_(octant) {}

    void write() {
        std::vector<uint32_t> pending{0};
        std::vector<uint32_t> open;     // inner nodes written whose subtree is not complete
        std::vector<uint32_t> waiting;  // how many children each of them still waits for
        uint32_t next = 0;
        while (!pending.empty()) {
            const uint32_t index = pending.back();
            pending.pop_back();
            const BinaryNode& node = tree_.nodes[index];
            const uint32_t place = next++;
            if (node.count > 0) {
                put(place, index, leafBit | node.first << 4 | node.count);
                // A complete subtree completes its parent, if that waits for no other child.
                for (; !open.empty() && --waiting.back() == 0; open.pop_back(), waiting.pop_back())
                    setWord(open.back(), next);
                continue;
            }
            put(place, index, 0);
            open.push_back(place);
            waiting.push_back(2);
            const bool swapped = copies(structure_) == 8 && isNegative(octant_, static_cast<int>(node.axis));
            pending.push_back(swapped ? node.left : node.right);
            pending.push_back(swapped ? node.right : node.left);
        }
        RAIG_CHECK_OP(next, ==, structure_.header.nodeCount);
        for (uint32_t i = next; i < next + shared::BVH_END_NODES; ++i) putEnd(i, i);
    }

private:
    size_t offset(uint32_t place) const {
        const size_t node = octant_ * nodesACopy(structure_.header) + place;
        return structure_.header.walk == shared::WALK_OCTANTS16 ? node : node * 2;
    }

    void setWord(uint32_t place, uint32_t word) { structure_.nodes[offset(place)].w = word; }

    void put(uint32_t place, uint32_t index, uint32_t word) {
        if (structure_.header.walk != shared::WALK_OCTANTS16) return putFloats(place, tree_.nodes[index].box, word);
        uvec4& node = structure_.nodes[offset(place)];
        for (int axis = 0; axis < 3; ++axis) {
            const uint32_t planes = planes_[index][axis];
            node[axis] = isNegative(octant_, axis) ? planes >> 16 | planes << 16 : planes;
        }
        node.w = word;
    }

    /// What no ray hits.
    void putEnd(uint32_t place, uint32_t word) {
        if (structure_.header.walk != shared::WALK_OCTANTS16)
            return putFloats(place, Box{vec3(largestCoordinate), vec3(-largestCoordinate)}, word);
        uvec4& node = structure_.nodes[offset(place)];
        for (int axis = 0; axis < 3; ++axis) node[axis] = isNegative(octant_, axis) ? 0xffff0000u : 0x0000ffffu;
        node.w = word;
    }

    void putFloats(uint32_t place, const Box& sceneBox, uint32_t word) {
        const StructureHeader& header = structure_.header;
        const Box box{sceneBox.lo * header.unit, sceneBox.hi * header.unit};
        uvec4* node = structure_.nodes.data() + offset(place);
        for (int axis = 0; axis < 3; ++axis) {
            const bool swapped = header.walk == shared::WALK_OCTANTS && isNegative(octant_, axis);
            node[0][axis] = bits(swapped ? box.hi[axis] : box.lo[axis]);
            node[1][axis] = bits(swapped ? box.lo[axis] : box.hi[axis]);
        }
        node[0].w = word;
        node[1].w = 0;
    }

    const BinaryTree& tree_;
    std::span<const uvec3> planes_;
    Structure& structure_;
    uint32_t octant_;
};

/// True if 16-bit planes bound this tree's leaves well: a grid step is at most half the median leaf's widest extent.
bool gridIsFineEnough(const BinaryTree& tree, const StructureHeader& header) {
    std::vector<float> extents;
    const size_t stride = std::max<size_t>(1, tree.nodes.size() / 65536);
    for (size_t i = 0; i < tree.nodes.size(); i += stride) {
        if (tree.nodes[i].count == 0) continue;
        const vec3 extent = tree.nodes[i].box.extent();
        extents.push_back(std::max({extent.x, extent.y, extent.z}));
    }
    if (extents.empty()) return true;
    std::nth_element(extents.begin(), extents.begin() + extents.size() / 2, extents.end());
    const float step = std::max({header.gridStep.x, header.gridStep.y, header.gridStep.z});
    return step <= 0.5f * extents[extents.size() / 2] * header.unit;
}

uint32_t chooseWalk(std::string_view name, const BinaryTree& tree, const StructureHeader& header) {
    if (name == "skip") return shared::WALK_SKIP;
    if (name == "octants") return shared::WALK_OCTANTS;
    if (name == "octants16") return shared::WALK_OCTANTS16;
    if (name == "auto") return gridIsFineEnough(tree, header) ? shared::WALK_OCTANTS16 : shared::WALK_OCTANTS;
    throw usageError("--walk {}: no such walk of bvh; there are auto, skip, octants, octants16", name);
}

}  // namespace

uint32_t copies(const Structure& structure) {
    return structure.header.walk == shared::WALK_SKIP ? 1 : 8;
}

void layOut(const BinaryTree& tree, std::string_view walk, Structure& structure) {
    static constexpr std::string_view names[] = {"skip", "octants", "octants16"};
    setGrid(structure.header);
    structure.header.walk = chooseWalk(walk, tree, structure.header);
    structure.walk = names[structure.header.walk];
    const size_t nodeTexels = structure.header.walk == shared::WALK_OCTANTS16 ? 1 : 2;
    structure.nodes.resize(copies(structure) * nodesACopy(structure.header) * nodeTexels);
    if (tree.nodes.empty()) return;
    std::vector<uvec3> planes(structure.header.walk == shared::WALK_OCTANTS16 ? tree.nodes.size() : 0);
    parallelFor(planes.size(), 4096, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i)
            if (!tree.nodes[i].box.empty()) planes[i] = quantised(tree.nodes[i].box, structure.header);
    });
    parallelFor(copies(structure), 1, [&](size_t begin, size_t end) {
        for (size_t octant = begin; octant < end; ++octant)
            CopyWriter(tree, planes, structure, static_cast<uint32_t>(octant)).write();
    });
}

LaidNode laidNode(const Structure& structure, uint32_t octant, uint32_t index) {
    const StructureHeader& header = structure.header;
    const size_t node = octant * nodesACopy(header) + index;
    LaidNode result{};
    for (int axis = 0; axis < 3; ++axis) {
        double near, far;
        if (header.walk == shared::WALK_OCTANTS16) {
            const uint32_t word = structure.nodes[node][axis];
            near = header.gridOrigin[axis] + double{header.gridStep[axis]} * (word & 0xffff);
            far = header.gridOrigin[axis] + double{header.gridStep[axis]} * (word >> 16);
        } else {
            near = std::bit_cast<float>(structure.nodes[node * 2][axis]);
            far = std::bit_cast<float>(structure.nodes[node * 2 + 1][axis]);
        }
        const bool swapped = header.walk != shared::WALK_SKIP && isNegative(octant, axis);
        result.lo[axis] = swapped ? far : near;
        result.hi[axis] = swapped ? near : far;
    }
    result.word = structure.nodes[header.walk == shared::WALK_OCTANTS16 ? node : node * 2].w;
    return result;
}

}  // namespace raig::bvh
