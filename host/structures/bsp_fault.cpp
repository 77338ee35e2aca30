#include "structures/bsp.hpp"
#include "structures/bsp_plane.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig::bsp {

namespace {

// The tolerance, and what the builder's and this arithmetic may differ by.
constexpr double allowed = tolerance * (1.0 + 0x1p-20);

using Polygon = std::vector<dvec3>;

/// The part of a polygon within `margin` of a side of a plane (below: -1).
Polygon cut(const Polygon& polygon, const Plane& plane, double side, double margin) {
    Polygon result;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 &p = polygon[i], &q = polygon[(i + 1) % polygon.size()];
        const double atP = side * plane.to(p) + margin, atQ = side * plane.to(q) + margin;
        if (atP >= 0.0) result.push_back(p);
        if ((atP < 0.0) != (atQ < 0.0)) result.push_back(glm::mix(p, q, std::clamp(atP / (atP - atQ), 0.0, 1.0)));
    }
    return result;
}

class Checker {
public:
    explicit Checker(const Structure& structure)
        : structure_(structure), nodes_(structure.nodes), seen_(nodes_.size()), leaves_(nodes_.size()) {
        const vec3 size = structure.header.hi - structure.header.lo;
        extent_ = std::max({size.x, size.y, size.z});
    }

    /// Everything below the root is reached once, and is in order.
    std::optional<std::string> findTreeFault() {
        struct Open {
            uint32_t node, level;
        };
        std::vector<Open> open{{0, 1}};
        while (!open.empty()) {
            const auto [at, level] = open.back();
            open.pop_back();
            if (seen_[at]++ != 0) return place(at, "it has two parents");
            if (level > mostLevels) return place(at, "it is on too deep a level");
            const uvec4& node = nodes_[at];
            if ((node.w & leafBit) != 0) {
                if (auto fault = findLeafFault(at)) return fault;
                continue;
            }
            if (auto fault = findPlaneFault(at)) return fault;
            const uint32_t first = node.w & indexBits;
            const uint32_t count = 2 - ((node.w & noBelowBit) != 0) - ((node.w & noAboveBit) != 0);
            if (count == 0) return place(at, "it has no children");
            if (first <= at || first + count > nodes_.size()) return place(at, "its children do not follow it");
            for (uint32_t child = first; child < first + count; ++child) open.push_back({child, level + 1});
        }
        for (uint32_t i = 0; i < nodes_.size(); ++i)
            if (seen_[i] == 0) return place(i, "it is in no tree");
        return std::nullopt;
    }

    /// Every point of a triangle is in a leaf that references it.
    bool isCovered(uint32_t reference) const {
        const Primitive t = referencedPrimitive(structure_, reference);
        const dvec3 lo(structure_.header.lo);
        if (t.isSphere()) return isSphereCovered(0, dvec3(t.centre()) - lo, t.radius(), reference);
        return isCovered(0, {dvec3(t.a) - lo, dvec3(t.b) - lo, dvec3(t.c) - lo}, reference);
    }

private:
    static std::string place(uint32_t index, std::string_view what) { return fmt::format("node {}: {}", index, what); }

    std::optional<std::string> findPlaneFault(uint32_t at) const {
        const Plane plane = Plane::decoded(nodes_[at]);
        int64_t sum = 0;
        for (const int32_t step : plane.steps) sum += std::abs(int64_t{step});
        if (sum > 1 << 20) return place(at, "its normal is too long");
        if (sum < 1 << 19) return place(at, "its normal is too short");
        if (!(std::abs(plane.distance) <= 2.0 * extent_)) return place(at, "its plane is far outside the bounds");
        return std::nullopt;
    }

    /// Collects a leaf's references, too.
    std::optional<std::string> findLeafFault(uint32_t at) {
        std::vector<uint32_t>& references = leaves_[at];
        for (uint32_t part = at;;) {
            const uvec4& node = nodes_[part];
            const uint32_t count = node.w & 3;
            const bool more = (node.w & moreBit) != 0, linked = (node.w & linkedBit) != 0;
            if ((node.w & leafBit) == 0) return place(part, "part of a leaf, and not marked as one");
            if (linked != (more && part == at) || (linked && count != 2) || (more && !linked && count != 3) || count == 0)
                return place(part, "it is no part of a leaf that a walk can follow");
            for (uint32_t i = 0; i < count; ++i) references.push_back(node[static_cast<int>(i)]);
            if (!more) break;
            const uint32_t next = linked ? node.z : part + 1;
            if (next <= part || next >= nodes_.size()) return place(part, "the next part of the leaf does not follow it");
            part = next;
            if (seen_[part]++ != 0) return place(part, "it is in two leaves");
        }
        std::sort(references.begin(), references.end());
        if (references.back() >= structure_.header.triangleCount) return place(at, "its references are out of range");
        if (std::adjacent_find(references.begin(), references.end()) != references.end())
            return place(at, "it references a triangle twice");
        return std::nullopt;
    }

