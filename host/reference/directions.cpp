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

dvec3 aboutNormal(const dvec3& n, const dvec3& local) {
    const dvec3 s = dvec3(2.0, 3.0, 6.0) / 7.0;
    const dvec3 standing = (local.x * dvec3(3.0, -6.0, 2.0) + local.y * dvec3(6.0, 2.0, -3.0)) / 7.0 + local.z * s;
    if (glm::length(s + n) <= 1e-3) return -standing;
    const dvec3 axis = glm::normalize(s + n);
    return 2.0 * glm::dot(axis, standing) * axis - standing;
}

dvec3 cosineDirection(const dvec3& n, const dvec2& square) {
    const dvec2 disk = inDisk(square);
    return aboutNormal(n, {disk, std::sqrt(std::max(0.0, 1.0 - glm::dot(disk, disk)))});
}

}  // namespace raig::reference
