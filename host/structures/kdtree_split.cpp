#include "structures/kdtree_split.hpp"

#include "base/parallel.hpp"

#include <algorithm>
#include <array>
#include <vector>

namespace raig::kdtree {

namespace {

constexpr int binCount = 128;
constexpr size_t grain = 8192;
constexpr float inf = std::numeric_limits<float>::infinity();

struct Counts {
    size_t below = 0;  // references, flat ones of the plane not included
    size_t flat = 0;
    size_t above = 0;
};

double halfAreaOf(const dvec3& e) {
    return e.x * e.y + e.y * e.z + e.z * e.x;
}

/// Cost of cutting `cell` along `axis`, for every place of the plane.
class Judge {
public:
    Judge(const Box& cell, int axis, const Costs& costs) : cell_(cell), axis_(axis), costs_(costs) {
        extent_ = dvec3(cell.hi) - dvec3(cell.lo);
        area_ = halfAreaOf(extent_);
    }

    /// Takes the plane over into `best` if it is cheaper.
    void consider(float at, const Counts& counts, Plane& best) const {
        // A cut at the cell's own side can only part flat triangles from the others.
        if (!(at >= cell_.lo[axis_] && at <= cell_.hi[axis_]) || extent_[axis_] <= 0.0) return;
        for (const bool flatsBelow : {true, false}) {
            if (!flatsBelow && counts.flat == 0) break;
            if (at == cell_.lo[axis_] && (counts.flat == 0 || !flatsBelow)) continue;
            if (at == cell_.hi[axis_] && (counts.flat == 0 || flatsBelow)) continue;
            const size_t below = counts.below + (flatsBelow ? counts.flat : 0);
            const size_t above = counts.above + (flatsBelow ? 0 : counts.flat);
            const double cost = costOf(at, below, above);
            if (cost < best.cost) best = {axis_, at, flatsBelow, cost};
        }
    }

private:
    double costOf(float at, size_t below, size_t above) const {
        dvec3 low = extent_, high = extent_;
        low[axis_] = double{at} - cell_.lo[axis_];
        high[axis_] = cell_.hi[axis_] - double{at};
        const double tests =
            (halfAreaOf(low) * static_cast<double>(below) + halfAreaOf(high) * static_cast<double>(above)) / area_;
        const double cost = 1.0 + costs_.triangle * tests;
        return below == 0 || above == 0 ? cost * costs_.emptyBonus : cost;
    }

    const Box& cell_;
    int axis_;
    const Costs& costs_;
    dvec3 extent_;
    double area_;
};

/// The ends of the references' boxes along an axis, sorted; those of flat ones apart.
struct Ends {
    std::vector<float> low, high, flat;

    Ends(std::span<const BoxReference> references, int axis) {
        low.reserve(references.size());
        high.reserve(references.size());
        for (const BoxReference& r : references) {
            if (r.lo[axis] == r.hi[axis]) {
                flat.push_back(r.lo[axis]);
            } else {
                low.push_back(r.lo[axis]);
                high.push_back(r.hi[axis]);
            }
        }
        std::sort(low.begin(), low.end());
        std::sort(high.begin(), high.end());
        std::sort(flat.begin(), flat.end());
    }
};

void sweep(const Ends& ends, const Judge& judge, Plane& best) {
    size_t begun = 0, ended = 0, flats = 0;  // how many lie before the plane
    const auto next = [](const std::vector<float>& v, size_t i) { return i < v.size() ? v[i] : inf; };
    for (;;) {
        const float at = std::min({next(ends.low, begun), next(ends.high, ended), next(ends.flat, flats)});
        if (at == inf) return;
        size_t flatHere = 0;
        while (next(ends.high, ended) == at) ++ended;
        while (next(ends.flat, flats + flatHere) == at) ++flatHere;
        const Counts counts{begun + flats, flatHere, ends.low.size() - ended + ends.flat.size() - flats - flatHere};
        judge.consider(at, counts, best);
        flats += flatHere;
        while (next(ends.low, begun) == at) ++begun;
    }
}

/// How many boxes begin and end between two equidistant planes, and the outermost of their ends there.
struct Bin {
    size_t begin = 0, end = 0;
    float first = inf, last = -inf;
};

struct Bins {
    std::array<std::array<Bin, binCount>, 3> axes;

