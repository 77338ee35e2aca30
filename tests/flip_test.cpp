// FLIP against closed forms, and against a second, direct writing-out of the paper's definition.
#include "image/metrics.hpp"
#include "support/images.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>

namespace raig {
namespace {

using test::noise;

// ---- A second FLIP: two-dimensional filters written out, CIE units, no cleverness --------------------------------------

using Vec = std::array<double, 3>;
using Kernel = std::function<double(int, int)>;

struct DirectFlip {
    double ppd;
    const double pi = std::acos(-1.0);

    static Vec xyz(const Vec& c) {
        // From the chromaticities (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) of sRGB and the paper's white point, which is
        // (0.31271, 0.32902) in as many digits as matter.
        return {0.4123865632529919 * c[0] + 0.35759149092062537 * c[1] + 0.18045049120356363 * c[2],
                0.21263682167732395 * c[0] + 0.7151829818412507 * c[1] + 0.07218019648142546 * c[2],
                0.019330620152483977 * c[0] + 0.11919716364020842 * c[1] + 0.9503725870054353 * c[2]};
    }
    static Vec rgb(const Vec& c) {
        return {3.2410032329763574 * c[0] - 1.5373989694887849 * c[1] - 0.49861588199636275 * c[2],
                -0.9692242522025164 * c[0] + 1.8759299836951757 * c[1] + 0.04155422634008475 * c[2],
                0.055639419851975465 * c[0] - 0.20401120612390994 * c[1] + 1.0571489771875335 * c[2]};
    }
    static Vec white() { return xyz({1, 1, 1}); }
    static Vec opponent(const Vec& c) {
        const Vec v = xyz(c), w = white();
        return {116 * v[1] / w[1] - 16, 500 * (v[0] / w[0] - v[1] / w[1]), 200 * (v[1] / w[1] - v[2] / w[2])};
    }
    static Vec huntLab(const Vec& c) {
        const Vec v = xyz(c), w = white();
        const auto f = [](double t) { return t > 216.0 / 24389 ? std::cbrt(t) : (24389.0 / 27 * t + 16) / 116; };
        const double x = f(v[0] / w[0]), y = f(v[1] / w[1]), z = f(v[2] / w[2]), l = 116 * y - 16;
        return {l, 0.01 * l * 500 * (x - y), 0.01 * l * 200 * (y - z)};
    }
    static double hyab(const Vec& p, const Vec& q) { return std::abs(p[0] - q[0]) + std::hypot(p[1] - q[1], p[2] - q[2]); }

