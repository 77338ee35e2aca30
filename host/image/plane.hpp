/// One channel of a picture in double precision, and separable filters of it, for the metrics.
#pragma once

#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <cstdint>
#include <vector>

namespace raig::image {

struct Plane {
    Plane(uint32_t w, uint32_t h) : width(w), height(h), values(size_t{w} * h) {}
    double* row(size_t y) { return values.data() + y * width; }
    const double* row(size_t y) const { return values.data() + y * width; }

    size_t width, height;
    std::vector<double> values;
};

/// An odd number of weights, the middle one for the pixel itself.
using Weights = std::vector<double>;

/// Calls `body(y)` for every row, in parallel.
template <class Body>
void forRows(size_t height, const Body& body) {
    parallelFor(height, 4, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y) body(y);
    });
}

/// The sum of weight i times pixel x + i - radius of the row, the border repeated. Cost O(pixels * weights).
inline Plane filterRows(const Plane& in, const Weights& weights) {
    RAIG_CHECK(weights.size() % 2 == 1);
    const size_t radius = weights.size() / 2;
    Plane out(static_cast<uint32_t>(in.width), static_cast<uint32_t>(in.height));
    forRows(in.height, [&](size_t y) {
        const double* row = in.row(y);
        std::vector<double> padded(in.width + 2 * radius);
        std::fill_n(padded.begin(), radius, row[0]);
        std::copy_n(row, in.width, padded.begin() + static_cast<ptrdiff_t>(radius));
        std::fill_n(padded.end() - static_cast<ptrdiff_t>(radius), radius, row[in.width - 1]);
        double* to = out.row(y);
        for (size_t i = 0; i < weights.size(); ++i)
            for (size_t x = 0; x < in.width; ++x) to[x] += weights[i] * padded[x + i];
    });
    return out;
}

/// As filterRows, along columns.
inline Plane filterColumns(const Plane& in, const Weights& weights) {
    RAIG_CHECK(weights.size() % 2 == 1);
    const auto radius = static_cast<int64_t>(weights.size() / 2);
    Plane out(static_cast<uint32_t>(in.width), static_cast<uint32_t>(in.height));
    forRows(in.height, [&](size_t y) {
        double* to = out.row(y);
        for (size_t i = 0; i < weights.size(); ++i) {
            const int64_t from = static_cast<int64_t>(y) + static_cast<int64_t>(i) - radius;
            const double* row =
                in.row(static_cast<size_t>(std::clamp<int64_t>(from, 0, static_cast<int64_t>(in.height) - 1)));
            for (size_t x = 0; x < in.width; ++x) to[x] += weights[i] * row[x];
        }
    });
    return out;
}

}  // namespace raig::image
