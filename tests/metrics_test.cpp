// The measures of difference against closed forms, and FLIP against a second, direct writing-out of the paper's definition.
#include "image/metrics.hpp"
#include "base/error.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <limits>
#include <random>

namespace raig {
namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

Image noise(uint32_t width, uint32_t height, unsigned seed) {
    std::mt19937 random(seed);
    Image image(width, height);
    for (vec3& c : image.pixels)
        for (int k = 0; k < 3; ++k) c[k] = static_cast<float>(random() >> 8) / 16777216.0f;
    return image;
}

/// `image` with its pixels moved by `place(x, y)`, which gives where (x, y) comes from.
Image moved(const Image& image, uint32_t width, uint32_t height, const std::function<uvec2(uint32_t, uint32_t)>& place) {
    Image result(width, height);
    for (uint32_t y = 0; y < height; ++y)
        for (uint32_t x = 0; x < width; ++x) {
            const uvec2 from = place(x, y);
            result.at(x, y) = image.at(from.x, from.y);
        }
    return result;
}

// ---- A second FLIP: two-dimensional filters written out, CIE units, no cleverness --------------------------------------

using Vec = std::array<double, 3>;
using Kernel = std::function<double(int, int)>;

struct DirectFlip {
    double ppd;
    const double pi = std::acos(-1.0);

