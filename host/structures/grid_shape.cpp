#include "structures/grid_shape.hpp"

#include <bit>
#include <cmath>

namespace raig::grid {

namespace {

/// The edge of cubes of which `wanted` fill a box of this size; axes shorter than the edge hold one layer of them.
double cellSize(const dvec3& extent, double wanted) {
    bool layered[3] = {true, true, true};
    for (;;) {
        double volume = 1.0;
        int axes = 0;
        for (int axis = 0; axis < 3; ++axis)
            if (layered[axis]) volume *= extent[axis], ++axes;
        const double size = std::pow(volume / wanted, 1.0 / axes);
        int dropped = -1;
        for (int axis = 0; axis < 3; ++axis)
            if (layered[axis] && extent[axis] < size && axes > 1 && (dropped < 0 || extent[axis] < extent[dropped]))
                dropped = axis;
        if (dropped < 0) return size;
        layered[dropped] = false;
    }
}

/// Planes of one axis around [lo, hi], cells about `size` long.
struct AxisPlanes {
    double origin, step;
    uint32_t count, finest;
};

AxisPlanes planesAround(double lo, double hi, double size, double margin) {
    const double q = std::ldexp(1.0, std::ilogb(std::max(std::abs(lo), std::abs(hi))) - 21);
    const double origin = std::floor(lo / q) * q, extent = hi - origin;
    const double most = std::max(1.0, std::min<double>(mostCells, std::floor(extent / (8.0 * q))));
    const double count = std::clamp(std::round(extent / size), 1.0, most);
    const double length = extent / count;
    // Steps of 2^k q, and so parts down to step / 2^k, where that makes the last cell no more than an eighth longer; parts
    // are never so thin that the walk, which is as wrong about its place as the margin says, could miss them.
    uint32_t finest = 0;
    while (finest < fineLog && length >= 16.0 * q * double(1u << finest) && length >= 8.0 * margin * double(1u << finest))
        ++finest;
    const double granule = q * double(1u << finest);
    return {origin, std::ceil(length / granule) * granule, static_cast<uint32_t>(count), finest};
}

}  // namespace

uvec3 Shape::partLogs(uint32_t wanted) const {
    uvec3 logs(0);
    for (int axis = 0; axis < 3; ++axis)
        if (wanted > coarser[axis]) logs[axis] = std::min(wanted - coarser[axis], finest[axis]);
    return logs;
}

Lattice Shape::parts(const uvec3& cell, uint32_t wanted) const {
    const uvec3 logs = partLogs(wanted);
    const uvec3 count = uvec3(1) << logs;
    return {cells.plane(cell), cells.step / dvec3(count), count, cells.margin};
}

Shape shapeOf(const Box& bounds, double wanted, bool divided) {
    const dvec3 extent = dvec3(bounds.hi) - dvec3(bounds.lo);
    const double whole = std::max({extent.x, extent.y, extent.z});
    const double size = std::max(cellSize(glm::max(extent, whole * 0x1p-11), wanted), whole / mostCells);
    // Rays from up to 51 times the scene's size away are near ones with a margin of 2^-12 of it, and up to 6 with 2^-15.
    const double margin =
        static_cast<float>(divided ? whole * 0x1p-15 : std::clamp(size / 64.0, whole * 0x1p-15, whole * 0x1p-12));
    Shape shape{};
    shape.cells.margin = margin;
    for (int axis = 0; axis < 3; ++axis) {
        const AxisPlanes planes = planesAround(bounds.lo[axis] - margin, bounds.hi[axis] + margin, size, margin);
        shape.cells.origin[axis] = planes.origin;
        shape.cells.step[axis] = planes.step;
        shape.cells.count[axis] = planes.count;
        shape.finest[axis] = planes.finest;
        shape.coarser[axis] = static_cast<uint32_t>(std::clamp(std::round(std::log2(size / planes.step)), 0.0, 15.0));
    }
    return shape;
}

Shape shapeOf(const Structure& structure) {
    const StructureHeader& header = structure.header;
    const uvec4 sizes = structure.nodes[0], lists = structure.nodes[1];
    Shape shape{};
    shape.cells = {dvec3(header.gridOrigin), dvec3(header.gridStep), uvec3(sizes.x, sizes.y, sizes.z),
                   std::bit_cast<float>(sizes.w)};
    for (uint32_t axis = 0; axis < 3; ++axis) {
        shape.coarser[static_cast<int>(axis)] = lists.z >> 8 * axis & 15;
        shape.finest[static_cast<int>(axis)] = lists.z >> (8 * axis + 4) & 15;
    }
    return shape;
}

}  // namespace raig::grid