    static double apply(const Image& image, int channel, int px, int py, int radius, const Kernel& kernel) {
        double sum = 0;
        for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) {
                const int x = std::clamp(px + i, 0, static_cast<int>(image.width) - 1);
                const int y = std::clamp(py + j, 0, static_cast<int>(image.height) - 1);
                const vec3& c = image.at(static_cast<uint32_t>(x), static_cast<uint32_t>(y));
                sum += kernel(i, j) * opponent({c.x, c.y, c.z})[static_cast<size_t>(channel)];
            }
        return sum;
    }
    /// `kernel` scaled so that its positive weights sum to 1 and its negative ones to -1.
    static Kernel normalised(const Kernel& kernel, int radius) {
        double positive = 0, negative = 0;
        for (int j = -radius; j <= radius; ++j)
            for (int i = -radius; i <= radius; ++i) (kernel(i, j) > 0 ? positive : negative) += std::abs(kernel(i, j));
        return [=](int i, int j) { return kernel(i, j) / (kernel(i, j) > 0 ? positive : negative); };
    }
    Vec seen(const Image& image, int x, int y) const {
        const int radius = static_cast<int>(std::ceil(3 * std::sqrt(0.04 / (2 * pi * pi)) * ppd));
        const double a1[] = {1, 1, 34.1}, b1[] = {0.0047, 0.0053, 0.04}, a2[] = {0, 0, 13.5}, b2[] = {1e-5, 1e-5, 0.025};
        Vec filtered;
        for (int k = 0; k < 3; ++k) {
            const Kernel csf = [&](int i, int j) {
                const double d = (i * i + j * j) / (ppd * ppd);
                return a1[k] * std::sqrt(pi / b1[k]) * std::exp(-pi * pi * d / b1[k]) +
                       a2[k] * std::sqrt(pi / b2[k]) * std::exp(-pi * pi * d / b2[k]);
            };
            filtered[static_cast<size_t>(k)] = apply(image, k, x, y, radius, normalised(csf, radius));
        }
        const double fy = (filtered[0] + 16) / 116;
        const Vec w = white();
        Vec c = rgb({w[0] * (fy + filtered[1] / 500), w[1] * fy, w[2] * (fy - filtered[2] / 200)});
        for (double& v : c) v = std::clamp(v, 0.0, 1.0);
        return huntLab(c);
    }
    double feature(const Image& image, int x, int y, bool point) const {
        const double sd = 0.5 * 0.082 * ppd;
        const int radius = static_cast<int>(std::ceil(3 * sd));
        const Kernel across = normalised(
            [&](int i, int j) { return (point ? i * i / (sd * sd) - 1 : -i) * std::exp(-(i * i + j * j) / (2 * sd * sd)); },
            radius);
        // The offset 16 of Y cancels, as the weights sum to 0.
        return std::hypot(apply(image, 0, x, y, radius, across),
                          apply(image, 0, x, y, radius, [&](int i, int j) { return across(j, i); })) /
               116;
    }
    static double redistributed(double hyabDistance) {
        const double most = std::pow(hyab(huntLab({0, 1, 0}), huntLab({0, 0, 1})), 0.7), e = std::pow(hyabDistance, 0.7);
        return e < 0.4 * most ? 0.95 * e / (0.4 * most) : 0.95 + 0.05 * (e - 0.4 * most) / (0.6 * most);
    }
    double at(const Image& a, const Image& b, int x, int y) const {
        const double colour = redistributed(hyab(seen(a, x, y), seen(b, x, y)));
        const double edge = std::abs(feature(a, x, y, false) - feature(b, x, y, false));
        const double point = std::abs(feature(a, x, y, true) - feature(b, x, y, true));
        return std::pow(colour, 1 - std::sqrt(std::max(edge, point) / std::sqrt(2.0)));
    }
};

// ---- What it gives -----------------------------------------------------------------------------------------------------

TEST(Flip, OfWhiteAgainstBlackIsItsColourTermAlone) {
    // L* differs by 100, a* and b* by 0: 100^0.7 = 25.1189, beyond the knee at 0.4 of 41.2760 (green against blue, by hand).
    const double want = 0.95 + 0.05 * (std::pow(100.0, 0.7) - 0.4 * 41.2760) / (0.6 * 41.2760);
    const PictureDifference d = comparePictures(Image(40, 40), Image(40, 40, vec3(1.0f)));
    EXPECT_NEAR(d.flipMean, want, 1e-5);
    EXPECT_NEAR(d.flipMax, want, 1e-5);
    EXPECT_NEAR(d.flipP99, want, 1e-5);
}

TEST(Flip, OfGreenAgainstBlueIsOne) {
    const PictureDifference d = comparePictures(Image(9, 9, vec3(0, 1, 0)), Image(9, 9, vec3(0, 0, 1)));
    EXPECT_NEAR(d.flipMean, 1.0, 1e-6);
    EXPECT_LE(d.flipMax, 1.0 + 1e-12);
}

TEST(Flip, OfDarkGreysIsLinear) {
    // Y = 0.001 is below CIE's linear limit: L* = 903.296 Y.
    const double lightness = 24389.0 / 27 * 0.001, want = 0.95 * std::pow(lightness, 0.7) / (0.4 * 41.2760);
    EXPECT_NEAR(comparePictures(Image(30, 30), Image(30, 30, vec3(0.001f))).flipMean, want, 1e-6);
}

// Agreement to 1e-4 is what two right programs in float have; in double there is no excuse for so much.
TEST(Flip, IsThePapersDefinitionWrittenOut) {
    Image a = noise(26, 17, 14), b = noise(26, 17, 15);
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        if (i % 3) b.pixels[i] = a.pixels[i];                                 // sparse differences
        if (i % 26 > 16) a.pixels[i] = b.pixels[i] = vec3(0.2f, 0.4f, 0.1f);  // and flat ground to see them spread on
    }
    b.at(22, 9) = {1.0f, 1.0f, 1.0f};
    for (const double ppd : {defaultPixelsPerDegree, 30.0, 15.0}) {
        const DirectFlip direct{ppd};
        const std::vector<double> values = flipValues(a, b, {}, ppd);
        for (const auto& [x, y] : {std::pair{0, 0}, {25, 16}, {13, 8}, {22, 9}, {20, 9}, {22, 4}, {25, 0}, {5, 15}})
            EXPECT_NEAR(values[static_cast<size_t>(y * 26 + x)], direct.at(a, b, x, y), 1e-7)
                << x << ',' << y << " at " << ppd;
    }
}

