// False colours: in order, told apart, the same in every picture; and a legend that says what they stand for.
#include "image/views.hpp"
#include "image/metrics.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <set>

namespace raig {
namespace {

constexpr double none = std::numeric_limits<double>::infinity();

bool isGrey(const vec3& c) {
    return c.x == c.y && c.y == c.z;
}

TEST(NumberViews, ReachFromTheLeastToTheGreatestFiniteNumber) {
    const std::vector<double> values = {5.0, -2.0, none, 1.5, std::nan(""), 5.0};
    const NumberView view = viewNumbers(values, 3, 2);
    EXPECT_EQ(view.low, -2.0);
    EXPECT_EQ(view.high, 5.0);
    EXPECT_EQ(view.image.pixels[0], magma(1.0));
    EXPECT_EQ(view.image.pixels[1], magma(0.0));
    EXPECT_EQ(view.image.pixels[3], magma(0.5));
    EXPECT_TRUE(isGrey(view.image.pixels[2]) && isGrey(view.image.pixels[4]));
}

TEST(NumberViews, OfEqualNumbersOrNoneAreOfOneColour) {
    for (const double value : {0.0, 4.0, none}) {
        const NumberView view = viewNumbers(std::vector<double>(6, value), 2, 3);
        EXPECT_EQ(view.low, view.high);
        for (const vec3& c : view.image.pixels) EXPECT_EQ(c, view.image.pixels[0]);
        EXPECT_EQ(isGrey(view.image.pixels[0]), !std::isfinite(value));
    }
}

/// The lowest rows that differ between pictures of the same colour field with other numbers: the legend's.
TEST(NumberViews, HaveALegendThatTellsTheNumbersWhereThereIsRoom) {
    const auto ramp = [](uint32_t w, uint32_t h, double scale) {
        std::vector<double> values(size_t{w} * h);
        for (size_t i = 0; i < values.size(); ++i) values[i] = scale * double(i % w);
        return viewNumbers(values, w, h).image;
    };
    const Image one = ramp(96, 64, 1.0), ten = ramp(96, 64, 1.7);
    uint32_t first = one.height;
    for (uint32_t y = one.height; y-- > 0;)
        for (uint32_t x = 0; x < one.width; ++x)
            if (one.at(x, y) != ten.at(x, y)) first = y;
    EXPECT_LT(first, one.height) << "95 and 161.5 are written differently";
    EXPECT_GT(first, one.height * 3 / 4) << "and nothing else differs";
    EXPECT_EQ(ramp(63, 64, 1.0).at(62, 63), magma(1.0)) << "no room: the picture alone";
    EXPECT_EQ(ramp(96, 47, 1.0).at(95, 46), magma(1.0));
}

TEST(ColoursOfIds, AreAllDifferentAndNoneIsDark) {
    std::set<std::array<float, 3>> seen;
    for (uint32_t id = 0; id < 4096; ++id) {
        const vec3 c = colourOfId(id);
        EXPECT_GT(std::max({c.x, c.y, c.z}), 0.04f);
        seen.insert({c.x, c.y, c.z});
    }
    EXPECT_GE(seen.size(), 4090u) << "of 2^24 colours";
    EXPECT_EQ(colourOfId(0xffffffffu), vec3(0.0f));
}

TEST(ShownColours, AreEncodedBackToThemselves) {
    Image image(256, 1);
    for (uint32_t i = 0; i < 256; ++i) image.at(i, 0) = shownAs(vec3(static_cast<float>(i) / 255.0f, 0.0f, 2.0f));
    const Image back = decodePicture(encodePicture(image, PictureFormat::png), "memory");
    for (uint32_t i = 0; i < 256; ++i) {
        EXPECT_NEAR(back.at(i, 0).x, image.at(i, 0).x, 1e-6f) << i;
        EXPECT_EQ(back.at(i, 0).z, 1.0f);
    }
    EXPECT_EQ(shownAs(vec3(std::nanf(""), -1.0f, 0.0f)), vec3(0.0f));
}

}  // namespace
}  // namespace raig