    bool isCovered(uint32_t at, const Polygon& polygon, uint32_t reference) const {
        const uvec4& node = nodes_[at];
        if ((node.w & leafBit) != 0) return std::binary_search(leaves_[at].begin(), leaves_[at].end(), reference);
        const Plane plane = Plane::decoded(node);
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (const dvec3& corner : polygon) {
            lo = std::min(lo, plane.to(corner));
            hi = std::max(hi, plane.to(corner));
        }
        const bool noBelow = (node.w & noBelowBit) != 0, noAbove = (node.w & noAboveBit) != 0;
        const uint32_t below = node.w & indexBits, above = noBelow ? below : below + 1;
        // Within one side it may be on that side alone.
        if (hi <= allowed * extent_ && !noBelow && isCovered(below, polygon, reference)) return true;
        if (lo >= -allowed * extent_ && !noAbove && isCovered(above, polygon, reference)) return true;
        if (noBelow || noAbove || hi < 0.0 || lo > 0.0) return false;
        // Rounding must not leave out anything, nor make up a part that is not there: 2^-44 of the extent is far more than
        // the one, and far less than the margin that the builder cuts with.
        const double margin = 0x1p-44 * extent_;
        return isCovered(below, cut(polygon, plane, -1.0, margin), reference) &&
               isCovered(above, cut(polygon, plane, 1.0, margin), reference);
    }

    /// Spheres are on each side that they reach, as wholes.
    bool isSphereCovered(uint32_t at, const dvec3& centre, double radius, uint32_t reference) const {
        const uvec4& node = nodes_[at];
        if ((node.w & leafBit) != 0) return std::binary_search(leaves_[at].begin(), leaves_[at].end(), reference);
        const Plane plane = Plane::decoded(node);
        const double to = plane.to(centre), reach = radius * glm::length(plane.normal());
        const bool noBelow = (node.w & noBelowBit) != 0, noAbove = (node.w & noAboveBit) != 0;
        const uint32_t below = node.w & indexBits, above = noBelow ? below : below + 1;
        const double tolerated = allowed * extent_;
        const bool needsBelow = to - reach < -tolerated, needsAbove = to + reach > tolerated;
        const auto isIn = [&](bool none, uint32_t child) {
            return !none && isSphereCovered(child, centre, radius, reference);
        };
        // In the plane, it may be on either side.
        if (!needsBelow && !needsAbove) return isIn(noBelow, below) || isIn(noAbove, above);
        return (!needsBelow || isIn(noBelow, below)) && (!needsAbove || isIn(noAbove, above));
    }

    const Structure& structure_;
    const std::vector<uvec4>& nodes_;
    std::vector<uint8_t> seen_;
    std::vector<std::vector<uint32_t>> leaves_;  // by node, their references in order
    double extent_ = 0.0;
};

std::optional<std::string> findReferenceFault(const Structure& structure, std::span<const Primitive> triangles) {
    std::vector<uint8_t> stored(triangles.size());
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) {
        const uint32_t id = referencedId(structure, i);
        if (id >= triangles.size()) return fmt::format("reference {} names a triangle that is not there", i);
        if (++stored[id] != 1) return fmt::format("triangle {} is stored twice", id);
        if (!refersTo(structure, i, triangles[id]))
            return fmt::format("reference {} has other corners than triangle {}", i, id);
    }
    Box bounds;
    for (size_t id = 0; id < triangles.size(); ++id) {
        if ((stored[id] != 0) != triangles[id].usable()) return fmt::format("triangle {} is missing, or unusable", id);
        if (stored[id] != 0) bounds.grow(triangles[id].box());
    }
    const StructureHeader& header = structure.header;
    if (!bounds.empty() && (bounds.lo * header.unit != header.lo || bounds.hi * header.unit != header.hi))
        return "the bounds are not those of the triangles";
    if (!bounds.empty() && header.gridOrigin != header.lo)
        return "planes are relative to another point than the lower bounds";
    return std::nullopt;
}

}  // namespace

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    if (header.walk != 0) return "there is no such walk";
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    if (structure.nodes.size() != header.nodeCount) return "node count and array differ";
    if (auto fault = findReferenceFault(structure, triangles)) return fault;
    if (header.triangleCount == 0)
        return header.nodeCount == 0 ? std::nullopt : std::optional<std::string>("nodes without triangles");
    if (header.nodeCount == 0) return "triangles without nodes";
    Checker checker(structure);
    if (auto fault = checker.findTreeFault()) return fault;
    for (uint32_t i = 0; i < header.triangleCount; ++i)
        if (!checker.isCovered(i)) return fmt::format("reference {} is not in every leaf that it lies in", i);
    return std::nullopt;
}

}  // namespace raig::bsp
