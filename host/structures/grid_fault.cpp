#include "structures/grid.hpp"
#include "structures/grid_shape.hpp"
#include "structures/parts.hpp"

#include <bit>

#include <fmt/format.h>

namespace raig::grid {

namespace {

using Fault = std::optional<std::string>;

/// The rays that the near walk takes may be misplaced by 67/80 of the margin, and in parts by 57/64 of theirs: triangles
/// that come nearer to a cell must be in its list. Farther than the margin, and something for rounding, they must not.
constexpr double leastMargin = 67.0 / 80.0, leastPartMargin = 57.0 / 64.0, mostMargin = 1.0 + 0x1p-20;

uint32_t wordAt(const Structure& structure, uint64_t index) {
    return structure.nodes[index / 4][static_cast<int>(index % 4)];
}

/// True if something of the triangle lies in the box: cut by its six half-spaces in turn. Or of the sphere, for certain.
bool comesInto(const Primitive& t, const dvec3& lo, const dvec3& hi) {
    if (t.isSphere()) return isSurelyIn(t, lo, hi);
    std::vector<dvec3> polygon = {dvec3(t.a), dvec3(t.b), dvec3(t.c)};
    for (int axis = 0; axis < 3 && !polygon.empty(); ++axis)
        polygon = partOfPolygon(partOfPolygon(polygon, axis, lo[axis], -1.0), axis, hi[axis], 1.0);
    return !polygon.empty();
}

/// The bounds tell the walk how far away the scene is.
Fault findBoundsFault(const Structure& structure) {
    Box bounds;
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) bounds.grow(referencedPrimitive(structure, i).box());
    if (bounds.lo != structure.header.lo || bounds.hi != structure.header.hi) return "the bounds are not the triangles'";
    return std::nullopt;
}

/// Planes as the walk computes them are those of exact arithmetic, and hold the bounds and the margin between them.
Fault findPlaneFault(const Structure& structure, const Shape& shape) {
    const StructureHeader& header = structure.header;
    const Lattice& cells = shape.cells;
    if (!(cells.margin > 0.0)) return "the margin is not positive";
    for (int axis = 0; axis < 3; ++axis) {
        const uint32_t count = cells.count[axis], finest = header.walk == 0 ? 0 : shape.finest[axis];
        if (count < 1 || count > mostCells) return fmt::format("{} cells along axis {}", count, axis);
        if (finest > fineLog) return fmt::format("cells may have 2^{} parts along axis {}", finest, axis);
        const double origin = cells.origin[axis], step = std::ldexp(cells.step[axis], -static_cast<int>(finest));
        const double end = origin + cells.step[axis] * count;
        const double most = std::max({std::abs(origin), std::abs(end), end - origin});
        const double granule = std::exp2(std::ceil(std::log2(std::max(most, 0x1p-120))) - 24);
        if (std::fmod(origin, granule) != 0.0 || std::fmod(step, granule) != 0.0)
            return fmt::format("planes of axis {} are rounded", axis);
        if (!(step > 0.0)) return fmt::format("planes of axis {} do not increase", axis);
        if (count > 1 && std::ldexp(cells.step[axis], shape.nested ? 0 : -static_cast<int>(finest)) < cells.margin)
            return fmt::format("cells are too thin for the margin along axis {}", axis);
        if (cells.origin[axis] > header.lo[axis] - cells.margin ||
            cells.plane(cells.count)[axis] < header.hi[axis] + cells.margin)
            return fmt::format("the scene or its margin sticks out of the grid along axis {}", axis);
    }
    return std::nullopt;
}

/// Checks the cells of a lattice, the first of which is word `first`, against the triangles that may come near them.
class LatticeChecker {
public:
    LatticeChecker(const Structure& structure, const Lattice& lattice, uint64_t first, double leastMargin)
        : structure_(structure), lattice_(lattice), first_(first), leastMargin_(leastMargin) {}

    /// `members`: numbers of triangles; all those that come near any of the cells.
    Fault findFault(std::span<const uint32_t> members) const {
        for (size_t cell = 0; cell < lattice_.cells(); ++cell)
            if (Fault fault = findListFault(cell)) return fault;
        for (const uint32_t member : members)
            if (Fault fault = findMissing(member)) return fault;
        return std::nullopt;
    }

