/// Boxes and centroids four lanes at a time: what builders spend their time on.
#pragma once

#include "structures/binary_tree.hpp"

#include <cstddef>
#include <cstring>
#include <limits>

namespace raig {

/// Four floats at once; of a point's, the fourth means nothing.
using Lanes = float __attribute__((vector_size(16)));
using WholeLanes = int __attribute__((vector_size(16)));

inline Lanes least(Lanes a, Lanes b) { return a < b ? a : b; }
inline Lanes greatest(Lanes a, Lanes b) { return a > b ? a : b; }
inline Lanes every(float value) { return Lanes{value, value, value, value}; }

struct LaneBox {
    Lanes lo = every(std::numeric_limits<float>::infinity());
    Lanes hi = every(-std::numeric_limits<float>::infinity());

    void grow(const LaneBox& box) {
        lo = least(lo, box.lo);
        hi = greatest(hi, box.hi);
    }
    void grow(Lanes point) {
        lo = least(lo, point);
        hi = greatest(hi, point);
    }
    /// Requires that it is not empty.
    float halfArea() const {
        const Lanes e = hi - lo;
        return e[0] * e[1] + e[1] * e[2] + e[2] * e[0];
    }
    Box box() const { return {vec3(lo[0], lo[1], lo[2]), vec3(hi[0], hi[1], hi[2])}; }
};

inline LaneBox boxOf(const BoxReference& reference) {
    // The fourth lanes, an id among them, would be denormal numbers, and slow.
    const WholeLanes point = {-1, -1, -1, 0};
    WholeLanes lo, hi;
    std::memcpy(&lo, &reference.lo, sizeof lo);
    std::memcpy(&hi, &reference.hi, sizeof hi);
    return {reinterpret_cast<Lanes>(lo & point), reinterpret_cast<Lanes>(hi & point)};
}
static_assert(sizeof(BoxReference) == 32 && offsetof(BoxReference, hi) == 16, "two times four lanes");

// Twice the centroid: the halving changes nothing, so it is left out.
inline Lanes centroid2(const LaneBox& box) { return box.lo + box.hi; }

struct RangeBounds {
    LaneBox boxes;
    LaneBox centroids;

    void grow(const BoxReference& reference) {
        const LaneBox box = boxOf(reference);
        boxes.grow(box);
        centroids.grow(centroid2(box));
    }
    void grow(const RangeBounds& other) {
        boxes.grow(other.boxes);
        centroids.grow(other.centroids);
    }
};

/// The axis along which the centroids spread most.
inline int widestAxis(const RangeBounds& bounds) {
    const Lanes extent = bounds.centroids.hi - bounds.centroids.lo;
    return extent[0] >= extent[1] && extent[0] >= extent[2] ? 0 : extent[1] >= extent[2] ? 1 : 2;
}

}  // namespace raig
