#include "image/metrics.hpp"

#include "base/error.hpp"
#include "image/pairs.hpp"
#include "image/plane.hpp"
#include "image/srgb.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

namespace raig {

namespace image {

Pair prepare(const Image& test, const Image& reference, PixelMask leaveOut) {
    if (test.width != reference.width || test.height != reference.height)
        throw inputError("the pictures", "differ in size, {} x {} and {} x {}: only pictures of one size can be compared",
                         test.width, test.height, reference.width, reference.height);
    RAIG_CHECK_OP(test.pixels.size(), ==, size_t{test.width} * test.height);
    RAIG_CHECK_OP(reference.pixels.size(), ==, test.pixels.size());
    RAIG_CHECK(leaveOut.empty() || leaveOut.size() == test.pixels.size());
    Pair pair{test, reference, std::vector<uint8_t>(test.pixels.size(), 1), 0};
    for (size_t i = 0; i < pair.kept.size(); ++i) {
        vec3 &a = pair.test.pixels[i], &b = pair.reference.pixels[i];
        const bool finite = isFinite(a) && isFinite(b);
        if (!finite) ++pair.nan;
        if (finite && (leaveOut.empty() || leaveOut[i] == 0)) continue;
        pair.kept[i] = 0;
        a = b = isFinite(b) ? b : isFinite(a) ? a : vec3(0.0f);
    }
    return pair;
}

namespace {

dvec3 encoded(const vec3& c) {
    const dvec3 clamped = glm::clamp(dvec3(c), 0.0, 1.0);
    return {srgb::toEncoded(clamped.x), srgb::toEncoded(clamped.y), srgb::toEncoded(clamped.z)};
}

/// What adds up over a picture, of one row or of all.
struct Sums {
    uint64_t pixels = 0;
    double max = 0.0, squares = 0.0, relativeSquares = 0.0, encodedSquares = 0.0;
};

Sums addRow(const Pair& pair, size_t y) {
    constexpr double epsilon = 1e-2;  // keeps what is nearly black from deciding relmse
    Sums sums;
    for (size_t i = y * pair.test.width; i < (y + 1) * pair.test.width; ++i) {
        if (!pair.kept[i]) continue;
        ++sums.pixels;
        const dvec3 a(pair.test.pixels[i]), b(pair.reference.pixels[i]);
        const dvec3 d = a - b, codes = encoded(pair.test.pixels[i]) - encoded(pair.reference.pixels[i]);
        for (int k = 0; k < 3; ++k) {
            sums.max = std::max(sums.max, std::abs(d[k]));
            sums.squares += d[k] * d[k];
            sums.relativeSquares += d[k] * d[k] / (b[k] * b[k] + epsilon);
            sums.encodedSquares += codes[k] * codes[k];
        }
    }
    return sums;
}

void comparePixels(const Pair& pair, PictureDifference& result) {
    std::vector<Sums> rows(pair.test.height);
    forRows(rows.size(), [&](size_t y) { rows[y] = addRow(pair, y); });
    Sums all;
    for (const Sums& row : rows) {
        all.pixels += row.pixels;
        all.max = std::max(all.max, row.max);
        all.squares += row.squares;
        all.relativeSquares += row.relativeSquares;
        all.encodedSquares += row.encodedSquares;
    }
    const double channels = std::max(1.0, 3.0 * static_cast<double>(all.pixels));
    result.pixels = all.pixels;
    result.nan = pair.nan;
    result.max = all.max;
    result.rmse = std::sqrt(all.squares / channels);
    result.relmse = all.relativeSquares / channels;
    result.psnr = 10.0 * std::log10(channels / all.encodedSquares);  // infinite if they are equal
}

Plane lumaOf(const Image& image) {
    Plane luma(image.width, image.height);
    forRows(image.height, [&](size_t y) {
        for (size_t i = y * image.width; i < (y + 1) * image.width; ++i) {
            const dvec3 c = encoded(image.pixels[i]);
            luma.values[i] = srgb::redWeight * c.x + srgb::greenWeight * c.y + srgb::blueWeight * c.z;
        }
    });
    return luma;
}

Plane product(const Plane& a, const Plane& b) {
    Plane result = a;
    for (size_t i = 0; i < result.values.size(); ++i) result.values[i] *= b.values[i];
    return result;
}

/// Mean structural similarity over the windows centred on pixels that are kept.
double similarity(const Pair& pair) {
    constexpr int radius = 5;
    constexpr double deviation = 1.5, c1 = 0.01 * 0.01, c2 = 0.03 * 0.03;
    Weights window;
    for (int i = -radius; i <= radius; ++i) window.push_back(std::exp(-0.5 * i * i / (deviation * deviation)));
    double total = 0.0;
    for (const double w : window) total += w;
    for (double& w : window) w /= total;
    const auto blur = [&](const Plane& plane) { return filterColumns(filterRows(plane, window), window); };

    const Plane a = lumaOf(pair.test), b = lumaOf(pair.reference);
    const Plane meanA = blur(a), meanB = blur(b), squaresA = blur(product(a, a)), squaresB = blur(product(b, b)),
                both = blur(product(a, b));
    const size_t marginX = a.width > 2 * radius ? radius : 0, marginY = a.height > 2 * radius ? radius : 0;
    double sum = 0.0;
    uint64_t count = 0;
    for (size_t y = marginY; y + marginY < a.height; ++y)
        for (size_t x = marginX; x + marginX < a.width; ++x) {
            const size_t i = y * a.width + x;
            if (!pair.kept[i]) continue;
            const double ma = meanA.values[i], mb = meanB.values[i];
            const double varianceA = squaresA.values[i] - ma * ma, varianceB = squaresB.values[i] - mb * mb;
            const double covariance = both.values[i] - ma * mb;
            sum +=
                (2.0 * ma * mb + c1) * (2.0 * covariance + c2) / ((ma * ma + mb * mb + c1) * (varianceA + varianceB + c2));
            ++count;
        }
    return count == 0 ? 1.0 : sum / static_cast<double>(count);
}

void compareByEye(const Pair& pair, double pixelsPerDegree, PictureDifference& result) {
    const std::vector<double> values = flip(pair, pixelsPerDegree);
    std::vector<double> kept;
    for (size_t i = 0; i < values.size(); ++i)
        if (pair.kept[i]) kept.push_back(values[i]);
    if (kept.empty()) return;
    double sum = 0.0;
    for (const double value : kept) sum += value;
    result.flipMean = sum / static_cast<double>(kept.size());
    result.flipMax = *std::max_element(kept.begin(), kept.end());
    const size_t rank = (kept.size() * 99 + 99) / 100 - 1;  // nearest rank: the least value that 99 % do not exceed
    std::nth_element(kept.begin(), kept.begin() + static_cast<ptrdiff_t>(rank), kept.end());
    result.flipP99 = kept[rank];
}

}  // namespace

}  // namespace image

PictureDifference comparePictures(const Image& test, const Image& reference, PixelMask leaveOut, double pixelsPerDegree) {
    const image::Pair pair = image::prepare(test, reference, leaveOut);
    PictureDifference result;
    image::comparePixels(pair, result);
    if (result.pixels == 0) return result;
    result.ssim = image::similarity(pair);
    image::compareByEye(pair, pixelsPerDegree, result);
    return result;
}

std::vector<double> flipValues(const Image& test, const Image& reference, PixelMask leaveOut, double pixelsPerDegree) {
    const image::Pair pair = image::prepare(test, reference, leaveOut);
    if (pair.kept.empty()) return {};
    std::vector<double> values = image::flip(pair, pixelsPerDegree);
    for (size_t i = 0; i < values.size(); ++i)
        if (!pair.kept[i]) values[i] = std::numeric_limits<double>::quiet_NaN();
    return values;
}

std::vector<double> absoluteDifference(const Image& test, const Image& reference, PixelMask leaveOut) {
    const image::Pair pair = image::prepare(test, reference, leaveOut);
    std::vector<double> values(pair.kept.size());
    for (size_t i = 0; i < values.size(); ++i) {
        const dvec3 d = glm::abs(dvec3(pair.test.pixels[i]) - dvec3(pair.reference.pixels[i]));
        values[i] = pair.kept[i] ? std::max({d.x, d.y, d.z}) : std::numeric_limits<double>::quiet_NaN();
    }
    return values;
}

vec3 magma(double value) {
    if (std::isnan(value)) return {0.0f, 1.0f, 0.0f};
    // sRGB bytes of the map at 0, 0.1 ... 1.
    static constexpr std::array<std::array<uint8_t, 3>, 11> stops = {{{0, 0, 4},
                                                                      {20, 14, 54},
                                                                      {59, 15, 112},
                                                                      {100, 26, 128},
                                                                      {140, 41, 129},
                                                                      {183, 55, 121},
                                                                      {222, 73, 104},
                                                                      {247, 112, 92},
                                                                      {254, 159, 109},
                                                                      {254, 207, 146},
                                                                      {252, 253, 191}}};
    const double place = std::clamp(value, 0.0, 1.0) * (stops.size() - 1);
    const size_t below = std::min(static_cast<size_t>(place), stops.size() - 2);
    const double part = place - static_cast<double>(below);
    vec3 colour;
    for (int k = 0; k < 3; ++k)
        colour[k] =
            static_cast<float>(srgb::toLinear(((1.0 - part) * stops[below][k] + part * stops[below + 1][k]) / 255.0));
    return colour;
}

Image falseColour(std::span<const double> values, uint32_t width, uint32_t height, double top) {
    RAIG_CHECK_OP(values.size(), ==, size_t{width} * height);
    RAIG_CHECK(top > 0.0);
    Image image(width, height);
    for (size_t i = 0; i < values.size(); ++i) image.pixels[i] = magma(values[i] / top);
    return image;
}

}  // namespace raig