    /// The list of a cell, or its own list if it is crowded. Requires that there is no fault in it.
    std::vector<uint32_t> list(size_t cell) const {
        std::vector<uint32_t> result;
        const uint32_t word = listWord(cell);
        if (word == 0) return result;
        for (uint64_t at = listsBegin() + word - 1;; ++at) {
            result.push_back(wordAt(structure_, at) & ~lastBit);
            if ((wordAt(structure_, at) & lastBit) != 0) return result;
        }
    }

    uint32_t listWord(size_t cell) const {
        const uint32_t word = wordAt(structure_, first_ + cell);
        return (word & crowdedBit) == 0 ? word : wordAt(structure_, (word & 0x0fffffffu) * uint64_t{8});
    }

private:
    std::string at(size_t cell, std::string_view what) const {
        return fmt::format("cell {} of those from word {} on: {}", cell, first_, what);
    }
    uint64_t listsBegin() const { return uint64_t{structure_.nodes[1].x} * 4; }

    Fault findListFault(size_t cell) const {
        const uint32_t word = wordAt(structure_, first_ + cell);
        if ((word & crowdedBit) != 0 && (word & 0x0fffffffu) * uint64_t{8} + firstCell >= listsBegin())
            return at(cell, "its parts lie beyond the cells");
        const uint32_t begin = listWord(cell), words = structure_.nodes[1].y;
        const dvec3 from = lattice_.plane(placeOf(cell)), to = lattice_.plane(placeOf(cell) + 1u);
        uint32_t previous = 0;
        for (uint64_t i = begin; i > 0; ++i) {
            if (i > words) return at(cell, "its list does not end");
            const uint32_t reference = wordAt(structure_, listsBegin() + i - 1), number = reference & ~lastBit;
            if (number >= structure_.header.triangleCount) return at(cell, "it lists a triangle that is not there");
            if (i > begin && number <= previous) return at(cell, "its list is not in order");
            const Primitive triangle = referencedPrimitive(structure_, number);
            const Box box = triangle.box();
            const double margin = lattice_.marginOf(triangle) * mostMargin;
            if (glm::any(glm::lessThan(dvec3(box.hi), from - margin)) || glm::any(glm::lessThan(to + margin, dvec3(box.lo))))
                return at(cell, fmt::format("it lists triangle {}, which is not there", number));
            previous = number;
            if ((reference & lastBit) != 0) break;
        }
        return std::nullopt;
    }

    uvec3 placeOf(size_t cell) const {
        const uvec3 n = lattice_.count;
        return {cell % n.x, cell / n.x % n.y, cell / n.x / n.y};
    }

    Fault findMissing(uint32_t member) const {
        const Primitive triangle = referencedPrimitive(structure_, member);
        const Box box = triangle.box();
        const double margin = leastMargin_ * lattice_.marginOf(triangle);
        const dvec3 most = dvec3(lattice_.count) - 1.0;
        const uvec3 from(glm::clamp(glm::floor((dvec3(box.lo) - margin - lattice_.origin) / lattice_.step), dvec3(0), most));
        const uvec3 to(glm::clamp(glm::floor((dvec3(box.hi) + margin - lattice_.origin) / lattice_.step), dvec3(0), most));
        for (uint32_t z = from.z; z <= to.z; ++z)
            for (uint32_t y = from.y; y <= to.y; ++y)
                for (uint32_t x = from.x; x <= to.x; ++x) {
                    const uvec3 place(x, y, z);
                    if (!comesInto(triangle, lattice_.plane(place) - margin, lattice_.plane(place + 1u) + margin)) continue;
                    if (!lists(lattice_.index(place), member))
                        return at(lattice_.index(place), fmt::format("it does not list triangle {}", member));
                }
        return std::nullopt;
    }

    bool lists(size_t cell, uint32_t member) const {
        const uint32_t begin = listWord(cell);
        if (begin == 0) return false;
        uint64_t at = listsBegin() + begin - 1;
        for (;; ++at) {
            const uint32_t reference = wordAt(structure_, at);
            if ((reference & ~lastBit) >= member) return (reference & ~lastBit) == member;
            if ((reference & lastBit) != 0) return false;
        }
    }

