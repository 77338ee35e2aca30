#include "structures/bsp_split.hpp"

#include "base/parallel.hpp"

#include <algorithm>
#include <limits>

namespace raig::bsp {

namespace {

constexpr size_t mostSamples = 16;      // triangles that planes are taken from
constexpr size_t mostCounted = 1024;    // parts that the cost of such a plane is estimated by
constexpr size_t parallelSize = 16384;  // parts, from which on axes are searched in parallel

struct Counts {
    double below = 0, above = 0, planar = 0;
};

/// The better side for what lies in the plane, and the cost, by the areas of the two parts of the cell.
Split splitOf(const Plane& plane, const Counts& counts, const std::array<double, 2>& areas, double area) {
    const double below = counts.below * areas[0] + (counts.above + counts.planar) * areas[1];
    const double above = (counts.below + counts.planar) * areas[0] + counts.above * areas[1];
    Split split{plane, below <= above, nodeCost + std::min(below, above) / area};
    return split;
}

/// Whether either side gets less than everything, or both if `dividing`.
bool separates(const Counts& counts, double all, bool dividing) {
    const bool below = counts.below < all, above = counts.above < all;
    const bool empty = counts.below + counts.planar == 0.0 || counts.above + counts.planar == 0.0 || counts.planar == all;
    return dividing ? below && above && !empty : below || above;
}

/// Searches the axis-aligned planes at the ends of all parts. Counts are exact; areas are those of boxes, so that only the
/// best plane's need be those of the cell.
class AxisSearch {
public:
    AxisSearch(const Piece& piece, int axis, double tolerance, bool dividing)
        : axis_(axis), tolerance_(tolerance), dividing_(dividing) {
        piece.cell.bounds(lo_, hi_);
        starts_.reserve(piece.parts.size());
        ends_.reserve(piece.parts.size());
        for (const Part& part : piece.parts) {
            double lo = std::numeric_limits<double>::infinity(), hi = -lo;
            for (const dvec3& corner : piece.polygon(part)) {
                lo = std::min(lo, corner[axis]);
                hi = std::max(hi, corner[axis]);
            }
            lo -= part.radius;
            hi += part.radius;
            starts_.push_back(lo);
            ends_.push_back(hi);
            if (hi - lo <= 2 * tolerance) planar_.push_back(0.5 * (lo + hi));
        }
        std::sort(starts_.begin(), starts_.end());
        std::sort(ends_.begin(), ends_.end());
        std::sort(planar_.begin(), planar_.end());
    }

    struct Found {
        double coordinate;
        Counts counts;
        double cost = std::numeric_limits<double>::infinity();
    };

    Found best() {
        Found found;
        size_t below = 0, notAbove = 0, planarBegin = 0, planarEnd = 0;
        size_t s = 0, e = 0;
        while (s < starts_.size() || e < ends_.size()) {
            const double x = s < starts_.size() && starts_[s] <= ends_[e] ? starts_[s++] : ends_[e++];
            while (below < starts_.size() && starts_[below] < x - tolerance_) ++below;
            while (notAbove < ends_.size() && ends_[notAbove] <= x + tolerance_) ++notAbove;
            while (planarBegin < planar_.size() && planar_[planarBegin] < x - tolerance_) ++planarBegin;
            while (planarEnd < planar_.size() && planar_[planarEnd] <= x + tolerance_) ++planarEnd;
            if (x <= lo_[axis_] || x >= hi_[axis_]) continue;
            consider(x,
                     {static_cast<double>(below), static_cast<double>(ends_.size() - notAbove),
                      static_cast<double>(planarEnd - std::min(planarBegin, planarEnd))},
                     found);
        }
        return found;
    }

private:
    void consider(double x, const Counts& counts, Found& found) const {
        if (!separates(counts, static_cast<double>(ends_.size()), dividing_)) return;
        const dvec3 size = hi_ - lo_;
        const double end = size[(axis_ + 1) % 3] * size[(axis_ + 2) % 3];
        const double around = size[(axis_ + 1) % 3] + size[(axis_ + 2) % 3];
        const std::array<double, 2> areas = {end + around * (x - lo_[axis_]), end + around * (hi_[axis_] - x)};
        const double cost = splitOf({}, counts, areas, 1.0).cost;
        if (cost < found.cost) found = {x, counts, cost};
    }

