/// Axis-aligned boxes, closed on all sides. An empty box has lo > hi and contains nothing.
#pragma once

#include "base/vectors.hpp"

#include <limits>

namespace raig {

struct Box {
    vec3 lo{std::numeric_limits<float>::infinity()};
    vec3 hi{-std::numeric_limits<float>::infinity()};

    bool empty() const { return !(lo.x <= hi.x && lo.y <= hi.y && lo.z <= hi.z); }
    vec3 extent() const { return hi - lo; }
    vec3 centre() const { return 0.5f * lo + 0.5f * hi; }

    void grow(const vec3& point) {
        lo = glm::min(lo, point);
        hi = glm::max(hi, point);
    }
    void grow(const Box& other) {
        lo = glm::min(lo, other.lo);
        hi = glm::max(hi, other.hi);
    }
    bool contains(const Box& other) const {
        return other.empty() || (glm::all(glm::lessThanEqual(lo, other.lo)) && glm::all(glm::lessThanEqual(other.hi, hi)));
    }
    /// Half the surface area: what the surface area heuristic is proportional to. 0 for an empty box.
    float halfArea() const {
        if (empty()) return 0.0f;
        const vec3 e = extent();
        return e.x * e.y + e.y * e.z + e.z * e.x;
    }
};

}  // namespace raig
