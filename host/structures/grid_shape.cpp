#include "structures/grid_shape.hpp"

#include <bit>
#include <cmath>
#include <optional>

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

/// Planes that are multiples of q, at most 2^24 q from 0 and from each other: nothing, if they would not be.
std::optional<AxisPlanes> planesOf(double lo, double hi, double size, uint32_t finest, double margin, double q) {
    const double origin = std::floor(lo / q) * q, extent = hi - origin;
    const double most = std::max(1.0, std::min<double>(mostCells, std::floor(extent / (8.0 * q))));
    const double length = extent / std::clamp(std::round(extent / size), 1.0, most);
    // Steps of 2^k q, and so parts down to step / 2^k, where that makes cells no more than a half longer.
    // Parts are never so thin that the walk, which is as wrong about its place as the margin says, could miss them.
    while (finest > 0 && (length < 2.0 * q * double(1u << finest) || length < 8.0 * margin * double(1u << finest))) --finest;
    const double granule = q * double(1u << finest), step = std::ceil(length / granule) * granule;
    const double count = std::ceil(extent / step), end = origin + count * step;
    // That a plane's number is no more than 2^24 follows: step >= 2^finest q.
    if (std::max({std::abs(origin), std::abs(end), end - origin}) > 0x1p24 * q) return std::nullopt;
    return AxisPlanes{origin, step, static_cast<uint32_t>(count), finest};
}

AxisPlanes planesAround(double lo, double hi, double size, uint32_t finest, double margin) {
    for (double q = std::ldexp(1.0, std::ilogb(std::max({std::abs(lo), std::abs(hi), hi - lo})) - 23);; q *= 2.0)
        if (const auto planes = planesOf(lo, hi, size, finest, margin, q)) return *planes;
}

}  // namespace

double Lattice::marginOf(const Primitive& primitive) const {
    if (growth == 0.0) return margin;
    const Box box = primitive.box();
    const dvec3 extent = dvec3(box.hi) - dvec3(box.lo);
    return margin + growth * std::max({extent.x, extent.y, extent.z});
}

uvec3 Shape::logs(uint32_t wanted) const {
    uvec3 logs(0);
    for (int axis = 0; axis < 3; ++axis)
        if (wanted > coarser[axis]) logs[axis] = std::min(wanted - coarser[axis], finest[axis]);
    return logs;
}

Lattice Shape::parts(const Place& place, uint32_t more) const {
    const uvec3 fine = logs(place.wanted + more);
    Lattice parts{{}, {}, uvec3(1) << (fine - logs(place.wanted)), 0.0};
    for (int axis = 0; axis < 3; ++axis) {
        parts.origin[axis] = cells.origin[axis] + std::ldexp(cells.step[axis], -int(fineLog)) * place.first[axis];
        parts.step[axis] = std::ldexp(cells.step[axis], -int(fine[axis]));
    }
    parts.growth = nested ? 64 * 0x1p-24 : 0.0;
    parts.margin = nested ? parts.growth * reachOf(parts) : cells.margin;
    return parts;
}

Place Shape::cell(size_t index) const {
    const uvec3 n = cells.count;
    return {uvec3(index % n.x, index / n.x % n.y, index / n.x / n.y) << fineLog, 0};
}

Place Shape::part(const Place& place, uint32_t more, size_t index) const {
    const uvec3 fine = logs(place.wanted + more), n = uvec3(1) << (fine - logs(place.wanted));
    const uvec3 number(index % n.x, index / n.x % n.y, index / n.x / n.y);
    return {place.first + (number << (fineLog - fine)), place.wanted + more};
}

float Shape::reachOf(const Lattice& parts) const {
    const double near = cells.margin * 0x1p24 / 80.0;
    return static_cast<float>(std::min({near, 0x1p14 * std::min({parts.step.x, parts.step.y, parts.step.z})}));
}

Shape shapeOf(const Box& bounds, double wanted, uint32_t walk) {
    const dvec3 extent = dvec3(bounds.hi) - dvec3(bounds.lo);
    const double whole = std::max({extent.x, extent.y, extent.z});
    const double size = std::max(cellSize(glm::max(extent, whole * 0x1p-11), wanted), whole / mostCells);
    // Rays from up to 51 times the scene's size away are near ones with a margin of 2^-12 of it, and up to 6 with 2^-15.
    const double margin =
        static_cast<float>(walk != 0 ? whole * 0x1p-15 : std::clamp(size / 64.0, whole * 0x1p-15, whole * 0x1p-12));
    Shape shape{};
    shape.cells.margin = margin;
    shape.nested = walk == nestedWalk;
    const uint32_t finest = shape.nested ? fineLog : walk == 0 ? 0 : blockLog;
    for (int axis = 0; axis < 3; ++axis) {
        const AxisPlanes planes =
            planesAround(bounds.lo[axis] - margin, bounds.hi[axis] + margin, size, finest, shape.nested ? 0.0 : margin);
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
    shape.nested = header.walk == nestedWalk;
    for (uint32_t axis = 0; axis < 3; ++axis) {
        shape.coarser[static_cast<int>(axis)] = lists.z >> 8 * axis & 15;
        shape.finest[static_cast<int>(axis)] = lists.z >> (8 * axis + 4) & 15;
    }
    return shape;
}

}  // namespace raig::grid
