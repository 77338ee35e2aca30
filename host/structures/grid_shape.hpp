/// Where the cells of a grid lie (structures/grid.hpp), and which of them a triangle overlaps.
#pragma once

#include "structures/triangle_box.hpp"

#include <algorithm>

namespace raig::grid {

inline constexpr uint32_t mostCells = 1023;  ///< along an axis: ten bits
inline constexpr uint32_t fineLog = 15;      ///< a cell has at most 2^15 parts of parts along an axis
inline constexpr uint32_t blockLog = 5;      ///< and 2^5 parts
inline constexpr uint32_t firstCell = 8;     ///< the word of the first cell
inline constexpr uint32_t nestedWalk = shared::WALK_NESTED_GRID;
inline constexpr uint32_t crowdedBit = 0x80000000u;
inline constexpr uint32_t lastBit = 0x80000000u;

/// A block of cells, or of the parts of one: `count` along each axis, the first from `origin`, of size `step`.
struct Lattice {
    dvec3 origin, step;
    uvec3 count;
    double margin;  ///< by which a cell is grown all around when primitives are put in it; and by
    double growth = 0.0;  ///< this times the primitive's extent

    double marginOf(const Primitive& primitive) const;
    dvec3 plane(const uvec3& number) const { return origin + dvec3(number) * step; }
    size_t cells() const { return size_t{count.x} * count.y * count.z; }
    size_t index(const uvec3& cell) const { return cell.x + size_t{count.x} * (cell.y + size_t{count.y} * cell.z); }
};

/// Where in a grid a cell is, or a part of one: its first plane along each axis, in the finest division; and log2 of how
/// many times finer than a cell it is, along the longest axis.
struct Place {
    uvec3 first{0};
    uint32_t wanted = 0;
};

/// The cells of a grid, and how those that are crowded may be divided.
struct Shape {
    Lattice cells;
    uvec3 coarser;  ///< log2 of how many times fewer parts than asked for an axis gets, as its cells are shorter
    uvec3 finest;   ///< log2 of the most parts of parts along each axis
    bool nested;    ///< parts may have parts, and margins are in proportion to them

    /// log2 of how many times finer each axis of such a place is than a cell's.
    uvec3 logs(uint32_t wanted) const;
    /// How far away, along an axis, rays may start for which such parts are good, all of a block: so far that roundings are
    /// a sixteenth of a part, but no farther than near rays come from.
    float reachOf(const Lattice& parts) const;
    /// The parts of a cell or a part, 2^more along the longest axis, with margins for rays from within reachOf() them.
    Lattice parts(const Place& place, uint32_t more) const;
    /// Where cell `index` is, and part `index` of those parts.
    Place cell(size_t index) const;
    Place part(const Place& place, uint32_t more, size_t index) const;
};

/// A grid of about `wanted` cells around the bounds of a scene. Requires wanted >= 1; bounds not empty, in their unit.
/// `walk`: as in the header.
Shape shapeOf(const Box& bounds, double wanted, uint32_t walk);

/// The shape that a structure was built with.
Shape shapeOf(const Structure& structure);

/// Calls emit(index) for each cell that the triangle overlaps, as its box test has it, until it returns false. Halves blocks
/// of cells as long as the triangle overlaps them: so it costs what is found, not the cells in the triangle's bounds.
template <class Emit>
void forEachCell(const Primitive& triangle, const Lattice& lattice, const Emit& emit) {
    const PrimitiveBoxTest test(triangle);
    const Box box = triangle.box();
    const dvec3 most = dvec3(lattice.count) - 1.0;
    const double margin = lattice.marginOf(triangle);
    const dvec3 low = glm::ceil((dvec3(box.lo) - margin - lattice.origin) / lattice.step) - 1.0;
    const dvec3 high = glm::floor((dvec3(box.hi) + margin - lattice.origin) / lattice.step);
    if (glm::any(glm::greaterThan(low, most)) || glm::any(glm::lessThan(high, dvec3(0.0)))) return;
    struct Block {
        uvec3 first, last;
    };
    Block pending[40];  // halving 1024^3 cells, one half of each size waits
    size_t count = 0;
    pending[count++] = {uvec3(glm::max(low, 0.0)), uvec3(glm::min(high, most))};
    while (count > 0) {
        const Block block = pending[--count];
        if (!test.overlaps(lattice.plane(block.first) - margin, lattice.plane(block.last + 1u) + margin))
            continue;
        const uvec3 more = block.last - block.first;
        if (more == uvec3(0)) {
            if (!emit(lattice.index(block.first))) return;
            continue;
        }
        const int axis = more.x >= more.y && more.x >= more.z ? 0 : more.y >= more.z ? 1 : 2;
        Block low = block, high = block;
        low.last[axis] = block.first[axis] + more[axis] / 2;
        high.first[axis] = low.last[axis] + 1;
        pending[count++] = high;
        pending[count++] = low;
    }
}

}  // namespace raig::grid
