#include "structures/bvh_fault.hpp"
#include "structures/bvh_layout.hpp"
#include "structures/bvh_trail.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig::bvh {

namespace {

constexpr uint32_t mostLevels = 64;  // the walk has a bit for each

/// Checks the nodes from the root down, each where its parent names it.
class TrailChecker {
public:
    explicit TrailChecker(const Structure& structure) : structure_(structure), header_(structure.header) {
        seen_.resize(header_.triangleCount);
    }

    std::optional<std::string> findFault() {
        if (trailPrecision(header_) == 16 && !hasSceneGrid(header_)) return "its grid is not that of the scene";
        if (header_.nodeCount == 0) return std::nullopt;
        const TrailNode::Extent everything{dvec3(header_.lo), dvec3(header_.hi)};
        pending_.push_back({0, 1, everything});
        uint32_t reached = 0;
        while (!pending_.empty()) {
            const Open open = pending_.back();
            pending_.pop_back();
            ++reached;
            if (open.level > mostLevels) return at(open.node, "it lies too deep");
            const TrailNode node(structure_, open.node);
            if (!node.isTame()) return at(open.node, "its grid is not that of a node");
            for (uint32_t slot = 0; slot < trailArity(header_); ++slot)
                if (auto fault = findChildFault(open, node, slot)) return fault;
        }
        if (reached != header_.nodeCount) return "nodes that no other leads to";
        const auto missing = std::find(seen_.begin(), seen_.end(), 0);
        if (missing != seen_.end()) return fmt::format("reference {} is in no leaf", missing - seen_.begin());
        return std::nullopt;
    }

    const Parts& parts() const { return parts_; }

private:
    /// A node to be looked at; its triangles lie in `within`, which all boxes above it have in common.
    struct Open {
        uint32_t node;
        uint32_t level;
        TrailNode::Extent within;
    };

    static std::string at(uint32_t node, std::string_view what) { return fmt::format("node {}: {}", node, what); }

    /// A node is reached once: its link names one place, and only from there it is gone to.
    std::optional<std::string> findChildFault(const Open& open, const TrailNode& node, uint32_t slot) {
        const uint32_t word = node.word(slot);
        if (word == noChild) return std::nullopt;
        const TrailNode::Extent box = node.extent(slot);
        // Within the scene: nothing that a walk computes overflows. (Planes on a grid are, whatever their numbers.)
        if (trailPrecision(header_) == 32 && !contains({dvec3(header_.lo), dvec3(header_.hi)}, box.lo, box.hi))
            return at(open.node, "a child's box sticks out of the scene");
        const TrailNode::Extent within{glm::max(box.lo, open.within.lo), glm::min(box.hi, open.within.hi)};
        if ((word & leafBit) != 0) return findLeafFault(open.node, word, within);
        if (word <= open.node || word >= header_.nodeCount) return at(open.node, "a child's number does not advance");
        if (trailLink(structure_, word) != (open.node << 3 | slot)) return at(word, "its link does not lead to its parent");
        pending_.push_back({word, open.level + 1, within});
        return std::nullopt;
    }

    std::optional<std::string> findLeafFault(uint32_t node, uint32_t word, const TrailNode::Extent& within) {
        const uint32_t first = (word & ~leafBit) >> 4, count = word & 15;
        if (count == 0) return at(node, "an empty leaf");
        if (first + count > header_.triangleCount) return at(node, "its triangles are out of range");
        for (uint32_t i = first; i < first + count; ++i) {
            if (++seen_[i] != 1) return at(node, "its triangles are in another leaf, too");
            const Box box = referencedPrimitive(structure_, i).box();
            if (!contains(within, dvec3(box.lo), dvec3(box.hi))) parts_[referencedId(structure_, i)].push_back(within);
        }
        return std::nullopt;
    }

    const Structure& structure_;
    const StructureHeader& header_;
    std::vector<uint8_t> seen_;
    Parts parts_;
    std::vector<Open> pending_;
};

}  // namespace

std::optional<std::string> findTrailFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    const size_t texels = size_t{header.nodeCount} * trailTexels(header) + (size_t{header.nodeCount} + 3) / 4;
    if (structure.nodes.size() != texels) return "node count and array differ";
    if (header.triangleCount > 0 && header.nodeCount == 0) return "triangles, and no nodes";
    TrailChecker checker(structure);
    if (auto fault = checker.findFault()) return fault;
    return findUncovered(checker.parts(), triangles, header.unit);
}

}  // namespace raig::bvh
