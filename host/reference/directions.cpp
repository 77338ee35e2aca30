#include "reference/directions.hpp"

#include <algorithm>
#include <numbers>

namespace raig::reference {

dvec2 inDisk(const dvec2& square) {
    constexpr double quarter = std::numbers::pi / 4.0;
    const dvec2 p = 2.0 * square - 1.0;
    if (p == dvec2(0.0)) return p;
    const bool isAside = std::abs(p.x) > std::abs(p.y);
    const double radius = isAside ? p.x : p.y;
    const double angle = isAside ? quarter * p.y / p.x : 2.0 * quarter - quarter * p.x / p.y;
    return radius * dvec2(std::cos(angle), std::sin(angle));
}

namespace {

/// Columns (3, -6, 2) / 7, (6, 2, -3) / 7 and (2, 3, 6) / 7.
const glm::dmat3 standing(dvec3(3.0, -6.0, 2.0) / 7.0, dvec3(6.0, 2.0, -3.0) / 7.0, dvec3(2.0, 3.0, 6.0) / 7.0);

/// The half turn about s + n.
dvec3 turned(const dvec3& v, const dvec3& n) {
    const dvec3 axis = standing[2] + n;
    return glm::length(axis) <= 1e-3 ? -v : 2.0 * glm::dot(axis, v) / glm::dot(axis, axis) * axis - v;
}

}  // namespace

dvec3 aboutNormal(const dvec3& n, const dvec3& local) {
    return turned(standing * local, n);
}

dvec3 alongNormal(const dvec3& n, const dvec3& v) {
    return glm::transpose(standing) * turned(v, n);
}

dvec3 cosineDirection(const dvec3& n, const dvec2& square) {
    const dvec2 disk = inDisk(square);
    return aboutNormal(n, {disk, std::sqrt(std::max(0.0, 1.0 - glm::dot(disk, disk)))});
}

}  // namespace raig::reference