    const Structure& structure_;
    const Lattice& lattice_;
    uint64_t first_;
    double leastMargin_;
};

/// Checks that crowded cells' parts lie apart, and hold what their cell does.
class PartChecker {
public:
    PartChecker(const Structure& structure, const Shape& shape) : structure_(structure), shape_(shape) {}

    Fault findFault(const LatticeChecker& cells) {
        for (size_t cell = 0; cell < shape_.cells.cells(); ++cell)
            if (Fault fault = findCellFault(wordAt(structure_, firstCell + cell), shape_.cell(cell), cells, cell))
                return fault;
        std::sort(taken_.begin(), taken_.end());
        for (size_t i = 1; i < taken_.size(); ++i)
            if (taken_[i].first < taken_[i - 1].second) return "the parts of two cells overlap";
        return std::nullopt;
    }

private:
    /// Of cell `index` of `cells`, which has the word: nothing if it is not crowded.
    Fault findCellFault(uint32_t word, const Place& place, const LatticeChecker& cells, size_t index) {
        if ((word & crowdedBit) == 0) return std::nullopt;
        const uint32_t more = word >> 28 & 7;
        const auto at = [&](std::string_view what) {
            return fmt::format("cell {} {} {}, level {}: {}", place.first.x, place.first.y, place.first.z, place.wanted,
                               what);
        };
        if (structure_.header.walk == 0 || more == 0 || more > blockLog) return at("it is divided as it may not be");
        const Lattice parts = shape_.parts(place, more);
        const uint64_t begin = (word & 0x0fffffffu) * uint64_t{8}, end = begin + firstCell + parts.cells();
        if (begin < firstCell + shape_.cells.cells() || end > uint64_t{structure_.nodes[1].x} * 4 || parts.cells() == 1)
            return at("its parts lie outside");
        taken_.emplace_back(begin, end);
        takenWords_ += end - begin;
        if (takenWords_ > structure_.nodes.size() * 4) return "the parts of two cells overlap";
        if (shape_.nested && wordAt(structure_, begin + 1) != std::bit_cast<uint32_t>(shape_.reachOf(parts)))
            return at("its reach is not its own");
        const LatticeChecker checker(structure_, parts, begin + firstCell, shape_.nested ? leastPartMargin : leastMargin);
        if (Fault fault = checker.findFault(cells.list(index))) return fault;
        for (size_t part = 0; part < parts.cells(); ++part) {
            if (!shape_.nested && (wordAt(structure_, begin + firstCell + part) & crowdedBit) != 0)
                return at("a part is divided again");
            if (Fault fault = findCellFault(wordAt(structure_, begin + firstCell + part), shape_.part(place, more, part),
                                            checker, part))
                return fault;
        }
        return std::nullopt;
    }

    const Structure& structure_;
    const Shape& shape_;
    std::vector<std::pair<uint64_t, uint64_t>> taken_;  // words
    uint64_t takenWords_ = 0;
};

}  // namespace

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    const StructureHeader& header = structure.header;
    if (header.walk > nestedWalk) return "there is no such walk";
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    if (auto fault = findListFault(structure, triangles)) return fault;
    if (header.triangleCount == 0) return structure.nodes.empty() ? Fault() : "nodes without triangles";
    if (Fault fault = findBoundsFault(structure)) return fault;
    if (structure.nodes.size() < 4) return "there is no grid";
    const Shape shape = shapeOf(structure);
    if (Fault fault = findPlaneFault(structure, shape)) return fault;
    const uint64_t cellsEnd = firstCell + shape.cells.cells(), listsBegin = uint64_t{structure.nodes[1].x} * 4;
    if (cellsEnd > listsBegin || (listsBegin + structure.nodes[1].y + 3) / 4 != structure.nodes.size())
        return "cells, lists and the array of nodes differ in size";
    std::vector<uint32_t> all(header.triangleCount);
    for (uint32_t i = 0; i < header.triangleCount; ++i) all[i] = i;
    const LatticeChecker cells(structure, shape.cells, firstCell, leastMargin);
    if (Fault fault = cells.findFault(all)) return fault;
    return PartChecker(structure, shape).findFault(cells);
}

}  // namespace raig::grid
