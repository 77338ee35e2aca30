/// Repeatable random numbers: the same on every machine and compiler.
#pragma once

#include "base/vectors.hpp"

#include <cmath>
#include <cstdint>

namespace raig {

/// SplitMix64 [Steele, Lea, Flood 2014, "Fast Splittable Pseudorandom Number Generators"].
class Random {
public:
    explicit Random(uint64_t seed) : state_(seed) {}

    uint64_t bits() {
        uint64_t z = (state_ += 0x9e3779b97f4a7c15);
        z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9;
        z = (z ^ (z >> 27)) * 0x94d049bb133111eb;
        return z ^ (z >> 31);
    }
    uint32_t below(uint32_t end) { return static_cast<uint32_t>((bits() >> 32) * end >> 32); }
    /// Uniform in [0, 1), and in [lo, hi).
    double unit() { return static_cast<double>(bits() >> 11) * 0x1p-53; }
    double within(double lo, double hi) { return lo + (hi - lo) * unit(); }
    vec3 inCube(double lo, double hi) { return vec3(dvec3(within(lo, hi), within(lo, hi), within(lo, hi))); }
    dvec3 direction() {
        for (;;) {
            const dvec3 v(within(-1, 1), within(-1, 1), within(-1, 1));
            const double square = glm::dot(v, v);
            if (square > 1e-4 && square <= 1.0) return v / std::sqrt(square);
        }
    }

private:
    uint64_t state_;
};

}  // namespace raig
