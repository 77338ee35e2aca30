#include "structures/triangle_box.hpp"

#include <algorithm>

namespace raig {

namespace {

// A projection is three products and two sums of doubles, of which the box's has two, centre and half extent, each rounded
// before: below 16 roundings of 2^-53 of the sum of the products' magnitudes in all, the span's included. The distances of a
// sphere's centre take fewer than 16 roundings of the coordinates they come from.
constexpr double slack = 0x1p-49;

}  // namespace

PrimitiveBoxTest::PrimitiveBoxTest(const Primitive& primitive)
    : isSphere_(primitive.isSphere()), corners_{dvec3(primitive.a), dvec3(primitive.b), dvec3(primitive.c)} {
    if (isSphere_)
        prepareSphere(primitive);
    else
        prepareTriangle();
}

void PrimitiveBoxTest::prepareTriangle() {
    lo_ = glm::min(corners_[0], glm::min(corners_[1], corners_[2]));
    hi_ = glm::max(corners_[0], glm::max(corners_[1], corners_[2]));
    magnitude_ = glm::max(glm::abs(lo_), glm::abs(hi_));
    const std::array<dvec3, 3> edges = {corners_[1] - corners_[0], corners_[2] - corners_[1], corners_[0] - corners_[2]};
    size_t count = 0;
    axes_[count++] = glm::cross(edges[0], edges[1]);
    for (const dvec3& e : edges) {
        axes_[count++] = dvec3(0.0, -e.z, e.y);
        axes_[count++] = dvec3(e.z, 0.0, -e.x);
        axes_[count++] = dvec3(-e.y, e.x, 0.0);
    }
    for (size_t i = 0; i < count; ++i) spans_[i] = spanAlong(axes_[i]);
}

PrimitiveBoxTest::Span PrimitiveBoxTest::spanAlong(const dvec3& axis) const {
    const double a = glm::dot(axis, corners_[0]), b = glm::dot(axis, corners_[1]), c = glm::dot(axis, corners_[2]);
    return {std::min({a, b, c}), std::max({a, b, c})};
}

bool PrimitiveBoxTest::separates(const dvec3& axis, const Span& span, const dvec3& centre, const dvec3& half,
                                 const dvec3& magnitude) const {
    const dvec3 size = glm::abs(axis);
    const double middle = glm::dot(axis, centre);
    const double reach = glm::dot(size, half) + slack * glm::dot(size, magnitude);
    return span.lo > middle + reach || span.hi < middle - reach;
}

void PrimitiveBoxTest::prepareSphere(const Primitive& sphere) {
    radius_ = sphere.radius();
    const Box box = sphere.box();
    lo_ = box.lo;
    hi_ = box.hi;
    magnitude_ = glm::max(glm::abs(lo_), glm::abs(hi_));
}

bool PrimitiveBoxTest::meetsSphere(const dvec3& lo, const dvec3& hi) const {
    const dvec3 below = lo - corners_[0], above = corners_[0] - hi;
    const double near = glm::length(glm::max(glm::max(below, above), 0.0));
    const double far = glm::length(glm::max(glm::abs(below), glm::abs(above)));
    const dvec3 magnitudes = magnitude_ + glm::max(glm::abs(lo), glm::abs(hi));
    const double rounding = slack * (magnitudes.x + magnitudes.y + magnitudes.z);
    return near <= radius_ + rounding && far >= radius_ - rounding;
}

bool PrimitiveBoxTest::overlaps(const dvec3& lo, const dvec3& hi) const {
    if (glm::any(glm::lessThan(hi_, lo)) || glm::any(glm::lessThan(hi, lo_))) return false;  // exact
    if (isSphere_) return meetsSphere(lo, hi);
    const dvec3 centre = 0.5 * lo + 0.5 * hi, half = 0.5 * hi - 0.5 * lo;
    const dvec3 magnitude = magnitude_ + glm::max(glm::abs(lo), glm::abs(hi));
    for (size_t i = 0; i < axes_.size(); ++i)
        if (separates(axes_[i], spans_[i], centre, half, magnitude)) return false;
    return true;
}

}  // namespace raig
