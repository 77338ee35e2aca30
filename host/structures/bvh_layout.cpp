#include "structures/bvh_layout.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "structures/bvh_bounds.hpp"
#include "structures/bvh_trail.hpp"

#include <algorithm>
#include <array>
#include <bit>

namespace raig::bvh {

namespace {

constexpr float gridSteps = 65535.0f;

uint32_t bits(float value) {
    return std::bit_cast<uint32_t>(value);
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

/// What bounds each node of the tree, as the walk has it in memory: only the array of its kind is filled.
struct NodeBounds {
    std::vector<uvec3> planes;  ///< WALK_OCTANTS16
    std::vector<Sphere> spheres;
    std::vector<OrientedBox> boxes;
    std::vector<Kdop> kdops;
};

/// A point, in the structure's unit, as seen from the scene's lower corner: so that far from the origin of coordinates, sums
/// of coordinates are as exact as they can be. It is rounded by less than the slack of the walk.
vec3 fromCorner(const vec3& point, const StructureHeader& header) { return point - header.gridOrigin; }

/// The corners of the triangles below each node in turn, and its spheres (three times each), from the scene's lower corner.
class Corners {
public:
    Corners(const BinaryTree& tree, std::span<const Primitive> triangles, const StructureHeader& header) : tree_(tree) {
        corners_.reserve(tree.references.size() * 3);
        for (const BoxReference& reference : tree.references) {
            const Primitive t = triangles[reference.id].scaled(header.unit);
            const Ball sphere{fromCorner(t.centre(), header), t.radius()};
            for (const vec3& corner : {t.a, t.b, t.c})
                corners_.push_back(t.isSphere() ? sphere : Ball{fromCorner(corner, header), 0.0f});
        }
    }
    /// References of a subtree lie side by side: from those of its first leaf to those of its last.
    std::span<const Ball> below(uint32_t index) const {
        uint32_t first = index, last = index;
        while (tree_.nodes[first].count == 0) first = tree_.childrenOf(tree_.nodes[first]).front();
        while (tree_.nodes[last].count == 0) last = tree_.childrenOf(tree_.nodes[last]).back();
        const uint32_t begin = tree_.nodes[first].first, end = tree_.nodes[last].first + tree_.nodes[last].count;
        return std::span(corners_).subspan(size_t{begin} * 3, size_t{end - begin} * 3);
    }

private:
    const BinaryTree& tree_;
    std::vector<Ball> corners_;
};

NodeBounds boundNodes(const BinaryTree& tree, std::span<const Primitive> triangles, const StructureHeader& header) {
    NodeBounds bounds;
    const size_t count = tree.nodes.size();
    const auto fill = [&](auto& array, const auto& boundOf) {
        array.resize(count);
        parallelFor(count, 256, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i)
                if (!tree.nodes[i].box.empty()) array[i] = boundOf(static_cast<uint32_t>(i));
        });
    };
    if (header.walk == shared::WALK_OCTANTS16)
        fill(bounds.planes, [&](uint32_t i) { return quantised(tree.nodes[i].box, header); });
    if (header.walk <= shared::WALK_OCTANTS16) return bounds;
    const Corners corners(tree, triangles, header);
    if (header.walk == shared::WALK_SPHERES)
        fill(bounds.spheres, [&](uint32_t i) { return sphereAround(corners.below(i)); });
    if (header.walk == shared::WALK_OBBS)
        fill(bounds.boxes, [&](uint32_t i) { return orientedBoxAround(corners.below(i)); });
    if (header.walk == shared::WALK_KDOPS) fill(bounds.kdops, [&](uint32_t i) { return kdopAround(corners.below(i)); });
    return bounds;
}

uvec4 texel(const vec3& v, uint32_t word) { return {bits(v.x), bits(v.y), bits(v.z), word}; }

/// Writes one copy of the tree, depth first, children in the order that suits `octant`.
class CopyWriter {
public:
    CopyWriter(const BinaryTree& tree, const NodeBounds& bounds, Structure& structure, uint32_t octant)
        : tree_(tree), bounds_(bounds), structure_(structure), octant_(octant) {}

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
            waiting.push_back(pushChildren(node, pending));
        }
        RAIG_CHECK_OP(next, ==, structure_.header.nodeCount);
        for (uint32_t i = next; i < next + shared::BVH_END_NODES; ++i) putEnd(i);
    }

