#include "structures/brute.hpp"

#include "base/error.hpp"

#include <chrono>

namespace raig::brute {

Structure build(std::span<const Primitive> triangles, const BuildParams& params) {
    refuseOtherOptions(params, "brute", {});
    const auto start = std::chrono::steady_clock::now();
    Structure structure;
    structure.name = "brute";
    structure.walk = "every triangle";
    structure.header = emptyHeader();
    Box bounds;
    for (const Primitive& triangle : triangles)
        if (triangle.usable()) bounds.grow(triangle.box());
    const float unit = unitOf(bounds);
    size_t count = 0;
    structure.triangles.resize(triangles.size() * shared::TRIANGLE_STRIDE);
    for (size_t i = 0; i < triangles.size(); ++i)
        if (triangles[i].usable())
            writeReference(structure.triangles, count++, triangles[i], static_cast<uint32_t>(i), unit);
    structure.triangles.resize(count * shared::TRIANGLE_STRIDE);
    if (count > 0) {
        structure.header.unit = unit;
        structure.header.lo = bounds.lo * unit;
        structure.header.hi = bounds.hi * unit;
    }

    StructureStatistics& statistics = structure.statistics;
    statistics.references = count;
    structure.header.triangleCount = static_cast<uint32_t>(count);
    statistics.bytes = structure.triangles.size() * sizeof(uvec4);
    statistics.sahCost = static_cast<double>(statistics.references);
    statistics.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    return structure;
}

std::optional<std::string> findFault(const Structure& structure, std::span<const Primitive> triangles) {
    if (structure.header.walk != 0) return "there is no such walk";
    uint64_t next = 0;
    for (uint32_t id = 0; id < triangles.size(); ++id) {
        if (!triangles[id].usable()) continue;
        if (next >= structure.header.triangleCount) return fmt::format("triangle {} is not listed", id);
        if (referencedId(structure, next) != id)
            return fmt::format("reference {} is triangle {} and should be {}", next, referencedId(structure, next), id);
        if (!refersTo(structure, next, triangles[id])) return fmt::format("triangle {} is listed with other corners", id);
        ++next;
    }
    if (next != structure.header.triangleCount) return "more references than usable triangles";
    return std::nullopt;
}

}  // namespace raig::brute
