/// FLIP in double precision [Andersson, Nilsson, Akenine-Moeller, Oskarsson, Astrom, Fairchild 2020, "FLIP: A Difference
/// Evaluator for Alternating Images"]. Section and symbol names are the paper's. All its filters are sums of products of
/// one-dimensional ones, and are run as such.
#include "image/pairs.hpp"
#include "image/plane.hpp"

#include <array>
#include <cmath>
#include <numbers>

namespace raig::image {

namespace {

using glm::dmat3;

constexpr double pi = std::numbers::pi;

/// sRGB's linear primaries to XYZ, each divided by its value for white: (1, 1, 1) maps to (1, 1, 1). Rows of the matrix in
/// the paper, whose fractions follow from sRGB's chromaticities.
const dmat3& toRelativeXyz() {
    static const dmat3 matrix = [] {
        dmat3 rows(10135552.0 / 24577794, 8788810.0 / 24577794, 4435075.0 / 24577794,  //
                   2613072.0 / 12288897, 8788810.0 / 12288897, 887015.0 / 12288897,    //
                   1425312.0 / 73733382, 8788810.0 / 73733382, 70074185.0 / 73733382);
        for (int i = 0; i < 3; ++i) rows[i] /= rows[i].x + rows[i].y + rows[i].z;
        return glm::transpose(rows);
    }();
    return matrix;
}

/// The opponent space YCxCz, less its scales, which cancel: (Y, X - Y, Y - Z) of relative XYZ.
struct Opponent {
    Plane y, cx, cz;
};

Opponent toOpponent(const Image& image) {
    Opponent out{{image.width, image.height}, {image.width, image.height}, {image.width, image.height}};
    forRows(image.height, [&](size_t row) {
        for (size_t i = row * image.width; i < (row + 1) * image.width; ++i) {
            const dvec3 xyz = toRelativeXyz() * glm::clamp(dvec3(image.pixels[i]), 0.0, 1.0);
            out.y.values[i] = xyz.y;
            out.cx.values[i] = xyz.x - xyz.y;
            out.cz.values[i] = xyz.y - xyz.z;
        }
    });
    return out;
}

/// One Gaussian of a contrast sensitivity function: a sqrt(pi / b) exp(-pi^2 (x^2 + y^2) / b), x and y in degrees.
struct Gaussian {
    double a, b;
};

Weights sample(double b, int radius, double pixelsPerDegree) {
    Weights weights;
    for (int i = -radius; i <= radius; ++i) {
        const double x = i / pixelsPerDegree;
        weights.push_back(std::exp(-pi * pi * x * x / b));
    }
    return weights;
}

double sum(const Weights& weights) {
    double total = 0.0;
    for (const double w : weights) total += w;
    return total;
}

/// Filters by the sum of the Gaussians, normalised to 1 as a whole.
Plane filterBySensitivity(const Plane& in, std::initializer_list<Gaussian> gaussians, int radius, double pixelsPerDegree) {
    double whole = 0.0;
    for (const auto& [a, b] : gaussians) {
        const double side = sum(sample(b, radius, pixelsPerDegree));
        whole += a * std::sqrt(pi / b) * side * side;
    }
    Plane out(static_cast<uint32_t>(in.width), static_cast<uint32_t>(in.height));
    for (const auto& [a, b] : gaussians) {
        const Weights weights = sample(b, radius, pixelsPerDegree);
        Weights scaled = weights;
        for (double& w : scaled) w *= a * std::sqrt(pi / b) / whole;
        const Plane part = filterColumns(filterRows(in, weights), scaled);
        for (size_t i = 0; i < out.values.size(); ++i) out.values[i] += part.values[i];
    }
    return out;
}

/// Section 4.1.1: what is left of the picture's colours at that distance.
Opponent filterSpatially(const Opponent& in, double pixelsPerDegree) {
    constexpr double largestB = 0.04;  // of the blue-yellow function; all filters are made as wide as its
    const int radius = static_cast<int>(std::ceil(3.0 * std::sqrt(largestB / (2.0 * pi * pi)) * pixelsPerDegree));
    return {filterBySensitivity(in.y, {{1.0, 0.0047}}, radius, pixelsPerDegree),
            filterBySensitivity(in.cx, {{1.0, 0.0053}}, radius, pixelsPerDegree),
            filterBySensitivity(in.cz, {{34.1, largestB}, {13.5, 0.025}}, radius, pixelsPerDegree)};
}

/// CIE L*a*b* of relative XYZ, with a* and b* scaled by L* (Hunt: colours in the dark are less colourful).
dvec3 toHuntLab(const dvec3& xyz) {
    constexpr double delta = 6.0 / 29.0;
    const auto f = [](double t) {
        return t > delta * delta * delta ? std::cbrt(t) : t / (3.0 * delta * delta) + 4.0 / 29.0;
    };
    const dvec3 v(f(xyz.x), f(xyz.y), f(xyz.z));
    const double lightness = 116.0 * v.y - 16.0;
    return {lightness, 0.01 * lightness * 500.0 * (v.x - v.y), 0.01 * lightness * 200.0 * (v.y - v.z)};
}

/// Section 4.1.2 and 4.1.3: the HyAB distance, to the power of 0.7.
double colourDistance(const dvec3& p, const dvec3& q) {
    const dvec3 d = p - q;
    return std::pow(std::abs(d.x) + std::sqrt(d.y * d.y + d.z * d.z), 0.7);
}

/// The colours that the eye gets of the filtered picture, clamped to what a screen shows.
dvec3 seenColour(const Opponent& filtered, size_t i) {
    static const dmat3 toRgb = glm::inverse(toRelativeXyz());
    const double y = filtered.y.values[i];
    const dvec3 rgb = toRgb * dvec3(y + filtered.cx.values[i], y, y - filtered.cz.values[i]);
    return toHuntLab(toRelativeXyz() * glm::clamp(rgb, 0.0, 1.0));
}

/// Section 4.1.3: distances up to 0.4 of the largest take up [0, 0.95], the rest what is left.
double redistribute(double distance) {
    static const double largest =
        colourDistance(toHuntLab(toRelativeXyz()[1]), toHuntLab(toRelativeXyz()[2]));  // green, blue
    constexpr double pt = 0.95;
    const double knee = 0.4 * largest;
    return distance < knee ? pt / knee * distance : pt + (distance - knee) / (largest - knee) * (1.0 - pt);
}

/// Scales the positive weights to a sum of 1 and the negative ones to -1.
void normaliseSigns(Weights& weights) {
    double positive = 0.0, negative = 0.0;
    for (const double w : weights) (w > 0.0 ? positive : negative) += std::abs(w);
    for (double& w : weights) w /= w > 0.0 ? positive : negative;
}

/// Section 4.2: how strongly each pixel is part of an edge, and a point or line.
struct Features {
    Plane edge, point;
};

Features findFeatures(const Plane& luminance, double pixelsPerDegree) {
    const double deviation = 0.5 * 0.082 * pixelsPerDegree;
    const int radius = static_cast<int>(std::ceil(3.0 * deviation));
    Weights smooth, first, second;  // a Gaussian and its derivatives
    for (int i = -radius; i <= radius; ++i) {
        const double x = i / deviation, g = std::exp(-0.5 * x * x);
        smooth.push_back(g);
        first.push_back(-x * g);
        second.push_back((x * x - 1.0) * g);
    }
    const double total = sum(smooth);
    for (double& w : smooth) w /= total;
    normaliseSigns(first);
    normaliseSigns(second);

    const Plane smoothed = filterRows(luminance, smooth);
    const auto length = [](Plane a, const Plane& b) {
        for (size_t i = 0; i < a.values.size(); ++i)
            a.values[i] = std::sqrt(a.values[i] * a.values[i] + b.values[i] * b.values[i]);
        return a;
    };
    return {length(filterColumns(filterRows(luminance, first), smooth), filterColumns(smoothed, first)),
            length(filterColumns(filterRows(luminance, second), smooth), filterColumns(smoothed, second))};
}

}  // namespace

std::vector<double> flip(const Pair& pair, double pixelsPerDegree) {
    RAIG_CHECK(pixelsPerDegree > 0.0);
    const Opponent test = toOpponent(pair.test), reference = toOpponent(pair.reference);
    const Features testFeatures = findFeatures(test.y, pixelsPerDegree);
    const Features referenceFeatures = findFeatures(reference.y, pixelsPerDegree);
    const Opponent testSeen = filterSpatially(test, pixelsPerDegree),
                   referenceSeen = filterSpatially(reference, pixelsPerDegree);

    std::vector<double> values(pair.kept.size());
    forRows(pair.test.height, [&](size_t y) {
        for (size_t i = y * pair.test.width; i < (y + 1) * pair.test.width; ++i) {
            const double colour = redistribute(colourDistance(seenColour(testSeen, i), seenColour(referenceSeen, i)));
            const double edge = std::abs(testFeatures.edge.values[i] - referenceFeatures.edge.values[i]);
            const double point = std::abs(testFeatures.point.values[i] - referenceFeatures.point.values[i]);
            const double feature = std::sqrt(std::min(1.0, std::max(edge, point) / std::numbers::sqrt2));
            values[i] = std::pow(colour, 1.0 - feature);
        }
    });
    return values;
}

}  // namespace raig::image