private:
    /// Puts the children where the nearest is taken first; returns how many.
    uint32_t pushChildren(const BinaryNode& node, std::vector<uint32_t>& pending) const {
        const std::span<const uint32_t> children = tree_.childrenOf(node);
        if (tree_.wide.empty()) {
            const bool swapped = copies(structure_) == 8 && isNegative(octant_, static_cast<int>(node.axis));
            pending.push_back(children[swapped ? 0 : 1]);
            pending.push_back(children[swapped ? 1 : 0]);
            return 2;
        }
        std::array<uint32_t, 8> order;
        std::array<float, 8> away;
        uint32_t count = 0;
        for (const uint32_t child : children) {
            const vec3 centre = tree_.nodes[child].box.centre();
            float distance = 0.0f;
            for (int axis = 0; axis < 3; ++axis) distance += isNegative(octant_, axis) ? -centre[axis] : centre[axis];
            uint32_t place = count++;
            for (; place > 0 && away[place - 1] < distance; --place) {
                away[place] = away[place - 1];
                order[place] = order[place - 1];
            }
            away[place] = distance;
            order[place] = child;
        }
        pending.insert(pending.end(), order.begin(), order.begin() + count);  // the farthest first: the last is taken first
        return count;
    }

    uvec4* at(uint32_t place) const {
        const size_t node = octant_ * nodesACopy(structure_.header) + place;
        return structure_.nodes.data() + node * nodeTexels(structure_.header);
    }

    void setWord(uint32_t place, uint32_t word) { at(place)[0].w = word; }

    void put(uint32_t place, uint32_t index, uint32_t word) {
        uvec4* node = at(place);
        switch (structure_.header.walk) {
        case shared::WALK_OCTANTS16: {
            for (int axis = 0; axis < 3; ++axis) {
                const uint32_t planes = bounds_.planes[index][axis];
                node[0][axis] = isNegative(octant_, axis) ? planes >> 16 | planes << 16 : planes;
            }
            node[0].w = word;
            break;
        }
        case shared::WALK_SPHERES: {
            const Sphere& sphere = bounds_.spheres[index];
            node[0] = texel(sphere.centre, word);
            node[1] = uvec4(bits(sphere.radius), 0, 0, 0);
            break;
        }
        case shared::WALK_OBBS: {
            const OrientedBox& box = bounds_.boxes[index];
            node[0] = texel(box.axes[0], word);
            node[1] = texel(box.axes[1], bits(box.hi.x));
            node[2] = texel(box.axes[2], bits(box.hi.y));
            node[3] = texel(box.lo, bits(box.hi.z));
            break;
        }
        case shared::WALK_KDOPS: {
            const Kdop& k = bounds_.kdops[index];
            node[0] = texel(vec3(k.lo[0], k.lo[1], k.lo[2]), word);
            node[1] = texel(vec3(k.hi[0], k.hi[1], k.hi[2]), 0);
            node[2] = texel(vec3(k.lo[3], k.lo[4], k.lo[5]), bits(k.lo[6]));
            node[3] = texel(vec3(k.hi[3], k.hi[4], k.hi[5]), bits(k.hi[6]));
            break;
        }
        default: putFloats(node, tree_.nodes[index].box, word);
        }
    }

    /// What no ray hits, unless it comes from so far away that it hits everything.
    void putEnd(uint32_t place) {
        uvec4* node = at(place);
        const vec3 most(largestCoordinate);
        std::fill(node, node + nodeTexels(structure_.header), uvec4(0));
        switch (structure_.header.walk) {
        case shared::WALK_OCTANTS16:
            for (int axis = 0; axis < 3; ++axis) node[0][axis] = isNegative(octant_, axis) ? 0xffff0000u : 0x0000ffffu;
            break;
        case shared::WALK_SPHERES: node[1].x = bits(-largestCoordinate); break;
        case shared::WALK_OBBS: node[3] = texel(most, 0); break;  // dot(0, p) >= most
        case shared::WALK_KDOPS:
            node[0] = texel(most, 0);
            node[1] = texel(-most, 0);
            break;
        default: putFloats(node, Box{most, -most}, 0);
        }
        node[0].w = place;
    }

    void putFloats(uvec4* node, const Box& sceneBox, uint32_t word) const {
        const StructureHeader& header = structure_.header;
        const Box box{sceneBox.lo * header.unit, sceneBox.hi * header.unit};
        for (int axis = 0; axis < 3; ++axis) {
            const bool swapped = header.walk == shared::WALK_OCTANTS && isNegative(octant_, axis);
            node[0][axis] = bits(swapped ? box.hi[axis] : box.lo[axis]);
            node[1][axis] = bits(swapped ? box.lo[axis] : box.hi[axis]);
        }
        node[0].w = word;
        node[1].w = 0;
    }

    const BinaryTree& tree_;
    const NodeBounds& bounds_;
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

