#include "base/parallel.hpp"
#include "structures/bvh_fault.hpp"
#include "structures/bvh.hpp"
#include "structures/bvh_trail.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig::bvh {

namespace {

/// Checks one copy of the tree; counts in `seen` how often each reference is in a leaf.
class CopyChecker {
public:
    CopyChecker(const Structure& structure, uint32_t octant, std::vector<uint8_t>& seen, Parts& parts)
        : structure_(structure), octant_(octant), seen_(seen), parts_(parts),
          boxes_(structure.header.walk <= shared::WALK_OCTANTS16) {}

    std::optional<std::string> findFault() {
        const uint32_t count = structure_.header.nodeCount;
        for (uint32_t i = 0; i < count; ++i) {
            while (!open_.empty() && open_.back().end == i) open_.pop_back();
            const LaidNode node(structure_, octant_, i);
            if (i == 0 && boxes_ && !isBounded(node.extent())) return at(i, "its box is not that of the scene");
            if (!node.isTame()) return at(i, "its bound has numbers that no bound has");
            if (boxes_ && !open_.empty() && !contains(open_.back().node.extent(), node.extent().lo, node.extent().hi))
                return at(i, "its box sticks out of its parent's");
            if ((node.word() & leafBit) != 0) {
                if (auto fault = findLeafFault(i, node)) return fault;
                continue;
            }
            const uint32_t limit = open_.empty() ? count : open_.back().end;
            if (node.word() <= i + 2 || node.word() > limit)
                return at(i, "its skip link leaves its parent or does not advance");
            open_.push_back({node, node.word()});
        }
        for (uint32_t i = count; count > 0 && i < count + shared::BVH_END_NODES; ++i)  // an empty tree is not even entered
            if (LaidNode(structure_, octant_, i).word() != i) return at(i, "it should end the walk");
        return std::nullopt;
    }

private:
    /// An inner node that the present one lies in, ending where its skip link points.
    struct Open {
        LaidNode node;
        uint32_t end;
    };
    /// True if the root's planes are no farther out than they are laid: nothing that a walk computes overflows.
    bool isBounded(const LaidNode::Extent& root) const {
        const StructureHeader& header = structure_.header;
        if (header.walk != shared::WALK_OCTANTS16) return root.lo == dvec3(header.lo) && root.hi == dvec3(header.hi);
        return hasSceneGrid(header);
    }

    std::string at(uint32_t index, std::string_view what) const {
        return fmt::format("node {} of copy {}: {}", index, octant_, what);
    }

    std::optional<std::string> findLeafFault(uint32_t index, const LaidNode& node) {
        const uint32_t first = (node.word() & ~leafBit) >> 4, count = node.word() & 15;
        if (count == 0) return at(index, "an empty leaf");
        if (first + count > structure_.header.triangleCount) return at(index, "its triangles are out of range");
        for (uint32_t i = first; i < first + count; ++i) {
            if (++seen_[i] != 1) return at(index, "its triangles are in another leaf, too");
            const Primitive triangle = referencedPrimitive(structure_, i);
            if (boxes_) {
                const Box box = triangle.box();
                if (!contains(node.extent(), dvec3(box.lo), dvec3(box.hi)))
                    parts_[referencedId(structure_, i)].push_back(node.extent());
                continue;
            }
            if (!node.holds(triangle)) return at(index, "a triangle sticks out of its bound");
            for (const Open& outer : open_)
                if (!outer.node.holds(triangle)) return at(index, "a triangle sticks out of the bound of a node above");
        }
        return std::nullopt;
    }

