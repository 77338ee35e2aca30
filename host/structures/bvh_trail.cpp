#include "structures/bvh_trail.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/bvh_layout.hpp"

#include <algorithm>
#include <bit>
#include <cmath>

namespace raig::bvh {

namespace {

// The node's own grid of 8-bit planes: the exponents of its steps.
constexpr int leastExponent = -100;  // what is flat gets a step that adds nothing
constexpr int bias = 127;

uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
}
float number(uint32_t bits) {
    return std::bit_cast<float>(bits);
}

/// The least exponent at which 255 steps span the extent.
int exponentFor(double extent) {
    int exponent = extent > 0.0 ? std::max(std::ilogb(extent / 255.0), leastExponent) : leastExponent;
    while (std::ldexp(255.0, exponent) < extent) ++exponent;
    return exponent;
}

/// The largest q at or below, or the smallest at or above, a coordinate.
uint32_t planeOf(double coordinate, double origin, double step, double most, bool upwards) {
    double q =
        std::clamp(upwards ? std::ceil((coordinate - origin) / step) : std::floor((coordinate - origin) / step), 0.0, most);
    if (upwards && origin + q * step < coordinate) q += 1.0;
    if (!upwards && origin + q * step > coordinate) q -= 1.0;
    return static_cast<uint32_t>(std::clamp(q, 0.0, most));
}

/// Where a word of the node is: its texel and its component.
struct At {
    uint32_t texel, component;
};

At wordAt(const StructureHeader& header, uint32_t slot) {
    const uint32_t arity = trailArity(header), group = slot / 4;
    switch (trailPrecision(header)) {
        case 32:
            return arity == 2 ? At{3, slot} : At{group * 7 + 6, slot % 4};
        case 16:
            return arity == 2 ? At{1, 2 + slot} : At{group * 4 + 3, slot % 4};
        default:
            return arity == 2 ? (slot == 0 ? At{1, 3} : At{2, 0}) : At{3 + group * 2, slot % 4};
    }
}

/// Where planes of 8 bits of four children are, along an axis and on a side; those of two children are as these in one word.
At bytesAt(uint32_t group, int axis, int side) {
    if (axis == 2) return {2, group * 2 + static_cast<uint32_t>(side)};
    return {group == 0 ? 1u : 4u, static_cast<uint32_t>(axis * 2 + side)};
}

/// The box of a node or leaf in the unit of the structure.
Box inUnit(const Box& box, float unit) {
    return {box.lo * unit, box.hi * unit};
}

/// Writes the nodes of a tree whose order is known.
class NodeWriter {
public:
    explicit NodeWriter(Structure& structure)
        : structure_(structure), header_(structure.header), arity_(trailArity(header_)) {}

    void write(uint32_t index, std::span<const Box> boxes, std::span<const uint32_t> words) const {
        uvec4* texels = structure_.nodes.data() + size_t{index} * trailTexels(header_);
        for (uint32_t slot = 0; slot < arity_; ++slot) {
            const At at = wordAt(header_, slot);
            texels[at.texel][static_cast<int>(at.component)] = slot < words.size() ? words[slot] : noChild;
        }
        switch (trailPrecision(header_)) {
            case 32:
                return writeFloats(texels, boxes);
            case 16:
                return writeHalves(texels, boxes);
            default:
                return writeBytes(texels, boxes);
        }
    }

private:
    void writeFloats(uvec4* texels, std::span<const Box> boxes) const {
        for (uint32_t slot = 0; slot < boxes.size(); ++slot)
            for (int axis = 0; axis < 3; ++axis) {
                const uint32_t lo = bits(boxes[slot].lo[axis]), hi = bits(boxes[slot].hi[axis]);
                const int lane = static_cast<int>(slot % 4);
                if (arity_ == 2) {
                    texels[axis][lane] = lo;
                    texels[axis][lane + 2] = hi;
                } else {
                    texels[slot / 4 * 7 + axis * 2u][lane] = lo;
                    texels[slot / 4 * 7 + axis * 2u + 1][lane] = hi;
                }
            }
    }

    void writeHalves(uvec4* texels, std::span<const Box> boxes) const {
        for (uint32_t slot = 0; slot < boxes.size(); ++slot)
            for (int axis = 0; axis < 3; ++axis) {
                const double origin = header_.gridOrigin[axis], step = header_.gridStep[axis];
                const uint32_t pair = planeOf(boxes[slot].lo[axis], origin, step, 65535.0, false) |
                                      planeOf(boxes[slot].hi[axis], origin, step, 65535.0, true) << 16;
                if (arity_ == 2)
                    texels[axis / 2][static_cast<int>(slot) + axis % 2 * 2] = pair;
                else
                    texels[slot / 4 * 4 + static_cast<uint32_t>(axis)][static_cast<int>(slot % 4)] = pair;
            }
    }

