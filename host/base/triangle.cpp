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

/// The error of the rounded sum a + b, exactly [Knuth 1969, "The Art of Computer Programming", volume 2, section 4.2.2].
float errorOfSum(float a, float b) {
    const float sum = a + b, ofB = sum - a, ofA = sum - ofB;
    return (a - ofA) + (b - ofB);
}

float sumDown(float a, float b) {
    const float sum = a + b;
    return errorOfSum(a, b) < 0.0f ? std::nextafter(sum, -std::numeric_limits<float>::infinity()) : sum;
}

}  // namespace

bool isInRange(const vec3& p) {
    return std::abs(p.x) <= largestCoordinate && std::abs(p.y) <= largestCoordinate && std::abs(p.z) <= largestCoordinate;
}

bool isUsable(const vec3& a, const vec3& b, const vec3& c) {
    return isInRange(a) && isInRange(b) && isInRange(c) && !isCollinear(a, b, c);
}

bool isUsableSphere(const vec3& centre, float radius) {
    if (!(radius > 0.0f) || !isInRange(centre) || !(radius <= largestCoordinate)) return false;
    const Box box = sphereBox(centre, radius);
    return isInRange(box.lo) && isInRange(box.hi);
}

Box sphereBox(const vec3& centre, float radius) {
    Box box;
    for (int axis = 0; axis < 3; ++axis) {
        box.lo[axis] = sumDown(centre[axis], -radius);
        box.hi[axis] = -sumDown(-centre[axis], -radius);
    }
    return box;
}

}  // namespace raig