    int axis_;
    double tolerance_;
    bool dividing_;
    dvec3 lo_, hi_;  // of the cell
    std::vector<double> starts_, ends_, planar_;
};

Counts countSides(const Piece& piece, const Plane& plane, double tolerance) {
    const size_t stride = (piece.parts.size() + mostCounted - 1) / mostCounted;
    Counts counts;
    double counted = 0.0;
    for (size_t i = 0; i < piece.parts.size(); i += stride) {
        const Sides sides = sidesOf(piece, piece.parts[i], plane, tolerance);
        counts.below += sides.below;
        counts.above += sides.above;
        counts.planar += !sides.below && !sides.above;
        counted += 1.0;
    }
    const double scale = static_cast<double>(piece.parts.size()) / counted;
    return {counts.below * scale, counts.above * scale, counts.planar * scale};
}

/// Takes the best of the planes it is shown.
class Chooser {
public:
    Chooser(const Piece& piece, double tolerance, bool dividing)
        : piece_(piece), tolerance_(tolerance), dividing_(dividing), area_(piece.cell.area()) {}

    void consider(const Plane& plane) {
        const Counts counts = countSides(piece_, plane, tolerance_);
        const auto all = static_cast<double>(piece_.parts.size());
        // Even if the smaller side had all of the area, and the rest none.
        const bool hopeless = nodeCost + std::min(counts.below, counts.above) >= best_.cost;
        if (!separates(counts, all, dividing_) || hopeless || !(area_ > 0.0)) return;
        const std::array<double, 2> areas = piece_.cell.areas(plane);
        if (areas[0] == 0.0 || areas[1] == 0.0) return;
        const Split split = splitOf(plane, counts, areas, area_);
        if (split.cost < best_.cost) best_ = split;
    }

    std::optional<Split> best() const { return best_.cost < unlimited ? std::optional(best_) : std::nullopt; }

private:
    static constexpr double unlimited = std::numeric_limits<double>::infinity();

    const Piece& piece_;
    double tolerance_;
    bool dividing_;
    double area_;
    Split best_{{}, false, unlimited};
};

void considerPlanesOf(const Corners& corners, Chooser& chooser) {
    const dvec3 normal = glm::cross(corners[1] - corners[0], corners[2] - corners[0]);
    const double length = glm::length(normal);
    if (!(length > 0.0)) return;
    if (const auto plane = Plane::across(normal, corners)) chooser.consider(*plane);
    for (int i = 0; i < 3; ++i) {
        const std::array<dvec3, 2> edge = {corners[i], corners[(i + 1) % 3]};
        if (const auto plane = Plane::across(glm::cross(edge[1] - edge[0], normal / length), edge)) chooser.consider(*plane);
    }
}

}  // namespace

Sides sidesOf(const Piece& piece, const Part& part, const Plane& plane, double tolerance) {
    const dvec3 normal = plane.normal();
    const double distance = plane.distance;
    double lo = std::numeric_limits<double>::infinity(), hi = -lo;
    for (const dvec3& corner : piece.polygon(part)) {
        const double to = glm::dot(normal, corner) - distance;
        lo = std::min(lo, to);
        hi = std::max(hi, to);
    }
    if (part.radius > 0.0f) {
        lo -= part.radius * glm::length(normal);
        hi += part.radius * glm::length(normal);
    }
    return {lo<-tolerance, hi> tolerance};
}

std::optional<Split> bestSplit(const Piece& piece, std::span<const Corners> triangles, double tolerance, bool dividing) {
    std::array<AxisSearch::Found, 3> found;
    const auto search = [&](int axis) { found[axis] = AxisSearch(piece, axis, tolerance, dividing).best(); };
    if (piece.parts.size() >= parallelSize) {
        parallelFor(3, 1, [&](size_t begin, size_t end) {
            for (size_t axis = begin; axis < end; ++axis) search(static_cast<int>(axis));
        });
    } else {
        for (int axis = 0; axis < 3; ++axis) search(axis);
    }
    Chooser chooser(piece, tolerance, dividing);
    for (int axis = 0; axis < 3; ++axis)
        if (found[axis].cost < std::numeric_limits<double>::infinity())
            chooser.consider(Plane::alongAxis(axis, found[axis].coordinate));
    const size_t stride = (piece.parts.size() + mostSamples - 1) / mostSamples;
    for (size_t i = 0; i < piece.parts.size(); i += stride) considerPlanesOf(triangles[piece.parts[i].triangle], chooser);
    return chooser.best();
}

}  // namespace raig::bsp