    void writeBytes(uvec4* texels, std::span<const Box> boxes) const {
        Box node;
        for (const Box& box : boxes) node.grow(box);
        for (int axis = 0; axis < 3; ++axis) {
            const int exponent = exponentFor(double{node.hi[axis]} - node.lo[axis]);
            const double origin = node.lo[axis], step = std::ldexp(1.0, exponent);
            texels[0][axis] = bits(node.lo[axis]);
            texels[0].w |= static_cast<uint32_t>(exponent + bias) << 8 * axis;
            for (uint32_t slot = 0; slot < boxes.size(); ++slot)
                for (int side = 0; side < 2; ++side) {
                    const double plane = side == 0 ? boxes[slot].lo[axis] : boxes[slot].hi[axis];
                    const uint32_t q = planeOf(plane, origin, step, 255.0, side == 1);
                    const At at = arity_ == 2 ? At{1, static_cast<uint32_t>(axis)} : bytesAt(slot / 4, axis, side);
                    const uint32_t place = arity_ == 2 ? slot + 2u * static_cast<uint32_t>(side) : slot % 4;
                    texels[at.texel][static_cast<int>(at.component)] |= q << 8 * place;
                }
        }
    }

    Structure& structure_;
    const StructureHeader& header_;
    uint32_t arity_;
};

/// The tree's inner nodes in depth-first order, and where each node of the tree is in it.
struct Order {
    std::vector<uint32_t> nodes;
    std::vector<uint32_t> places;  ///< by index in the tree
    std::vector<uint32_t> links;
};

Order orderOf(const BinaryTree& tree) {
    Order order;
    order.places.resize(tree.nodes.size());
    struct Pending {
        uint32_t node, link;
    };
    std::vector<Pending> pending{{0, 0}};
    while (!pending.empty()) {
        const Pending next = pending.back();
        pending.pop_back();
        const auto place = static_cast<uint32_t>(order.nodes.size());
        order.places[next.node] = place;
        order.nodes.push_back(next.node);
        order.links.push_back(next.link);
        const std::span<const uint32_t> children = tree.childrenOf(tree.nodes[next.node]);
        for (size_t slot = children.size(); slot-- > 0;)
            if (tree.nodes[children[slot]].count == 0)
                pending.push_back({children[slot], place << 3 | static_cast<uint32_t>(slot)});
    }
    return order;
}

uint32_t leafWord(const BinaryNode& leaf) {
    return leafBit | leaf.first << 4 | leaf.count;
}

/// As many texels as hold a link of each node.
size_t linkTexels(const StructureHeader& header) {
    return (size_t{header.nodeCount} + 3) / 4;
}

}  // namespace

uint32_t trailWalk(uint32_t arity, uint32_t precision) {
    return shared::WALK_TRAIL +
           (precision == 32   ? 0
            : precision == 16 ? 3
                              : 6) +
           static_cast<uint32_t>(std::bit_width(arity)) - 2;
}

uint32_t trailArity(const StructureHeader& header) {
    return 2u << ((header.walk - shared::WALK_TRAIL) % 3);
}

uint32_t trailPrecision(const StructureHeader& header) {
    return 32u >> (header.walk - shared::WALK_TRAIL) / 3;
}

uint32_t trailTexels(const StructureHeader& header) {
    const uint32_t arity = trailArity(header);
    switch (trailPrecision(header)) {
        case 32:
            return arity == 2 ? 4 : arity / 4 * 7;
        case 16:
            return arity;
        default:
            return arity / 2 + 2;
    }
}