uint32_t bytesANode(uint32_t walk) {
    StructureHeader header{};
    header.walk = walk;
    return nodeTexels(header) * static_cast<uint32_t>(sizeof(uvec4));
}

/// The walk for boxes: that of the options, or the fastest that suits the scene and the memory budget.
uint32_t chooseBoxWalk(const BuildParams& params, const BinaryTree& tree, Structure& structure) {
    const uint64_t nodes = structure.header.nodeCount;
    const uint64_t left = params.memoryBudget - std::min(params.memoryBudget, referenceBytes(tree));
    if (params.walk == "skip") return shared::WALK_SKIP;
    const bool fine = params.precision == 16 || (params.precision == 0 && gridIsFineEnough(tree, structure.header));
    if (params.walk == "trail" || params.precision == 8)
        return trailWalk(params.arity, params.precision == 8 ? 8 : fine ? 16 : 32);
    const uint32_t wanted = fine ? shared::WALK_OCTANTS16 : shared::WALK_OCTANTS;
    if (params.walk == "octants" || 8 * nodes * bytesANode(wanted) <= left) return wanted;
    structure.remarks.push_back(
        fmt::format("one copy of the tree instead of eight, as {:.0f} MiB for them exceed the memory budget",
                    static_cast<double>(8 * nodes * bytesANode(wanted)) / (1 << 20)));
    return shared::WALK_SKIP;
}

}  // namespace

uint64_t referenceBytes(const BinaryTree& tree) { return tree.references.size() * shared::TRIANGLE_STRIDE * sizeof(uvec4); }

void checkBudget(uint64_t texels, const BinaryTree& tree, uint64_t memoryBudget) {
    const uint64_t bytes = texels * sizeof(uvec4) + referenceBytes(tree);
    if (bytes > memoryBudget)
        throw limitError(
            "bvh needs {} MiB and --memory-budget allows {}: raise it, or choose another structure or --max-leaf",
            bytes >> 20, memoryBudget >> 20);
}

uint32_t nodeTexels(const StructureHeader& header) {
    static constexpr uint32_t texels[] = {2, 2, 1, 2, 4, 4};
    return texels[header.walk];
}

void setGrid(StructureHeader& header) {
    const vec3 extent = header.hi - header.lo;
    const float widest = std::max({extent.x, extent.y, extent.z});
    for (int axis = 0; axis < 3; ++axis) {
        // A flat axis gets steps too, small ones; one part in 2^20 makes up for all rounding here.
        header.gridStep[axis] = std::max(extent[axis], widest * 0x1p-16f) / gridSteps * (1.0f + 0x1p-20f);
        header.gridOrigin[axis] = header.lo[axis];
    }
}

uint32_t copies(const Structure& structure) {
    return structure.header.walk == shared::WALK_SKIP ? 1 : 8;
}

void layOut(const BinaryTree& tree, std::span<const Primitive> triangles, const BuildParams& params, Structure& structure) {
    static constexpr std::string_view names[] = {"skip links",           "octants",       "octants, 16-bit planes",
                                                 "octants, spheres", "octants, oriented boxes", "octants, 14-plane slabs"};
    StructureHeader& header = structure.header;
    setGrid(header);
    header.walk = params.bound == "sphere" ? shared::WALK_SPHERES
                  : params.bound == "obb"  ? shared::WALK_OBBS
                  : params.bound == "kdop" ? shared::WALK_KDOPS
                                           : chooseBoxWalk(params, tree, structure);
    if (isTrail(header)) {
        structure.walk = fmt::format("trail, {} boxes, {}-bit", trailArity(header), trailPrecision(header));
        return layOutTrail(tree, params.memoryBudget, structure);
    }
    structure.walk = names[header.walk];
    const uint64_t texels = copies(structure) * nodesACopy(header) * nodeTexels(header);
    checkBudget(texels, tree, params.memoryBudget);
    structure.nodes.resize(texels);
    if (tree.nodes.empty()) return;
    const NodeBounds bounds = boundNodes(tree, triangles, header);
    parallelFor(copies(structure), 1, [&](size_t begin, size_t end) {
        for (size_t octant = begin; octant < end; ++octant)
            CopyWriter(tree, bounds, structure, static_cast<uint32_t>(octant)).write();
    });
}

