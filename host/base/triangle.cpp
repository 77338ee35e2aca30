#include "base/triangle.hpp"

#include <algorithm>

namespace raig {

namespace {

double largestComponent(const dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

bool isCollinear(const vec3& a, const vec3& b, const vec3& c) {
    // Differences of floats are exact in double or nearly so; each product then errs by one part in 2^53.
    const dvec3 ab = dvec3(b) - dvec3(a);
    const dvec3 ac = dvec3(c) - dvec3(a);
    return largestComponent(glm::cross(ab, ac)) <= largestComponent(ab) * largestComponent(ac) * 0x1p-51;
}

}  // namespace

bool isInRange(const vec3& p) {
    return std::abs(p.x) <= largestCoordinate && std::abs(p.y) <= largestCoordinate && std::abs(p.z) <= largestCoordinate;
}

bool isUsable(const vec3& a, const vec3& b, const vec3& c) {
    return isInRange(a) && isInRange(b) && isInRange(c) && !isCollinear(a, b, c);
}

}  // namespace raig
