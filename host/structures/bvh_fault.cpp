#include "structures/bvh.hpp"
#include "structures/bvh_layout.hpp"

#include <fmt/format.h>

namespace raig::bvh {

namespace {

bool contains(const LaidNode& outer, const dvec3& lo, const dvec3& hi) {
    return glm::all(glm::lessThanEqual(outer.lo, lo)) && glm::all(glm::lessThanEqual(hi, outer.hi));
}

/// Checks one copy of the tree; counts in `seen` how often each reference is in a leaf.
class CopyChecker {
public:
    CopyChecker(const Structure& structure, uint32_t octant, std::vector<uint8_t>& seen)
        : structure_(structure), octant_(octant), seen_(seen) {}

    std::optional<std::string> findFault() {
        // The inner nodes that the present one lies in, each ending where its skip link points.
        struct Open {
            LaidNode node;
            uint32_t end;
        };
        std::vector<Open> open;
        const uint32_t count = structure_.header.nodeCount;
        for (uint32_t i = 0; i < count; ++i) {
            while (!open.empty() && open.back().end == i) open.pop_back();
            const LaidNode node = laidNode(structure_, octant_, i);
            if (!open.empty() && !contains(open.back().node, node.lo, node.hi))
                return at(i, "its box sticks out of its parent's");
            if ((node.word & leafBit) != 0) {
                if (auto fault = findLeafFault(i, node)) return fault;
                continue;
            }
            const uint32_t limit = open.empty() ? count : open.back().end;
            if (node.word <= i + 2 || node.word > limit) return at(i, "its skip link leaves its parent or does not advance");
            open.push_back({node, node.word});
        }
        return std::nullopt;
    }

private:
    std::string at(uint32_t index, std::string_view what) const {
        return fmt::format("node {} of copy {}: {}", index, octant_, what);
    }

    std::optional<std::string> findLeafFault(uint32_t index, const LaidNode& node) {
        const uint32_t first = (node.word & ~leafBit) >> 4, count = node.word & 15;
        if (count == 0) return at(index, "an empty leaf");
        if (first + count > structure_.header.triangleCount) return at(index, "its triangles are out of range");
        for (uint32_t i = first; i < first + count; ++i) {
            if (++seen_[i] != 1) return at(index, "its triangles are in another leaf, too");
            const Box box = referencedTriangle(structure_, i).box();
            if (!contains(node, dvec3(box.lo), dvec3(box.hi))) return at(index, "a triangle sticks out of its box");
        }
        return std::nullopt;
    }

    const Structure& structure_;
    uint32_t octant_;
    std::vector<uint8_t>& seen_;
};

std::optional<std::string> findReferenceFault(const Structure& structure, std::span<const Triangle> triangles) {
    std::vector<uint8_t> referenced(triangles.size());
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) {
        const uint32_t id = referencedId(structure, i);
        if (id >= triangles.size()) return fmt::format("reference {} names a triangle that is not there", i);
        if (++referenced[id] != 1) return fmt::format("triangle {} is referenced twice", id);
        if (!refersTo(structure, i, triangles[id]))
            return fmt::format("reference {} has other corners than triangle {}", i, id);
    }
    for (size_t id = 0; id < triangles.size(); ++id)
        if ((referenced[id] != 0) != triangles[id].usable()) return fmt::format("triangle {} is missing, or unusable", id);
    return std::nullopt;
}

}  // namespace

std::optional<std::string> findFault(const Structure& structure, std::span<const Triangle> triangles) {
    const StructureHeader& header = structure.header;
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    const size_t texels = header.walk == shared::WALK_OCTANTS16 ? 1 : 2;
    if (structure.nodes.size() != copies(structure) * nodesACopy(header) * texels) return "node count and array differ";
    if (auto fault = findReferenceFault(structure, triangles)) return fault;
    for (uint32_t octant = 0; octant < copies(structure); ++octant) {
        std::vector<uint8_t> seen(header.triangleCount);
        if (auto fault = CopyChecker(structure, octant, seen).findFault()) return fault;
        for (uint32_t i = 0; i < header.triangleCount; ++i)
            if (seen[i] == 0) return fmt::format("reference {} is in no leaf of copy {}", i, octant);
    }
    return std::nullopt;
}

}  // namespace raig::bvh