namespace {

float number(uint32_t bits) { return std::bit_cast<float>(bits); }
vec3 numbers(const uvec4& t) { return {number(t.x), number(t.y), number(t.z)}; }

}  // namespace

uint32_t LaidNode::word() const { return texels_[0].w; }

LaidNode::LaidNode(const Structure& structure, uint32_t octant, uint32_t index)
    : header_(structure.header), octant_(octant),
      texels_(structure.nodes.data() + (octant * nodesACopy(structure.header) + index) * nodeTexels(structure.header)) {}

LaidNode::Extent LaidNode::extent() const {
    Extent result{};
    for (int axis = 0; axis < 3; ++axis) {
        double near, far;
        if (header_.walk == shared::WALK_OCTANTS16) {
            const uint32_t planes = texels_[0][axis];
            near = header_.gridOrigin[axis] + double{header_.gridStep[axis]} * (planes & 0xffff);
            far = header_.gridOrigin[axis] + double{header_.gridStep[axis]} * (planes >> 16);
        } else {
            near = number(texels_[0][axis]);
            far = number(texels_[1][axis]);
        }
        const bool swapped = header_.walk != shared::WALK_SKIP && isNegative(octant_, axis);
        result.lo[axis] = swapped ? far : near;
        result.hi[axis] = swapped ? near : far;
    }
    return result;
}

bool LaidNode::isTame() const {
    // The scene's extent is at most 4, so that of what bounds it tightly less than 16; false for NaN.
    const auto isSmall = [](const vec3& v) { return glm::all(glm::lessThanEqual(glm::abs(v), vec3(16.0f))); };
    if (header_.walk == shared::WALK_SPHERES) return isSmall(numbers(texels_[0])) && isSmall(vec3(number(texels_[1].x)));
    bool tame = true;
    if (header_.walk == shared::WALK_OBBS || header_.walk == shared::WALK_KDOPS)
        for (int i = 0; i < 4; ++i) tame = tame && isSmall(numbers(texels_[i]));
    if (header_.walk == shared::WALK_KDOPS) return tame && isSmall(vec3(number(texels_[2].w), number(texels_[3].w), 0.0f));
    if (header_.walk != shared::WALK_OBBS) return true;
    for (int i = 0; i < 3; ++i) {
        const vec3 axis = numbers(texels_[i]);
        tame = tame && glm::dot(axis, axis) <= 1.0f + 0x1p-16f;
    }
    return tame && isSmall(vec3(number(texels_[1].w), number(texels_[2].w), number(texels_[3].w)));
}

bool LaidNode::holds(const Primitive& primitive) const {
    if (primitive.isSphere()) return holds(primitive.centre(), primitive.radius());
    return holds(primitive.a, 0.0f) && holds(primitive.b, 0.0f) && holds(primitive.c, 0.0f);
}

bool LaidNode::holds(const vec3& centre, float radius) const {
    const Ball ball{fromCorner(centre, header_), radius};
    switch (header_.walk) {
    case shared::WALK_SPHERES: return contains(Sphere{numbers(texels_[0]), number(texels_[1].x)}, ball);
    case shared::WALK_OBBS:
        return contains(OrientedBox{{numbers(texels_[0]), numbers(texels_[1]), numbers(texels_[2])}, numbers(texels_[3]),
                                    vec3(number(texels_[1].w), number(texels_[2].w), number(texels_[3].w))}, ball);
    case shared::WALK_KDOPS: {
        Kdop kdop;
        for (int i = 0; i < 3; ++i) {
            kdop.lo[i] = number(texels_[0][i]);
            kdop.hi[i] = number(texels_[1][i]);
        }
        for (int i = 0; i < 4; ++i) {
            kdop.lo[3 + i] = number(texels_[2][i]);
            kdop.hi[3 + i] = number(texels_[3][i]);
        }
        return contains(kdop, ball);
    }
    default: {
        const Extent box = extent();
        const Box own = sphereBox(centre, radius);
        return glm::all(glm::lessThanEqual(box.lo, dvec3(own.lo))) && glm::all(glm::lessThanEqual(dvec3(own.hi), box.hi));
    }
    }
}

}  // namespace raig::bvh
