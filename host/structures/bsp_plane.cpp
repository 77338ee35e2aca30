#include "structures/bsp_plane.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace raig::bsp {

namespace {

constexpr int32_t one = 1 << 20;

// A component in 21 or 22 bits, from -1 on.
uint32_t biased(int32_t steps) {
    return static_cast<uint32_t>(steps + one);
}

dvec3 crossing(const dvec3& p, const dvec3& q, double atP, double atQ) {
    return p + (atP / (atP - atQ)) * (q - p);
}

/// The vector area of a face's part where `to`, the corners' distance from a plane, is negative. The plane cuts the face.
dvec3 partBelow(std::span<const dvec3> face, std::span<const double> to) {
    dvec3 twice(0.0), origin(0.0), last(0.0);
    bool any = false;
    const auto add = [&](const dvec3& p) {
        if (any) {
            twice += glm::cross(last, p - origin);
            last = p - origin;
        } else {
            origin = p;
            any = true;
        }
    };
    for (size_t i = 0, previous = face.size() - 1; i < face.size(); previous = i++) {
        if ((to[previous] < 0.0) != (to[i] < 0.0)) add(crossing(face[previous], face[i], to[previous], to[i]));
        if (to[i] < 0.0) add(face[i]);
    }
    return 0.5 * twice;
}

}  // namespace

Plane Plane::alongAxis(int axis, double coordinate) {
    Plane plane;
    plane.steps[axis] = -one;  // 1 itself is one step too many for its bits
    plane.distance = -static_cast<float>(coordinate);
    return plane;
}

std::optional<Plane> Plane::across(const dvec3& normal, std::span<const dvec3> points) {
    const double sum = std::abs(normal.x) + std::abs(normal.y) + std::abs(normal.z);
    if (!(sum >= std::numeric_limits<double>::min()) || !std::isfinite(sum)) return std::nullopt;
    Plane plane;
    // Rounding adds 1.5 at most to the sum.
    for (int axis = 0; axis < 3; ++axis)
        plane.steps[axis] = static_cast<int32_t>(std::lround(normal[axis] / sum * (one - 2)));
    for (int axis = 0; axis < 3; ++axis)
        if (std::abs(plane.steps[axis]) == one - 2) plane.steps = alongAxis(axis, 0.0).steps;
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const dvec3& point : points) {
        lo = std::min(lo, plane.to(point));
        hi = std::max(hi, plane.to(point));
    }
    plane.distance = static_cast<float>(0.5 * (lo + hi));
    return plane;
}

uvec4 Plane::encoded(uint32_t word) const {
    const uint32_t z = biased(steps[2]);
    return {biased(steps[0]) | z << 21, biased(steps[1]) | z >> 11 << 21, std::bit_cast<uint32_t>(distance), word};
}

Plane Plane::decoded(const uvec4& node) {
    const auto steps = [](uint32_t bits) { return static_cast<int32_t>(bits) - one; };
    Plane plane;
    plane.steps = {steps(node.x & 0x1fffff), steps(node.y & 0x1fffff), steps(node.x >> 21 | node.y >> 21 << 11)};
    plane.distance = std::bit_cast<float>(node.z);
    return plane;
}

void clip(std::span<const dvec3> polygon, const Plane& plane, double side, double margin, std::vector<dvec3>& result) {
    const auto outside = [&](const dvec3& point) { return -side * plane.to(point) - margin; };
    double before = outside(polygon.back());
    for (size_t i = 0; i < polygon.size(); ++i) {
        const dvec3& previous = polygon[i == 0 ? polygon.size() - 1 : i - 1];
        const double here = outside(polygon[i]);
        if ((before < 0.0 && here > 0.0) || (before > 0.0 && here < 0.0))
            result.push_back(crossing(previous, polygon[i], before, here));
        if (here <= 0.0) result.push_back(polygon[i]);
        before = here;
    }
}

Cell::Cell(const dvec3& size) {
    for (int axis = 0; axis < 3; ++axis)
        for (int high = 0; high < 2; ++high)
            for (int corner = 0; corner < 4; ++corner) {
                // 00, 10, 11, 01 in the next two axes, and the other way round for the lower face.
                const int turn = high == 1 ? corner : 3 - corner;
                dvec3 p;
                p[axis] = high == 1 ? size[axis] : 0.0;
                p[(axis + 1) % 3] = turn == 1 || turn == 2 ? size[(axis + 1) % 3] : 0.0;
                p[(axis + 2) % 3] = turn >= 2 ? size[(axis + 2) % 3] : 0.0;
                corners_.push_back(p);
                if (corner == 3) endFace();
            }
}

