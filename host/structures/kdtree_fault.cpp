#include "structures/kdtree.hpp"
#include "structures/parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace raig::kdtree {

namespace {

using Fault = std::optional<std::string>;

/// Checks that the nodes are one tree, every plane in its cell, and that each list belongs to one leaf.
class TreeChecker {
public:
    explicit TreeChecker(const Structure& structure)
        : structure_(structure), end_(structure.nodes[0].x), endOfLists_(structure.nodes[0].y) {}

    Fault findFault() {
        const StructureHeader& header = structure_.header;
        if (end_ != rootNode + uint64_t{header.nodeCount} || header.nodeCount == 0) return "the nodes end elsewhere";
        if (end_ > structure_.nodes.size() || endOfLists_ < 4 * uint64_t{end_} ||
            (endOfLists_ + 3) / 4 != structure_.nodes.size())
            return "the lists end elsewhere";
        seen_.resize(endOfLists_);
        if (auto fault = check(rootNode, header.lo, header.hi, 1)) return fault;
        for (uint32_t i = rootNode; i < end_; ++i)
            if (!seen_[i]) return fmt::format("node {} is reached from nowhere", i);
        for (uint64_t i = 4 * uint64_t{end_}; i < endOfLists_; ++i)
            if (!seen_[i]) return fmt::format("word {} is in no leaf's list", i);
        return std::nullopt;
    }

private:
    /// Marks as seen, node by node and word by word (places of lists are no numbers of nodes: they begin at four times as
    /// many).
    Fault check(uint32_t index, vec3 lo, vec3 hi, uint32_t level) {
        if (seen_[index]) return fmt::format("node {} has two parents", index);
        seen_[index] = true;
        if (level > 64) return fmt::format("node {} is deeper than 64 levels", index);
        const uvec4& node = structure_.nodes[index];
        if (node.y > 2) return fmt::format("node {} has no axis", index);
        const auto axis = static_cast<int>(node.y);
        const float plane = std::bit_cast<float>(node.x);
        if (!(plane >= lo[axis] && plane <= hi[axis])) return fmt::format("node {} has its plane outside its cell", index);
        if (node.z == emptyCell && node.w == emptyCell) return fmt::format("node {} has nothing below it", index);
        vec3 middle = hi;
        middle[axis] = plane;
        if (auto fault = checkChild(index, node.z, lo, middle, level)) return fault;
        middle = lo;
        middle[axis] = plane;
        return checkChild(index, node.w, middle, hi, level);
    }

    Fault checkChild(uint32_t parent, uint32_t word, vec3 lo, vec3 hi, uint32_t level) {
        if (word == emptyCell) return std::nullopt;
        if ((word & leafBit) == 0) {
            if (word <= parent || word >= end_) return fmt::format("node {} links backwards or out", parent);
            return check(word, lo, hi, level + 1);
        }
        std::vector<uint32_t> places;
        for (uint64_t at = word & ~leafBit;; ++at) {
            if (at < 4 * uint64_t{end_} || at >= endOfLists_)
                return fmt::format("a leaf of node {} leaves the lists", parent);
            if (seen_[at]) return fmt::format("word {} is in two lists", at);
            seen_[at] = true;
            const uint32_t entry = structure_.nodes[at / 4][static_cast<int>(at % 4)];
            const uint32_t place = entry & ~lastBit;
            if (place >= structure_.header.triangleCount) return fmt::format("word {} refers to no triangle", at);
            places.push_back(place);
            if ((entry & lastBit) != 0) break;
        }
        std::sort(places.begin(), places.end());
        if (std::adjacent_find(places.begin(), places.end()) != places.end())
            return fmt::format("a leaf of node {} refers twice to a triangle", parent);
        return std::nullopt;
    }

    const Structure& structure_;
    uint32_t end_;
    uint32_t endOfLists_;
    std::vector<bool> seen_;
};

/// Sends primitive `place` down the tree, cut by every plane, and looks for it where its parts arrive.
class PartChecker {
public:
    PartChecker(const Structure& structure, uint32_t place) : structure_(structure), place_(place) {}

    /// True if all of the polygon, which lies in the cell of `word`, is in leaves that refer to its triangle.
    bool holds(uint32_t word, const std::vector<dvec3>& polygon) const {
        if (polygon.empty()) return true;
        if (word == emptyCell) return false;
        if ((word & leafBit) != 0) return isListed(word & ~leafBit);
        const uvec4& node = structure_.nodes[word];
        const auto axis = static_cast<int>(node.y);
        const double plane = std::bit_cast<float>(node.x);
        bool below = false, above = false;
        for (const dvec3& p : polygon) {
            below |= p[axis] < plane - partThickness;
            above |= p[axis] > plane + partThickness;
        }
        // Flat in the plane, it may be on either side; nearly so, it may be cut all the same.
        if (!below && !above && (holds(node.z, polygon) || holds(node.w, polygon))) return true;
        const bool cut = below == above;
        return (!(below || cut) || holds(node.z, cut ? partOfPolygon(polygon, axis, plane, 1.0) : polygon)) &&
               (!(above || cut) || holds(node.w, cut ? partOfPolygon(polygon, axis, plane, -1.0) : polygon));
    }

    /// True if all of the sphere that is surely in the cell of `word`, [lo, hi], is in leaves that refer to it.
    bool holdsSphere(uint32_t word, const dvec3& lo, const dvec3& hi, const Primitive& sphere) const {
        if (!isSurelyIn(sphere, lo, hi)) return true;
        if (word == emptyCell) return false;
        if ((word & leafBit) != 0) return isListed(word & ~leafBit);
        const uvec4& node = structure_.nodes[word];
        const auto axis = static_cast<int>(node.y);
        dvec3 middleHi = hi, middleLo = lo;
        middleHi[axis] = middleLo[axis] = std::bit_cast<float>(node.x);
        return holdsSphere(node.z, lo, middleHi, sphere) && holdsSphere(node.w, middleLo, hi, sphere);
    }

private:
    bool isListed(uint32_t at) const {
        for (;; ++at) {
            const uint32_t entry = structure_.nodes[at / 4][static_cast<int>(at % 4)];
            if ((entry & ~lastBit) == place_) return true;
            if ((entry & lastBit) != 0) return false;
        }
    }

    const Structure& structure_;
    uint32_t place_;
};

}  // namespace

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    if (header.walk > shared::WALK_SHORT_STACK) return "there is no such walk";
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    if (auto fault = findListFault(structure, triangles)) return fault;
    if (header.triangleCount == 0) return structure.nodes.empty() ? Fault{} : "nodes, but no triangles";
    if (structure.nodes.empty()) return "triangles, but no nodes";
    if (auto fault = TreeChecker(structure).findFault()) return fault;
    for (uint32_t place = 0; place < header.triangleCount; ++place) {
        const Primitive t = referencedPrimitive(structure, place);
        if (!Box{header.lo, header.hi}.contains(t.box())) return fmt::format("place {} is outside the bounds", place);
        const PartChecker checker(structure, place);
        if (t.isSphere() ? !checker.holdsSphere(rootNode, dvec3(header.lo), dvec3(header.hi), t)
                         : !checker.holds(rootNode, {dvec3(t.a), dvec3(t.b), dvec3(t.c)}))
            return fmt::format("a part of triangle {} is in no leaf that refers to it", referencedId(structure, place));
    }
    return std::nullopt;
}

}  // namespace raig::kdtree
