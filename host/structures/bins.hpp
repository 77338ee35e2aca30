/// Binning of centroids, and the cheapest split between bins by the surface area heuristic.
#pragma once

#include "structures/lanes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace raig {

inline constexpr int mostBins = 16;

/// Which bin a centroid falls into, on all axes at once. NaN-free: an axis without extent has scale 0.
struct Binning {
    Lanes origin;
    Lanes scale{};
    int count;  ///< of bins: few for few references, as each has a cost

    Binning(const LaneBox& centroids, uint32_t references)
        : origin(centroids.lo), count(static_cast<int>(std::min<uint32_t>(mostBins, 4 + references / 4))) {
        const Lanes extent = centroids.hi - centroids.lo;
        for (int axis = 0; axis < 3; ++axis) {
            const float s = static_cast<float>(count) * 0.9999f / extent[axis];
            scale[axis] = extent[axis] > 0.0f && std::isfinite(s) ? s : 0.0f;
        }
    }
    WholeLanes bins(const LaneBox& box) const {
        const Lanes place = (centroid2(box) - origin) * scale;
        const WholeLanes bin = __builtin_convertvector(place, WholeLanes), last = {count - 1, count - 1, count - 1, 0};
        return bin < last ? bin : last;
    }
};

struct Bins {
    struct Bin {
        LaneBox box;
        uint32_t count = 0;
    };
    using Axis = std::array<Bin, mostBins>;
    std::array<Axis, 3> axes;

    void add(const BoxReference& reference, const Binning& binning) {
        const LaneBox box = boxOf(reference);
        const WholeLanes bins = binning.bins(box);
        for (int axis = 0; axis < 3; ++axis) {
            Bin& bin = axes[axis][bins[axis]];
            bin.box.grow(box);
            ++bin.count;
        }
    }
    void add(const Bins& other) {
        for (int axis = 0; axis < 3; ++axis)
            for (int b = 0; b < mostBins; ++b) {
                axes[axis][b].box.grow(other.axes[axis][b].box);
                axes[axis][b].count += other.axes[axis][b].count;
            }
    }
};

/// Between two bins.
struct Split {
    float cost = std::numeric_limits<float>::infinity();  // of the children, area-weighted, not divided by the parent's
    int axis = -1;
    int bin = 0;  // the first of the right side

    bool found() const { return axis >= 0; }
};

/// The cheapest split of centroids between bins; not found if all lie in one.
inline Split bestSplit(const Bins& bins, const Binning& binning, const SahCosts& costs) {
    Split best;
    for (int axis = 0; axis < 3; ++axis) {
        if (binning.scale[axis] == 0.0f) continue;
        const Bins::Axis& b = bins.axes[axis];
        std::array<float, mostBins> rightCost;
        LaneBox box;
        uint32_t count = 0;
        for (int i = binning.count - 1; i > 0; --i) {
            box.grow(b[i].box);
            count += b[i].count;
            rightCost[i] = count == 0 ? -1.0f : box.halfArea() * static_cast<float>(count);
        }
        box = LaneBox{};
        count = 0;
        for (int i = 1; i < binning.count; ++i) {
            box.grow(b[i - 1].box);
            count += b[i - 1].count;
            if (count == 0 || rightCost[i] < 0.0f) continue;
            const float cost = costs.triangle * (box.halfArea() * static_cast<float>(count) + rightCost[i]);
            if (cost < best.cost) best = {cost, axis, i};
        }
    }
    return best;
}

}  // namespace raig
