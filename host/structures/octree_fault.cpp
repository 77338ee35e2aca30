#include "structures/octree.hpp"
#include "structures/parts.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <bit>

namespace raig::octree {

namespace {

using Fault = std::optional<std::string>;

uint32_t wordAt(const Structure& structure, uint64_t at) {
    return structure.nodes[at / 4][static_cast<int>(at % 4)];
}

/// Checks that the records are one tree, and that each list belongs to one leaf.
class TreeChecker {
public:
    explicit TreeChecker(const Structure& structure)
        : structure_(structure), end_(structure.nodes[0].x), endOfLists_(structure.nodes[0].y) {}

    Fault findFault() {
        if (end_ != rootRecord + uint64_t{structure_.header.nodeCount} || structure_.header.nodeCount == 0)
            return "the records end elsewhere";
        if (end_ > structure_.nodes.size() || endOfLists_ < 4 * uint64_t{end_} ||
            (uint64_t{endOfLists_} + 3) / 4 != structure_.nodes.size())
            return "the lists end elsewhere";
        reached_.resize(end_);
        listed_.resize(endOfLists_);
        if (auto fault = check(rootRecord, 0)) return fault;
        for (uint32_t i = rootRecord; i < end_; ++i)
            if (!reached_[i]) return fmt::format("record {} is reached from nowhere", i);
        for (uint64_t i = 4 * uint64_t{end_}; i < endOfLists_; ++i)
            if (!listed_[i]) return fmt::format("word {} is in no leaf's list", i);
        return std::nullopt;
    }

private:
    Fault check(uint32_t index, uint32_t level) {
        if (reached_[index]) return fmt::format("record {} has two parents", index);
        reached_[index] = true;
        const uvec4& record = structure_.nodes[index];
        if ((record.x & leafBit) != 0) return checkList(index, record.x & ~leafBit);
        if (level >= mostLevels) return fmt::format("record {} is deeper than {} levels", index, mostLevels);
        if (record.y == 0 || record.y > 255) return fmt::format("record {} has no octants", index);
        const auto children = static_cast<uint32_t>(std::popcount(record.y));
        if (record.x <= index || record.x >= end_ || end_ - record.x < children)
            return fmt::format("record {} links backwards or out", index);
        for (uint32_t i = 0; i < children; ++i)
            if (auto fault = check(record.x + i, level + 1)) return fault;
        return std::nullopt;
    }

    Fault checkList(uint32_t index, uint64_t at) {
        const bool isInline = at == 4 * uint64_t{index} + 1;
        if (!isInline && at < 4 * uint64_t{end_}) return fmt::format("the list of record {} is among the records", index);
        const uint64_t limit = isInline ? 4 * uint64_t{index} + 4 : endOfLists_;
        std::vector<uint32_t> places;
        for (;; ++at) {
            if (at >= limit) return fmt::format("the list of record {} does not end", index);
            if (listed_[at]) return fmt::format("word {} is in two lists", at);
            listed_[at] = true;
            const uint32_t place = wordAt(structure_, at) & ~lastBit;
            if (place >= structure_.header.triangleCount) return fmt::format("word {} refers to no triangle", at);
            places.push_back(place);
            if ((wordAt(structure_, at) & lastBit) != 0) break;
        }
        std::sort(places.begin(), places.end());
        if (std::adjacent_find(places.begin(), places.end()) != places.end())
            return fmt::format("the leaf of record {} refers twice to a triangle", index);
        return std::nullopt;
    }

    const Structure& structure_;
    uint32_t end_;
    uint32_t endOfLists_;
    std::vector<bool> reached_, listed_;
};

/// Sends primitive `place` down the tree, cut by every plane, and looks for it where its parts arrive.
class PartChecker {
public:
    PartChecker(const Structure& structure, uint32_t place) : structure_(structure), place_(place) {}

    /// True if all of the polygon, which lies in the cell of a record, is in leaves that refer to its triangle.
    bool holds(uint32_t index, const uvec3& low, uint32_t width, const std::vector<dvec3>& polygon) const {
        const uvec4& record = structure_.nodes[index];
        if ((record.x & leafBit) != 0) return isListed(record.x & ~leafBit);
        return holdsParts(record, low, width / 2, 0, 0, polygon);
    }

