#include "structures/structure_fault.hpp"

#include "base/parallel.hpp"

#include <fmt/format.h>

#include <atomic>
#include <mutex>

namespace raig {

namespace {

Box boundsOf(std::span<const Primitive> primitives) {
    Box all;
    std::mutex mutex;
    parallelFor(primitives.size(), 65536, [&](size_t begin, size_t end) {
        Box part;
        for (size_t i = begin; i < end; ++i)
            if (primitives[i].usable()) part.grow(primitives[i].box());
        const std::lock_guard lock(mutex);
        all.grow(part);
    });
    return all;
}

/// What is wrong in what all structures share.
std::optional<std::string> findSharedFault(const Structure& structure, std::span<const Primitive> primitives) {
    const StructureHeader& header = structure.header;
    if (header.walk >= shared::MAX_WALKS) return "there is no such walk";
    if (structure.triangles.size() != size_t{header.triangleCount} * shared::TRIANGLE_STRIDE)
        return "triangle count and array differ";
    const Box bounds = boundsOf(primitives);
    const bool sameBounds = bounds.empty() ? header.lo.x > header.hi.x
                                           : header.lo == bounds.lo * header.unit && header.hi == bounds.hi * header.unit;
    if (header.unit != unitOf(bounds) || !sameBounds) return "its bounds are not those of the scene";
    std::atomic<size_t> faults = 0;
    parallelFor(header.triangleCount, 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uint32_t id = referencedId(structure, i);
            if (id >= primitives.size() || !refersTo(structure, i, primitives[id])) ++faults;
        }
    });
    if (faults > 0) return fmt::format("{} of its triangles are not those of the scene", faults.load());
    return std::nullopt;
}

}  // namespace

std::optional<std::string> findOneLevelFault(const Structure& structure, std::span<const Primitive> primitives,
                                             const StructureType& type) {
    std::optional<std::string> fault = findSharedFault(structure, primitives);
    return fault ? fault : type.findFault(structure, primitives);
}

}  // namespace raig