    static Vec xyz(const Vec& c) {
        // From the chromaticities (0.64, 0.33), (0.30, 0.60), (0.15, 0.06) and the white point (0.3127, 0.3290) of sRGB.
        return {0.4123907992659595 * c[0] + 0.35758433938387796 * c[1] + 0.1804807884018343 * c[2],
                0.21263900587151036 * c[0] + 0.7151686787677559 * c[1] + 0.07219231536073371 * c[2],
                0.01933081871559185 * c[0] + 0.11919477979462599 * c[1] + 0.9505321522496606 * c[2]};
    }
    static Vec rgb(const Vec& c) {
        return {3.2409699419045213 * c[0] - 1.5373831775700935 * c[1] - 0.4986107602930033 * c[2],
                -0.9692436362808798 * c[0] + 1.8759675015077206 * c[1] + 0.04155505740717561 * c[2],
                0.05563007969699361 * c[0] - 0.20397695888897657 * c[1] + 1.0569715142428786 * c[2]};
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

// ---- What holds for all of them ----------------------------------------------------------------------------------------

TEST(PictureDifference, OfEqualPicturesIsExactlyNothing) {
    for (const auto& [width, height] : {std::pair{1u, 1u}, std::pair{40u, 3u}, std::pair{30u, 20u}}) {
        const Image image = noise(width, height, 1);
        const PictureDifference d = comparePictures(image, image);
        EXPECT_EQ(d.pixels, uint64_t{width} * height);
        EXPECT_EQ(d.max, 0.0);
        EXPECT_EQ(d.rmse, 0.0);
        EXPECT_EQ(d.relmse, 0.0);
        EXPECT_EQ(d.psnr, std::numeric_limits<double>::infinity());
        EXPECT_EQ(d.ssim, 1.0);
        EXPECT_EQ(d.flipMean, 0.0);
        EXPECT_EQ(d.flipP99, 0.0);
        EXPECT_EQ(d.flipMax, 0.0);
        EXPECT_EQ(d.nan, 0u);
    }
}

TEST(PictureDifference, IsSymmetricButForRelmse) {
    const Image a = noise(31, 23, 2), b = noise(31, 23, 3);
    const PictureDifference ab = comparePictures(a, b), ba = comparePictures(b, a);
    EXPECT_EQ(ab.max, ba.max);
    EXPECT_EQ(ab.rmse, ba.rmse);
    EXPECT_EQ(ab.psnr, ba.psnr);
    EXPECT_EQ(ab.ssim, ba.ssim);
    EXPECT_EQ(ab.flipMean, ba.flipMean);
    EXPECT_EQ(ab.flipMax, ba.flipMax);
    EXPECT_NE(ab.relmse, ba.relmse);
}

TEST(PictureDifference, OfPixelsDoesNotDependOnTheirPlace) {
    const Image a = noise(32, 24, 4), b = noise(32, 24, 5);
    const auto shuffled = [](const Image& image) {
        return moved(image, 32, 24, [](uint32_t x, uint32_t y) {
            const uint32_t i = (y * 32 + x) * 5 % 768;
            return uvec2(i % 32, i / 32);
        });
    };
    const PictureDifference d = comparePictures(a, b), e = comparePictures(shuffled(a), shuffled(b));
    EXPECT_EQ(d.max, e.max);
    EXPECT_NEAR(d.rmse, e.rmse, 1e-13);
    EXPECT_NEAR(d.relmse, e.relmse, 1e-11);
    EXPECT_NEAR(d.psnr, e.psnr, 1e-11);
    EXPECT_GT(std::abs(d.flipMean - e.flipMean), 1e-6);  // FLIP does depend on it
}

TEST(PictureDifference, TurnsAndMirrorsWithThePicture) {
    const Image a = noise(29, 19, 6), b = noise(29, 19, 7);
    const PictureDifference d = comparePictures(a, b);
    const auto mirrored = [](const Image& i) {
        return moved(i, 29, 19, [](uint32_t x, uint32_t y) { return uvec2(28 - x, y); });
    };
    const auto turned = [](const Image& i) { return moved(i, 19, 29, [](uint32_t x, uint32_t y) { return uvec2(y, x); }); };
    for (const PictureDifference& e : {comparePictures(mirrored(a), mirrored(b)), comparePictures(turned(a), turned(b))}) {
        EXPECT_NEAR(d.ssim, e.ssim, 1e-12);
        EXPECT_NEAR(d.flipMean, e.flipMean, 1e-12);
        EXPECT_NEAR(d.flipP99, e.flipP99, 1e-12);
        EXPECT_NEAR(d.flipMax, e.flipMax, 1e-12);
    }
}

TEST(PictureDifference, HasTheSameBitsOnAnyNumberOfThreads) {
    const Image a = noise(120, 90, 8), b = noise(120, 90, 9);
    const PictureDifference many = comparePictures(a, b);
    const tbb::global_control one(tbb::global_control::max_allowed_parallelism, 1);
    const PictureDifference single = comparePictures(a, b);
    EXPECT_EQ(many.rmse, single.rmse);
    EXPECT_EQ(many.relmse, single.relmse);
    EXPECT_EQ(many.psnr, single.psnr);
    EXPECT_EQ(many.ssim, single.ssim);
    EXPECT_EQ(many.flipMean, single.flipMean);
}

TEST(PictureDifference, NeedsEqualSizes) {
    EXPECT_THROW((void)comparePictures(Image(3, 4), Image(4, 3)), Error);
    EXPECT_THROW((void)flipValues(Image(3, 4), Image(3, 5)), Error);
    EXPECT_THROW((void)absoluteDifference(Image(3, 4), Image(2, 4)), Error);
}

TEST(PictureDifference, CountsNonFinitePixelsAndLeavesThemOut) {
    Image a = noise(30, 20, 10), b = a;
    a.at(4, 5).x = nan;
    a.at(6, 7).y = inf;
    b.at(8, 9).z = -inf;
    b.at(4, 5).z = nan;  // not finite in both: one pixel
    const PictureDifference d = comparePictures(a, b);
    EXPECT_EQ(d.nan, 3u);
    EXPECT_EQ(d.pixels, 597u);
    EXPECT_EQ(d.max, 0.0);
    EXPECT_EQ(d.ssim, 1.0);  // their neighbours see no difference either
    EXPECT_EQ(d.flipMax, 0.0);
    EXPECT_TRUE(std::isnan(flipValues(a, b)[7 * 30 + 6]));
    EXPECT_TRUE(std::isnan(absoluteDifference(a, b)[9 * 30 + 8]));
    EXPECT_EQ(absoluteDifference(a, b)[0], 0.0);
}

TEST(PictureDifference, LeavesOutTheMaskAndSaysNothingOfNothing) {
    const Image a = noise(20, 20, 11);
    Image b = a;
    b.at(10, 10) = {5.0f, 0.0f, 0.0f};
    std::vector<uint8_t> mask(400);
    mask[10 * 20 + 10] = 1;
    const PictureDifference d = comparePictures(a, b, mask);
    EXPECT_EQ(d.pixels, 399u);
    EXPECT_EQ(d.nan, 0u);
    EXPECT_EQ(d.max, 0.0);
    EXPECT_EQ(d.flipMax, 0.0);
    EXPECT_GT(comparePictures(a, b).flipMax, 0.1);
    const PictureDifference none = comparePictures(a, b, std::vector<uint8_t>(400, 1));
    EXPECT_EQ(none.pixels, 0u);
    EXPECT_EQ(none.rmse, 0.0);
    EXPECT_EQ(none.ssim, 1.0);
    EXPECT_EQ(none.flipP99, 0.0);
}

// ---- Closed forms ------------------------------------------------------------------------------------------------------

TEST(PictureDifference, RmseRelmseAndMaxFollowTheirFormulas) {
    Image a(4, 1, vec3(0.5f)), b = a;
    b.at(2, 0) = {0.25f, 0.5f, 1.0f};  // differences of 1/4, 0, 1/2 in 1 of 4 pixels
    const PictureDifference d = comparePictures(a, b);
    EXPECT_DOUBLE_EQ(d.max, 0.5);
    EXPECT_DOUBLE_EQ(d.rmse, std::sqrt((0.0625 + 0.25) / 12));
    EXPECT_DOUBLE_EQ(d.relmse, (0.0625 / (0.0625 + 0.01) + 0.25 / 1.01) / 12);
}

TEST(PictureDifference, LightIsComparedUnclamped) {
    const PictureDifference d = comparePictures(Image(3, 3, vec3(100.0f)), Image(3, 3, vec3(40.0f)));
    EXPECT_DOUBLE_EQ(d.rmse, 60.0);
    EXPECT_EQ(d.psnr, std::numeric_limits<double>::infinity());  // both are white on a screen
    EXPECT_EQ(d.flipMax, 0.0);
}

TEST(PictureDifference, PsnrIsOfSrgbValues) {
    EXPECT_NEAR(comparePictures(Image(5, 5, vec3(0.0f)), Image(5, 5, vec3(1.0f))).psnr, 0.0, 1e-12);
    // 0.001 encodes to 0.01292: 20 log10(1 / 0.01292) dB from black.
    EXPECT_NEAR(comparePictures(Image(5, 5, vec3(0.001f)), Image(5, 5)).psnr, 20 * std::log10(1 / 0.01292), 1e-6);
    // Linear 0.2140411 is sRGB 0.5.
    EXPECT_NEAR(comparePictures(Image(5, 5, vec3(0.21404114f)), Image(5, 5)).psnr, 20 * std::log10(2.0), 1e-6);
}

TEST(PictureDifference, SsimOfFlatPicturesIsItsLuminanceTerm) {
    // Without variance: (2 a b + C1) / (a^2 + b^2 + C1), of luma 0.5 and 1.
    const double c1 = 1e-4, want = (2 * 0.5 + c1) / (0.25 + 1 + c1);
    for (const uint32_t size : {1u, 5u, 11u, 30u})
        EXPECT_NEAR(comparePictures(Image(size, size, vec3(0.21404114f)), Image(size, size, vec3(1.0f))).ssim, want, 1e-7)
            << size;
    EXPECT_NEAR(comparePictures(Image(20, 20), Image(20, 20, vec3(1.0f))).ssim, c1 / (1 + c1), 1e-12);
}

TEST(PictureDifference, SsimOfOneWindowFollowsItsFormula) {
    const Image a = noise(11, 11, 12), b = noise(11, 11, 13);
    const auto luma = [](const vec3& c) {
        const auto encode = [](double v) { return v <= 0.0031308 ? 12.92 * v : 1.055 * std::pow(v, 1 / 2.4) - 0.055; };
        return 0.2126 * encode(c.x) + 0.7152 * encode(c.y) + 0.0722 * encode(c.z);
    };
    double whole = 0, ma = 0, mb = 0, va = 0, vb = 0, cov = 0;
    const auto weigh = [&](const auto& use) {
        for (int y = 0; y < 11; ++y)
            for (int x = 0; x < 11; ++x)
                use(std::exp(-((x - 5) * (x - 5) + (y - 5) * (y - 5)) / 4.5), luma(a.at(x, y)), luma(b.at(x, y)));
    };
    weigh([&](double w, double p, double q) {
        whole += w;
        ma += w * p;
        mb += w * q;
    });
    ma /= whole;
    mb /= whole;
    weigh([&](double w, double p, double q) {
        va += w * (p - ma) * (p - ma);
        vb += w * (q - mb) * (q - mb);
        cov += w * (p - ma) * (q - mb);
    });
    const double want =
        (2 * ma * mb + 1e-4) * (2 * cov / whole + 9e-4) / ((ma * ma + mb * mb + 1e-4) * (va / whole + vb / whole + 9e-4));
    EXPECT_NEAR(comparePictures(a, b).ssim, want, 1e-12);
}

// ---- FLIP --------------------------------------------------------------------------------------------------------------

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

TEST(Flip, IsThePapersDefinitionWrittenOut) {
    Image a = noise(26, 17, 14), b = noise(26, 17, 15);
    for (size_t i = 0; i < a.pixels.size(); ++i) {
        if (i % 3) b.pixels[i] = a.pixels[i];                                 // sparse differences
        if (i % 26 > 16) a.pixels[i] = b.pixels[i] = vec3(0.2f, 0.4f, 0.1f);  // and flat ground to see them spread on
    }
    b.at(22, 9) = {1.0f, 1.0f, 1.0f};
    for (const double ppd : {defaultPixelsPerDegree, 30.0}) {
        const DirectFlip direct{ppd};
        const std::vector<double> values = flipValues(a, b, {}, ppd);
        // The two RGB matrices agree to some 2e-5 (the paper's white point is rounded).
        for (const auto& [x, y] : {std::pair{0, 0}, {25, 16}, {13, 8}, {22, 9}, {20, 9}, {22, 4}, {25, 0}, {5, 15}})
            EXPECT_NEAR(values[static_cast<size_t>(y * 26 + x)], direct.at(a, b, x, y), 2e-4)
                << x << ',' << y << " at " << ppd;
    }
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

// ---- The colour map ----------------------------------------------------------------------------------------------------

TEST(FalseColour, GrowsLighterEvenlyAndMarksWhatIsLeftOut) {
    const auto lightness = [](const vec3& c) {
        const double y = 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z;
        return y > 216.0 / 24389 ? 116 * std::cbrt(y) - 16 : 24389.0 / 27 * y;
    };
    for (int i = 1; i <= 100; ++i) {
        const double step = lightness(magma(i / 100.0)) - lightness(magma((i - 1) / 100.0));
        EXPECT_GT(step, 0.0) << i;
        EXPECT_LT(step, 2.5) << i;
    }
    EXPECT_EQ(magma(-1.0), magma(0.0));
    EXPECT_EQ(magma(7.0), magma(1.0));
    EXPECT_EQ(magma(std::nan("")), vec3(0, 1, 0));
    const Image image = falseColour(std::vector<double>{0.0, 2.0, 4.0, std::nan("")}, 2, 2, 4.0);
    EXPECT_EQ(image.at(1, 0), magma(0.5));
    EXPECT_EQ(image.at(0, 1), magma(1.0));
    EXPECT_EQ(image.at(1, 1), vec3(0, 1, 0));
}

}  // namespace
}  // namespace raig
