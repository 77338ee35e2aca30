/// Where the cells of a grid lie (structures/grid.hpp), and which of them a triangle overlaps.
#pragma once

#include "structures/triangle_box.hpp"

#include <algorithm>

namespace raig::grid {

inline constexpr uint32_t mostCells = 1023;  ///< along an axis: ten bits
inline constexpr uint32_t fineLog = 5;       ///< a crowded cell has at most 2^5 parts along an axis
inline constexpr uint32_t firstCell = 8;     ///< the word of the first cell
inline constexpr uint32_t crowdedBit = 0x80000000u;
inline constexpr uint32_t lastBit = 0x80000000u;

/// A block of cells, or of the parts of one: `count` along each axis, the first from `origin`, of size `step`.
struct Lattice {
    dvec3 origin, step;
    uvec3 count;
    double margin;  ///< by which a cell is grown all around when triangles are put in it

    dvec3 plane(const uvec3& number) const { return origin + dvec3(number) * step; }
    size_t cells() const { return size_t{count.x} * count.y * count.z; }
    size_t index(const uvec3& cell) const { return cell.x + size_t{count.x} * (cell.y + size_t{count.y} * cell.z); }
};

/// The cells of a grid, and how those that are crowded may be divided.
struct Shape {
    Lattice cells;
    uvec3 coarser;  ///< log2 of how many times fewer parts than asked for an axis gets, as its cells are shorter
    uvec3 finest;   ///< log2 of the most parts along each axis

    /// log2 of the number of parts along each axis of a crowded cell, of which 2^wanted are wanted along the longest.
    uvec3 partLogs(uint32_t wanted) const;
    /// Those parts. Requires wanted <= fineLog.
    Lattice parts(const uvec3& cell, uint32_t wanted) const;
};

/// A grid of about `wanted` cells around the bounds of a scene. Requires wanted >= 1; bounds not empty, in their unit.
/// `divided`: cells may be divided, so the margin is fit for their parts.
Shape shapeOf(const Box& bounds, double wanted, bool divided);

/// The shape that a structure was built with.
Shape shapeOf(const Structure& structure);

/// Calls emit(index) for each cell that the triangle overlaps, as its box test has it, until it returns false. Halves blocks
/// of cells as long as the triangle overlaps them: so it costs what is found, not the cells in the triangle's bounds.
template <class Emit>
void forEachCell(const Primitive& triangle, const Lattice& lattice, const Emit& emit) {
    const PrimitiveBoxTest test(triangle);
    const Box box = triangle.box();
    const dvec3 most = dvec3(lattice.count) - 1.0;
    const dvec3 low = glm::ceil((dvec3(box.lo) - lattice.margin - lattice.origin) / lattice.step) - 1.0;
    const dvec3 high = glm::floor((dvec3(box.hi) + lattice.margin - lattice.origin) / lattice.step);
    if (glm::any(glm::greaterThan(low, most)) || glm::any(glm::lessThan(high, dvec3(0.0)))) return;
    struct Block {
        uvec3 first, last;
    };
    Block pending[40];  // halving 1024^3 cells, one half of each size waits
    size_t count = 0;
    pending[count++] = {uvec3(glm::max(low, 0.0)), uvec3(glm::min(high, most))};
    while (count > 0) {
        const Block block = pending[--count];
        if (!test.overlaps(lattice.plane(block.first) - lattice.margin, lattice.plane(block.last + 1u) + lattice.margin))
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