    const Structure& structure_;
    uint32_t octant_;
    std::vector<uint8_t>& seen_;
    Parts& parts_;
    bool boxes_;
    std::vector<Open> open_;
};

std::optional<std::string> findReferenceFault(const Structure& structure, std::span<const Primitive> triangles) {
    std::vector<uint8_t> referenced(triangles.size());
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) {
        const uint32_t id = referencedId(structure, i);
        if (id >= triangles.size()) return fmt::format("reference {} names a triangle that is not there", i);
        referenced[id] = 1;
        if (!refersTo(structure, i, triangles[id]))
            return fmt::format("reference {} has other corners than triangle {}", i, id);
    }
    for (size_t id = 0; id < triangles.size(); ++id)
        if ((referenced[id] != 0) != triangles[id].usable()) return fmt::format("triangle {} is missing, or unusable", id);
    return std::nullopt;
}

/// Points spread over a primitive, in the structure's unit.
std::vector<dvec3> pointsOf(const Primitive& primitive) {
    constexpr int steps = 8;
    std::vector<dvec3> points;
    const dvec3 a(primitive.a), b(primitive.b), c(primitive.c);
    for (int i = 0; i <= steps; ++i)
        for (int j = 0; i + j <= steps && !primitive.isSphere(); ++j)
            points.push_back(a + (b - a) * (i / double{steps}) + (c - a) * (j / double{steps}));
    for (int side = 0; side < 6 && primitive.isSphere(); ++side) {
        dvec3 outermost = a;
        outermost[side / 2] += side % 2 == 0 ? double{primitive.radius()} : -double{primitive.radius()};
        points.push_back(outermost);
    }
    // Along the spiral of equal areas [Saff, Kuijlaars 1997, "Distributing Many Points on a Sphere"].
    constexpr int around = 96;
    for (int i = 0; i < around && primitive.isSphere(); ++i) {
        const double z = 1.0 - (2.0 * i + 1.0) / around, r = std::sqrt(1.0 - z * z), angle = 2.399963229728653 * i;
        points.push_back(a + double{primitive.radius()} * dvec3(r * std::cos(angle), r * std::sin(angle), z));
    }
    return points;
}

}  // namespace

bool hasSceneGrid(const StructureHeader& header) {
    StructureHeader laid = header;
    setGrid(laid);
    return laid.gridOrigin == header.gridOrigin && laid.gridStep == header.gridStep;
}

std::optional<std::string> findUncovered(const Parts& parts, std::span<const Primitive> triangles, float unit) {
    for (const auto& [id, boxes] : parts)
        for (const dvec3& p : pointsOf(triangles[id].scaled(unit))) {
            // Not one of the corners' own roundings matters: boxes are rounded outwards by more.
            const dvec3 slack(0x1p-40);
            const auto holds = [&](const LaidNode::Extent& box) { return contains({box.lo - slack, box.hi + slack}, p, p); };
            if (std::none_of(boxes.begin(), boxes.end(), holds))
                return fmt::format("triangle {} sticks out of the boxes of its leaves", id);
        }
    return std::nullopt;
}

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    if (header.walk >= shared::MAX_WALKS) return "there is no such walk";
    if (auto fault = findReferenceFault(structure, triangles)) return fault;
    if (isTrail(header)) return findTrailFault(structure, triangles);
    if (structure.nodes.size() != copies(structure) * nodesACopy(header) * nodeTexels(header))
        return "node count and array differ";
    std::vector<std::optional<std::string>> faults(copies(structure));
    parallelFor(faults.size(), 1, [&](size_t begin, size_t end) {
        for (size_t octant = begin; octant < end; ++octant) {
            std::vector<uint8_t> seen(header.triangleCount);
            Parts parts;
            faults[octant] = CopyChecker(structure, static_cast<uint32_t>(octant), seen, parts).findFault();
            if (!faults[octant]) faults[octant] = findUncovered(parts, triangles, header.unit);
            const auto missing = std::find(seen.begin(), seen.end(), 0);
            if (!faults[octant] && missing != seen.end())
                faults[octant] = fmt::format("reference {} is in no leaf of copy {}", missing - seen.begin(), octant);
        }
    });
    for (const std::optional<std::string>& fault : faults)
        if (fault) return fault;
    return std::nullopt;
}

}  // namespace raig::bvh