// Shapes that FLIP is made for: an edge that moves, a line that comes and goes, a gradient in another hue.
TEST(Flip, MeansAreThoseOfTheDefinition) {
    Image a(16, 12, vec3(0.3f)), b = a;
    for (uint32_t y = 0; y < 12; ++y)
        for (uint32_t x = 0; x < 16; ++x) {
            if (x < 5) a.at(x, y) = vec3(0.9f, 0.8f, 0.1f);
            if (x < 6) b.at(x, y) = vec3(0.9f, 0.8f, 0.1f);
            if (x == 10) b.at(x, y) = vec3(0.02f);
            if (y > 8) a.at(x, y) = vec3(0.06f * static_cast<float>(x), 0.2f, 0.4f);
            if (y > 8) b.at(x, y) = vec3(0.06f * static_cast<float>(x), 0.25f, 0.3f);
        }
    const DirectFlip direct{defaultPixelsPerDegree};
    double sum = 0.0, most = 0.0;
    for (int y = 0; y < 12; ++y)
        for (int x = 0; x < 16; ++x) {
            const double value = direct.at(a, b, x, y);
            sum += value;
            most = std::max(most, value);
        }
    const PictureDifference d = comparePictures(a, b);
    EXPECT_NEAR(d.flipMean, sum / 192, 1e-7);
    EXPECT_NEAR(d.flipMax, most, 1e-7);
    EXPECT_GT(d.flipMean, 0.05);
}

TEST(Flip, StaysBetweenNothingAndOneAndIsSymmetric) {
    Image a = noise(24, 24, 18), b = noise(24, 24, 19);
    for (Image* image : {&a, &b})
        for (vec3& c : image->pixels) c = glm::step(vec3(0.5f), c);  // corners of the colour cube
    const std::vector<double> ab = flipValues(a, b), ba = flipValues(b, a);
    for (size_t i = 0; i < ab.size(); ++i) {
        EXPECT_GE(ab[i], 0.0);
        EXPECT_LE(ab[i], 1.0);
        EXPECT_EQ(ab[i], ba[i]);
    }
    EXPECT_GT(*std::max_element(ab.begin(), ab.end()), 0.5);
}

TEST(Flip, IsSeenFromTheUsualPlaceUnlessAskedOtherwise) {
    EXPECT_NEAR(defaultPixelsPerDegree, 67.0206, 1e-4);  // as published
    const Image a = noise(12, 12, 20), b = noise(12, 12, 21);
    EXPECT_EQ(flipValues(a, b), flipValues(a, b, {}, defaultPixelsPerDegree));
    EXPECT_NE(flipValues(a, b), flipValues(a, b, {}, 20.0));
}

TEST(Flip, OfOneDotIsLargestThereAndFadesWithDistance) {
    Image a(61, 61, vec3(0.2f)), b = a;
    b.at(30, 30) = {0.2f, 0.2f, 1.0f};  // blue: its filter is the widest
    const std::vector<double> values = flipValues(a, b);
    const auto at = [&](int x, int y) { return values[static_cast<size_t>(y * 61 + x)]; };
    EXPECT_EQ(std::max_element(values.begin(), values.end()) - values.begin(), 30 * 61 + 30);
    EXPECT_GT(at(30, 30), 0.1);
    // The power 0.7 makes 1e-9 of the 1e-13 by which lightness is rounded differently along rows and columns.
    for (int r = 1; r < 25; ++r) {
        EXPECT_NEAR(at(30 + r, 30), at(30, 30 - r), 1e-9);
        EXPECT_NEAR(at(30 - r, 30), at(30, 30 + r), 1e-9);
    }
    for (int r = 2; r <= 10; ++r) EXPECT_LT(at(30 + r, 30), at(30 + r - 1, 30));
    EXPECT_EQ(at(30 + 11, 30), 0.0);  // beyond the widest filter, of radius 10
    EXPECT_GT(at(30 + 10, 30), 0.0);
}

TEST(Flip, PercentileIsOfNearestRank) {
    const Image a(1, 1, vec3(0.0f)), b(1, 1, vec3(1.0f));
    EXPECT_EQ(comparePictures(a, b).flipP99, comparePictures(a, b).flipMax);
    const Image p = noise(20, 10, 16), q = noise(20, 10, 17);
    std::vector<double> values = flipValues(p, q);
    std::sort(values.begin(), values.end());
    const PictureDifference d = comparePictures(p, q);
    EXPECT_EQ(d.flipP99, values[197]);  // ceil(0.99 * 200) = 198
    EXPECT_EQ(d.flipMax, values[199]);
}

}  // namespace
}  // namespace raig
