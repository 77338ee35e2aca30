#include "structures/parts.hpp"

#include <fmt/format.h>

namespace raig {

std::vector<dvec3> partOfPolygon(const std::vector<dvec3>& polygon, int axis, double plane, double sign) {
    std::vector<dvec3> result;
    for (size_t i = 0; i < polygon.size(); ++i) {
        const dvec3 p = polygon[i], q = polygon[(i + 1) % polygon.size()];
        const double outP = sign * (p[axis] - plane), outQ = sign * (q[axis] - plane);
        if (outP <= 0.0) result.push_back(p);
        if ((outP < 0.0) != (outQ < 0.0) && outP != 0.0 && outQ != 0.0)
            result.push_back(p + (q - p) * (outP / (outP - outQ)));
    }
    return result;
}

bool isSurelyIn(const Primitive& sphere, const dvec3& lo, const dvec3& hi) {
    const dvec3 inLo = lo + partThickness, inHi = hi - partThickness, centre(sphere.centre());
    if (!glm::all(glm::lessThan(inLo, inHi))) return false;
    const double nearest = glm::distance(centre, glm::clamp(centre, inLo, inHi));
    const double farthest = glm::length(glm::max(glm::abs(inLo - centre), glm::abs(inHi - centre)));
    return nearest < sphere.radius() - partThickness && farthest > sphere.radius() + partThickness;
}

std::optional<std::string> findListFault(const Structure& structure, std::span<const Primitive> triangles) {
    std::vector<bool> listed(triangles.size());
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) {
        const uint32_t id = referencedId(structure, i);
        if (id >= triangles.size()) return fmt::format("place {} names a triangle that is not there", i);
        if (listed[id]) return fmt::format("triangle {} is listed twice", id);
        listed[id] = true;
        if (!refersTo(structure, i, triangles[id])) return fmt::format("place {} has other corners than triangle {}", i, id);
    }
    for (size_t id = 0; id < triangles.size(); ++id)
        if (listed[id] != triangles[id].usable()) return fmt::format("triangle {} is missing, or unusable", id);
    return std::nullopt;
}

}  // namespace raig