void layOutTrail(const BinaryTree& tree, uint64_t memoryBudget, Structure& structure) {
    StructureHeader& header = structure.header;
    const bool isLeaf = !tree.nodes.empty() && tree.nodes[0].count > 0;
    const Order order = tree.nodes.empty() || isLeaf ? Order{} : orderOf(tree);
    header.nodeCount = isLeaf ? 1 : static_cast<uint32_t>(order.nodes.size());
    const size_t texels = size_t{header.nodeCount} * trailTexels(header) + linkTexels(header);
    checkBudget(texels, tree, memoryBudget);
    structure.nodes.assign(texels, uvec4(0));
    if (tree.nodes.empty()) return;
    const NodeWriter writer(structure);
    if (isLeaf) {
        const Box box = inUnit(tree.nodes[0].box, header.unit);
        const uint32_t word = leafWord(tree.nodes[0]);
        return writer.write(0, std::span(&box, 1), std::span(&word, 1));
    }
    parallelFor(order.nodes.size(), 1024, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            std::array<Box, 8> boxes;
            std::array<uint32_t, 8> words;
            const std::span<const uint32_t> children = tree.childrenOf(tree.nodes[order.nodes[i]]);
            for (size_t slot = 0; slot < children.size(); ++slot) {
                const BinaryNode& child = tree.nodes[children[slot]];
                boxes[slot] = inUnit(child.box, header.unit);
                words[slot] = child.count > 0 ? leafWord(child) : order.places[children[slot]];
            }
            writer.write(static_cast<uint32_t>(i), std::span(boxes).first(children.size()),
                         std::span(words).first(children.size()));
        }
    });
    uvec4* const links = structure.nodes.data() + size_t{header.nodeCount} * trailTexels(header);
    for (size_t i = 0; i < order.links.size(); ++i) links[i / 4][static_cast<int>(i % 4)] = order.links[i];
}

TrailNode::TrailNode(const Structure& structure, uint32_t index)
    : header_(structure.header), texels_(structure.nodes.data() + size_t{index} * trailTexels(structure.header)) {}

uint32_t TrailNode::word(uint32_t slot) const {
    const At at = wordAt(header_, slot);
    return texels_[at.texel][static_cast<int>(at.component)];
}

std::array<uint32_t, 2> TrailNode::planes(uint32_t slot, int axis) const {
    const uint32_t arity = trailArity(header_), group = slot / 4;
    const int lane = static_cast<int>(slot % 4);
    switch (trailPrecision(header_)) {
        case 32: {
            if (arity == 2) return {texels_[axis][lane], texels_[axis][lane + 2]};
            const uvec4* const texels = texels_ + group * 7 + axis * 2u;
            return {texels[0][lane], texels[1][lane]};
        }
        case 16: {
            const uint32_t pair =
                arity == 2 ? texels_[axis / 2][lane + axis % 2 * 2] : texels_[group * 4 + static_cast<uint32_t>(axis)][lane];
            return {pair & 0xffff, pair >> 16};
        }
        default: {
            if (arity == 2) return {texels_[1][axis] >> 8 * lane & 255u, texels_[1][axis] >> (16 + 8 * lane) & 255u};
            const At lo = bytesAt(group, axis, 0), hi = bytesAt(group, axis, 1);
            return {texels_[lo.texel][static_cast<int>(lo.component)] >> 8 * lane & 255u,
                    texels_[hi.texel][static_cast<int>(hi.component)] >> 8 * lane & 255u};
        }
    }
}

TrailNode::Extent TrailNode::extent(uint32_t slot) const {
    Extent result{};
    for (int axis = 0; axis < 3; ++axis) {
        const auto [lo, hi] = planes(slot, axis);
        const uint32_t precision = trailPrecision(header_);
        const double origin = precision == 16 ? header_.gridOrigin[axis] : number(texels_[0][axis]);
        const double step = precision == 16 ? double{header_.gridStep[axis]}
                                            : std::ldexp(1.0, static_cast<int>(texels_[0].w >> 8 * axis & 255u) - bias);
        result.lo[axis] = precision == 32 ? number(lo) : origin + step * lo;
        result.hi[axis] = precision == 32 ? number(hi) : origin + step * hi;
    }
    return result;
}

bool TrailNode::isTame() const {
    if (trailPrecision(header_) != 8) return true;
    for (int axis = 0; axis < 3; ++axis) {
        const double corner = number(texels_[0][axis]), extent = double{header_.hi[axis]} - header_.lo[axis];
        const int exponent = static_cast<int>(texels_[0].w >> 8 * axis & 255u) - bias;
        if (!(corner >= header_.lo[axis] && corner <= header_.hi[axis])) return false;
        if (exponent < leastExponent || exponent > exponentFor(extent)) return false;
    }
    return true;
}

uint32_t& trailWord(Structure& structure, uint32_t index, uint32_t slot) {
    const At at = wordAt(structure.header, slot);
    return structure.nodes[size_t{index} * trailTexels(structure.header) + at.texel][static_cast<int>(at.component)];
}

uint32_t trailLink(const Structure& structure, uint32_t index) {
    const size_t links = size_t{structure.header.nodeCount} * trailTexels(structure.header);
    return structure.nodes[links + index / 4][static_cast<int>(index % 4)];
}

}  // namespace raig::bvh
