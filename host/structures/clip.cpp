#include "structures/clip.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raig {

namespace {

// Two cuts of coordinates below 2 in double misplace a point by less than 2^-48.
constexpr double margin = 0x1p-46;

/// A convex polygon: a triangle gains at most one corner a cut.
struct Polygon {
    std::array<dvec3, 9> corners;
    int count = 0;

    void add(const dvec3& corner) { corners[count++] = corner; }
};

/// What of the polygon lies where sign * (x - plane) <= 0 along the axis.
Polygon cut(const Polygon& polygon, int axis, double plane, double sign) {
    Polygon result;
    for (int i = 0; i < polygon.count; ++i) {
        const dvec3& p = polygon.corners[i];
        const dvec3& q = polygon.corners[i + 1 < polygon.count ? i + 1 : 0];
        const double outP = sign * (p[axis] - plane), outQ = sign * (q[axis] - plane);
        if (outP <= 0.0) result.add(p);
        if ((outP < 0.0 && outQ > 0.0) || (outP > 0.0 && outQ < 0.0)) {
            dvec3 crossing = p + (q - p) * (outP / (outP - outQ));
            crossing[axis] = plane;
            result.add(crossing);
        }
    }
    return result;
}

float roundedDown(double x) {
    const auto f = static_cast<float>(x);
    return f > x ? std::nextafter(f, -std::numeric_limits<float>::infinity()) : f;
}

float roundedUp(double x) {
    const auto f = static_cast<float>(x);
    return f < x ? std::nextafter(f, std::numeric_limits<float>::infinity()) : f;
}

/// The interval of an axis in which a sphere has points that are at least `off` from its centre's along the others.
/// Squares of coordinates below 2 are rounded by less than `margin`, and so are roots, but for those near 0.
struct Interval {
    double lo, hi;
};
Interval slice(double centre, double radius, double squaredOff) {
    const double rest = radius * radius - squaredOff + margin;
    const double half = rest > 0.0 ? std::sqrt(rest) : 0.0;
    return {centre - half - margin, centre + half + margin};
}

/// The sphere's box, cut to the box, and along each axis to where the other two leave room for it.
Box clippedSphere(const Primitive& sphere, const Box& box) {
    const Box whole = sphere.box();
    const dvec3 centre(sphere.centre()), below = dvec3(box.lo) - centre, above = centre - dvec3(box.hi);
    const double radius = sphere.radius();
    const dvec3 near = glm::max(glm::max(below, above), 0.0), far = glm::max(glm::abs(below), glm::abs(above));
    if (glm::length(near) > radius + margin || glm::length(far) < radius - margin) return {};
    Box result;
    for (int axis = 0; axis < 3; ++axis) {
        const double off = glm::dot(near, near) - near[axis] * near[axis];
        const Interval left = slice(centre[axis], radius, off);
        result.lo[axis] = std::max({box.lo[axis], whole.lo[axis], roundedDown(left.lo)});
        result.hi[axis] = std::min({box.hi[axis], whole.hi[axis], roundedUp(left.hi)});
    }
    return result.empty() ? Box{} : result;
}

}  // namespace

Box clippedBounds(const Primitive& primitive, const Box& box) {
    if (primitive.isSphere()) return clippedSphere(primitive, box);
    const Primitive& triangle = primitive;
    const Box whole = triangle.box();
    Polygon polygon;
    polygon.add(dvec3(triangle.a));
    polygon.add(dvec3(triangle.b));
    polygon.add(dvec3(triangle.c));
    for (int axis = 0; axis < 3; ++axis) {
        if (whole.lo[axis] < box.lo[axis]) polygon = cut(polygon, axis, box.lo[axis] - margin, -1.0);
        if (whole.hi[axis] > box.hi[axis]) polygon = cut(polygon, axis, box.hi[axis] + margin, 1.0);
    }
    if (polygon.count == 0) return {};
    Box result = box;
    for (int axis = 0; axis < 3; ++axis) {
        double lo = polygon.corners[0][axis], hi = lo;
        for (int i = 1; i < polygon.count; ++i) {
            lo = std::min(lo, polygon.corners[i][axis]);
            hi = std::max(hi, polygon.corners[i][axis]);
        }
        // The triangle's own extremes are exact: flat triangles stay flat.
        const float first = std::max(whole.lo[axis], roundedDown(lo - margin));
        const float last = std::min(whole.hi[axis], roundedUp(hi + margin));
        result.lo[axis] = std::max(box.lo[axis], first);
        result.hi[axis] = std::min(box.hi[axis], last);
    }
    return result.empty() ? Box{} : result;
}

}  // namespace raig