    /// True if all of the sphere that is surely in the cell of a record is in leaves that refer to it.
    bool holdsSphere(uint32_t index, const uvec3& low, uint32_t width, const Primitive& sphere) const {
        if (!isSurelyIn(sphere, cornerAt(low), cornerAt(low + width))) return true;
        const uvec4& record = structure_.nodes[index];
        if ((record.x & leafBit) != 0) return isListed(record.x & ~leafBit);
        const uint32_t half = width / 2;
        uint32_t child = record.x;
        for (uint32_t octant = 0; octant < 8; ++octant) {
            const uvec3 corner = low + half * uvec3(octant & 1, octant >> 1 & 1, octant >> 2);
            if ((record.y >> octant & 1) == 0) {
                if (isSurelyIn(sphere, cornerAt(corner), cornerAt(corner + half))) return false;
            } else if (!holdsSphere(child++, corner, half, sphere)) {
                return false;
            }
        }
        return true;
    }

private:
    dvec3 cornerAt(const uvec3& steps) const {
        const StructureHeader& header = structure_.header;
        return {planeAt(header, steps.x, 0), planeAt(header, steps.y, 1), planeAt(header, steps.z, 2)};
    }

    /// The same of what lies in the halves of the cell that the bits of `octant` name, for the axes before `axis`.
    bool holdsParts(const uvec4& record, const uvec3& low, uint32_t half, int axis, uint32_t octant,
                    const std::vector<dvec3>& polygon) const {
        if (polygon.empty()) return true;
        if (axis == 3) {
            if ((record.y >> octant & 1) == 0) return false;
            const auto child = record.x + static_cast<uint32_t>(std::popcount(record.y & ((1u << octant) - 1)));
            return holds(child, low + half * uvec3(octant & 1, octant >> 1 & 1, octant >> 2), half, polygon);
        }
        const double plane = planeAt(structure_.header, low[axis] + half, axis);
        bool below = false, above = false;
        for (const dvec3& p : polygon) {
            below |= p[axis] < plane - partThickness;
            above |= p[axis] > plane + partThickness;
        }
        const uint32_t upper = octant | 1u << axis;
        const auto lowerHolds = [&](const auto& part) { return holdsParts(record, low, half, axis + 1, octant, part); };
        const auto upperHolds = [&](const auto& part) { return holdsParts(record, low, half, axis + 1, upper, part); };
        // Flat in the plane, it may be on either side; nearly so, it may be cut all the same.
        if (!below && !above && (lowerHolds(polygon) || upperHolds(polygon))) return true;
        const bool cut = below == above;
        return (!(below || cut) || lowerHolds(cut ? partOfPolygon(polygon, axis, plane, 1.0) : polygon)) &&
               (!(above || cut) || upperHolds(cut ? partOfPolygon(polygon, axis, plane, -1.0) : polygon));
    }

    bool isListed(uint64_t at) const {
        for (;; ++at) {
            const uint32_t entry = wordAt(structure_, at);
            if ((entry & ~lastBit) == place_) return true;
            if ((entry & lastBit) != 0) return false;
        }
    }

    const Structure& structure_;
    uint32_t place_;
};

/// The cube is around the bounds, and its planes in order.
Fault findGridFault(const StructureHeader& header) {
    for (int axis = 0; axis < 3; ++axis) {
        if (!(header.gridStep[axis] > 0.0f)) return "the steps have no length";
        if (!(header.gridOrigin[axis] <= header.lo[axis] && planeAt(header, side, axis) >= header.hi[axis]))
            return "the bounds stick out of the cube";
    }
    return std::nullopt;
}

}  // namespace

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    if (header.walk != 0) return "there is no such walk";
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    if (auto fault = findListFault(structure, triangles)) return fault;
    if (header.triangleCount == 0) return structure.nodes.empty() ? Fault{} : "records, but no triangles";
    if (structure.nodes.empty()) return "triangles, but no records";
    if (auto fault = findGridFault(header)) return fault;
    if (auto fault = TreeChecker(structure).findFault()) return fault;
    for (uint32_t place = 0; place < header.triangleCount; ++place) {
        const Primitive t = referencedPrimitive(structure, place);
        if (!Box{header.lo, header.hi}.contains(t.box())) return fmt::format("place {} is outside the bounds", place);
        const PartChecker checker(structure, place);
        if (t.isSphere() ? !checker.holdsSphere(rootRecord, uvec3(0), side, t)
                         : !checker.holds(rootRecord, uvec3(0), side, {dvec3(t.a), dvec3(t.b), dvec3(t.c)}))
            return fmt::format("a part of triangle {} is in no leaf that refers to it", referencedId(structure, place));
    }
    return std::nullopt;
}

}  // namespace raig::octree
