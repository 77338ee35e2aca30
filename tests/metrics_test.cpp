// The measures of difference against closed forms and each other. FLIP by itself is in flip_test.cpp.
#include "image/metrics.hpp"
#include "base/error.hpp"
#include "support/images.hpp"

#include <gtest/gtest.h>
#include <tbb/global_control.h>

#include <cmath>
#include <functional>
#include <limits>

namespace raig {
namespace {

using test::noise;

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr float nan = std::numeric_limits<float>::quiet_NaN();

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