    void merge(const Bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int i = 0; i < binCount; ++i) {
                Bin& bin = axes[axis][i];
                const Bin& more = other.axes[axis][i];
                bin.begin += more.begin;
                bin.end += more.end;
                bin.first = std::min(bin.first, more.first);
                bin.last = std::max(bin.last, more.last);
            }
    }
};

Bins binsOf(std::span<const BoxReference> references, const Box& cell) {
    vec3 scale(0.0f);
    const vec3 extent = cell.extent();
    for (int axis = 0; axis < 3; ++axis)
        if (extent[axis] > 0.0f) scale[axis] = std::min(static_cast<float>(binCount) / extent[axis], 1e30f);
    const auto over = [&](size_t begin, size_t end, Bins bins) {
        for (size_t i = begin; i < end; ++i)
            for (int axis = 0; axis < 3; ++axis) {
                const BoxReference& r = references[i];
                const auto binAt = [&](float x) -> Bin& {
                    const float place = (x - cell.lo[axis]) * scale[axis];
                    Bin& bin = bins.axes[axis][place < binCount - 1 ? static_cast<int>(place) : binCount - 1];
                    bin.first = std::min(bin.first, x);
                    bin.last = std::max(bin.last, x);
                    return bin;
                };
                ++binAt(r.lo[axis]).begin;
                ++binAt(r.hi[axis]).end;
            }
        return bins;
    };
    const auto join = [](Bins a, const Bins& b) {
        a.merge(b);
        return a;
    };
    return parallelReduce(references.size(), grain, Bins{}, over, join);
}

Plane binnedPlane(std::span<const BoxReference> references, const Box& cell, const Costs& costs) {
    const Bins bins = binsOf(references, cell);
    Plane best;
    for (int axis = 0; axis < 3; ++axis) {
        const Judge judge(cell, axis, costs);
        const auto& b = bins.axes[axis];
        std::array<float, binCount> firstFrom;
        float first = inf;
        for (int i = binCount - 1; i >= 0; --i) firstFrom[i] = first = std::min(first, b[i].first);
        // Between bins i - 1 and i: the last end below and the first end above are planes as good as any between them.
        size_t begun = 0, ended = 0;
        float last = -inf;
        for (int i = 0; i <= binCount; ++i) {
            const Counts counts{begun, 0, references.size() - ended};
            if (last > -inf) judge.consider(last, counts, best);
            if (i == binCount) break;
            // Flat triangles at the first end above belong above.
            Plane above = best;
            judge.consider(firstFrom[i], counts, above);
            if (above.cost < best.cost) {
                best = above;
                best.flatsBelow = false;
            }
            begun += b[i].begin;
            ended += b[i].end;
            last = std::max(last, b[i].last);
        }
    }
    return best;
}

}  // namespace

Plane cheapestPlane(std::span<const BoxReference> references, const Box& cell, const Costs& costs, size_t exactSize) {
    if (references.size() > exactSize) return binnedPlane(references, cell, costs);
    Plane best;
    for (int axis = 0; axis < 3; ++axis) sweep(Ends(references, axis), Judge(cell, axis, costs), best);
    return best;
}

Plane medianPlane(std::span<const BoxReference> references, const Box& cell) {
    const vec3 extent = cell.extent();
    std::array<int, 3> order = {0, 1, 2};
    std::stable_sort(order.begin(), order.end(), [&](int a, int b) { return extent[a] > extent[b]; });
    std::vector<float> centres(references.size());
    for (const int axis : order) {
        std::transform(references.begin(), references.end(), centres.begin(),
                       [axis](const BoxReference& r) { return 0.5f * r.lo[axis] + 0.5f * r.hi[axis]; });
        const auto middle = centres.begin() + static_cast<long>(centres.size() / 2);
        std::nth_element(centres.begin(), middle, centres.end());
        Plane plane{axis, *middle, false, 0.0};
        if (!(plane.at > cell.lo[axis] && plane.at < cell.hi[axis])) continue;
        const auto count = [&](auto cuts) { return std::count_if(references.begin(), references.end(), cuts); };
        const auto below = count([&](const BoxReference& r) { return plane.cutsBelow(r); });
        const auto above = count([&](const BoxReference& r) { return plane.cutsAbove(r); });
        const auto all = static_cast<long>(references.size());
        if (below < all && above < all) return plane;
    }
    return {};
}

}  // namespace raig::kdtree
