#include "rays/item_view.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// Where the pixels' clip coordinate a (-1 to 1 over `size` pixels) goes if only `count` of them, from `first` on, are
/// drawn: the factor, and what is added.
struct Window {
    double factor, shift;
};
Window windowOf(double size, double first, double count) {
    return {size / count, (size - 2.0 * first) / count - 1.0};
}

std::array<dvec3, 8> cornersOf(const Box& box) {
    std::array<dvec3, 8> corners;
    for (uint32_t i = 0; i < 8; ++i)
        corners[i] = {(i & 1) ? box.hi.x : box.lo.x, (i & 2) ? box.hi.y : box.lo.y, (i & 4) ? box.hi.z : box.lo.z};
    return corners;
}

vec4 rounded(const dvec4& v) { return {float(v.x), float(v.y), float(v.z), float(v.w)}; }

}  // namespace

ItemProjection::ItemProjection(const shared::FrameParams& frame, const Box& bounds, float unit, const ItemRect& rect,
                               uint32_t scale, double nearest)
    : eye_(dvec3(frame.eye) * double{unit}), forward_(frame.forward) {
    double farthest = 0.0;
    for (const dvec3& corner : cornersOf(bounds)) farthest = std::max(farthest, glm::length(corner - eye_));
    if (!(farthest > 0.0 && std::isfinite(farthest))) farthest = 1.0;

    nearest = std::clamp(nearest, 0x1p-20 * farthest, 0x1p-6 * farthest);
    const Window x = windowOf(double(frame.width) * scale, double(frame.left) * scale + rect.x, rect.width);
    const Window y = windowOf(double(frame.height) * scale, double(frame.top) * scale + rect.y, rect.height);
    const bool parallel = frame.orthographic != 0;
    const double size = parallel ? unit : 1.0;  // half widths are in scene units, or at distance 1
    const dvec3 right = dvec3(frame.right) * (x.factor / (frame.halfWidth * size));
    const dvec3 down = dvec3(frame.up) * (-y.factor / (frame.halfHeight * size));
    itemsAUnit_ = 0.5 * frame.height * scale / (frame.halfHeight * size);
    if (parallel)
        rows_ = {dvec4(right, x.shift), dvec4(down, y.shift), dvec4(-forward_ / (1.01 * farthest), 1.0), dvec4(0, 0, 0, 1)};
    else
        rows_ = {dvec4(right + x.shift * forward_, 0.0), dvec4(down + y.shift * forward_, 0.0),
                 dvec4(0, 0, 0, nearest), dvec4(forward_, 0.0)};
}

dvec4 ItemProjection::clip(const dvec3& point) const {
    const dvec4 p(point - eye_, 1.0);
    return {glm::dot(rows_[0], p), glm::dot(rows_[1], p), glm::dot(rows_[2], p), glm::dot(rows_[3], p)};
}

bool ItemProjection::mayShow(const Box& box) const {
    std::array<bool, 6> beyond;
    beyond.fill(true);
    for (const dvec3& corner : cornersOf(box)) {
        const dvec4 p = clip(corner);
        const std::array<bool, 6> here = {p.x > p.w, p.x < -p.w, p.y > p.w, p.y < -p.w, p.z > p.w, p.z < 0.0};
        for (size_t i = 0; i < here.size(); ++i) beyond[i] = beyond[i] && here[i];
    }
    return std::none_of(beyond.begin(), beyond.end(), [](bool b) { return b; });
}

double ItemProjection::depthOf(const Box& box) const {
    return glm::dot(0.5 * (dvec3(box.lo) + dvec3(box.hi)) - eye_, forward_);
}

double ItemProjection::itemsAcross(const Box& box) const {
    const double size = glm::length(dvec3(box.hi) - dvec3(box.lo));
    const bool parallel = rows_[3].w != 0.0;
    const double distance = parallel ? 1.0 : std::max(depthOf(box) - 0.5 * size, 0.0);
    return distance > 0.0 ? size / distance * itemsAUnit_ : std::numeric_limits<double>::infinity();
}

shared::ItemView ItemProjection::view(uint32_t instancesAt) const {
    return {rounded(rows_[0]), rounded(rows_[1]), rounded(rows_[2]), rounded(rows_[3]),
            vec3(float(eye_.x), float(eye_.y), float(eye_.z)), instancesAt};
}

}  // namespace raig