double Cell::area() const {
    double sum = 0.0;
    for (const double area : faceAreas_) sum += area;
    return sum;
}

void Cell::endFace() {
    const uint32_t begin = ends_.empty() ? 0 : ends_.back();
    if (corners_.size() < begin + 3) {
        corners_.resize(begin);
        return;
    }
    dvec3 twice(0.0);
    for (size_t i = begin + 2; i < corners_.size(); ++i)
        twice += glm::cross(corners_[i - 1] - corners_[begin], corners_[i] - corners_[begin]);
    ends_.push_back(static_cast<uint32_t>(corners_.size()));
    faceVectors_.push_back(0.5 * twice);
    faceAreas_.push_back(0.5 * glm::length(twice));
}

std::array<double, 2> Cell::areas(const Plane& plane) const {
    const dvec3 n = plane.normal();
    const double d = plane.distance;
    constexpr size_t most = 128;
    std::array<double, most> to;
    double below = 0.0, above = 0.0;
    dvec3 cut(0.0);
    uint32_t begin = 0;
    for (size_t face = 0; face < ends_.size(); ++face) {
        const uint32_t count = std::min<uint32_t>(ends_[face] - begin, most);
        double lo = std::numeric_limits<double>::infinity(), hi = -lo;
        for (uint32_t i = 0; i < count; ++i) {
            to[i] = glm::dot(n, corners_[begin + i]) - d;
            lo = std::min(lo, to[i]);
            hi = std::max(hi, to[i]);
        }
        if (lo >= 0.0) {
            above += faceAreas_[face];
        } else if (hi <= 0.0) {
            below += faceAreas_[face];
            cut += faceVectors_[face];
        } else {
            const dvec3 part = partBelow(std::span(corners_).subspan(begin, count), std::span(to).first(count));
            const double area = glm::length(part);
            below += area;
            above += std::max(faceAreas_[face] - area, 0.0);
            cut += part;
        }
        begin = ends_[face];
    }
    if (above == 0.0 || below == 0.0) return {below, above};
    const double size = glm::length(cut);
    return {below + size, above + size};
}

Cell Cell::part(const Plane& plane, double side) const {
    Cell result;
    std::vector<dvec3> cut;
    uint32_t begin = 0;
    for (const uint32_t end : ends_) {
        const std::span<const dvec3> face(corners_.data() + begin, end - begin);
        clip(face, plane, side, 0.0, result.corners_);
        result.endFace();
        double before = plane.to(face.back());
        for (size_t i = 0; i < face.size(); ++i) {
            const double here = plane.to(face[i]);
            if ((before < 0.0 && here > 0.0) || (before > 0.0 && here < 0.0))
                cut.push_back(crossing(face[i == 0 ? face.size() - 1 : i - 1], face[i], before, here));
            if (here == 0.0) cut.push_back(face[i]);
            before = here;
        }
        begin = end;
    }
    result.addCut(std::move(cut), plane.normal() * -side);
    return result;
}

void Cell::addCut(std::vector<dvec3> corners, const dvec3& outwards) {
    if (corners.size() < 3) return;
    dvec3 middle(0.0);
    for (const dvec3& p : corners) middle += p;
    middle /= static_cast<double>(corners.size());
    const dvec3 n = glm::normalize(outwards);
    const dvec3 u = glm::normalize(glm::cross(n, std::abs(n.x) < 0.7 ? dvec3(1, 0, 0) : dvec3(0, 1, 0)));
    const dvec3 v = glm::cross(n, u);
    std::vector<std::pair<double, dvec3>> byAngle;
    for (const dvec3& p : corners) byAngle.emplace_back(std::atan2(glm::dot(p - middle, v), glm::dot(p - middle, u)), p);
    std::sort(byAngle.begin(), byAngle.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
    // Each corner comes from two faces.
    double size = 0.0;
    for (const auto& [angle, p] : byAngle) size = std::max(size, glm::length(p - middle));
    const size_t first = corners_.size();
    for (const auto& [angle, p] : byAngle)
        if (corners_.size() == first || glm::length(p - corners_.back()) > size * 0x1p-40) corners_.push_back(p);
    endFace();
}

void Cell::bounds(dvec3& lo, dvec3& hi) const {
    lo = dvec3(std::numeric_limits<double>::infinity());
    hi = -lo;
    for (const dvec3& p : corners_) {
        lo = glm::min(lo, p);
        hi = glm::max(hi, p);
    }
}

}  // namespace raig::bsp
