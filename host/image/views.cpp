#include "image/views.hpp"

#include "base/error.hpp"
#include "image/metrics.hpp"
#include "image/srgb.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

namespace raig {

namespace {

const vec3 noNumber(0.18f);  // grey, which is not in the map

/// Digits of 3 x 5 pixels: rows from the top, three bits each, the left one first.
constexpr std::string_view drawn = "0123456789.-+e";
constexpr std::array<std::array<uint8_t, 5>, drawn.size()> digits = {{{7, 5, 5, 5, 7},
                                                                      {2, 6, 2, 2, 7},
                                                                      {7, 1, 7, 4, 7},
                                                                      {7, 1, 3, 1, 7},
                                                                      {5, 5, 7, 1, 1},
                                                                      {7, 4, 7, 1, 7},
                                                                      {7, 4, 7, 5, 7},
                                                                      {7, 1, 2, 2, 2},
                                                                      {7, 5, 7, 5, 7},
                                                                      {7, 5, 7, 1, 7},
                                                                      {0, 0, 0, 0, 2},
                                                                      {0, 0, 7, 0, 0},
                                                                      {0, 2, 7, 2, 0},
                                                                      {0, 3, 7, 4, 3}}};
constexpr uint32_t digitWidth = 4, digitHeight = 5;  // with the gap to the next

/// Writes `text` with its upper left corner at (x, y), each pixel of a digit `size` wide; what does not fit is left out.
void write(Image& image, uint32_t x, uint32_t y, uint32_t size, std::string_view text, const vec3& colour) {
    for (size_t i = 0; i < text.size(); ++i) {
        const size_t which = drawn.find(text[i]);
        if (which == drawn.npos) continue;
        for (uint32_t row = 0; row < digitHeight * size; ++row)
            for (uint32_t column = 0; column < 3 * size; ++column) {
                const uint32_t px = x + static_cast<uint32_t>(i) * digitWidth * size + column, py = y + row;
                const bool on = digits[which][row / size] >> (2 - column / size) & 1;
                if (on && px < image.width && py < image.height) image.at(px, py) = colour;
            }
    }
}

void drawLegend(Image& image, double low, double high) {
    if (image.width < 64 || image.height < 48) return;
    const uint32_t size = std::max(1u, std::min(image.width / 192, image.height / 96));
    const uint32_t height = (digitHeight + 4) * size, top = image.height - height;
    for (uint32_t y = top; y < image.height; ++y)
        for (uint32_t x = 0; x < image.width; ++x)
            image.at(x, y) = y < top + size ? vec3(1.0f) : magma(double(x) / (image.width - 1));
    const std::string least = fmt::format("{:.4g}", low), greatest = fmt::format("{:.4g}", high);
    const uint32_t margin = 2 * size, width = static_cast<uint32_t>(greatest.size()) * digitWidth * size;
    write(image, margin, top + 3 * size, size, least, vec3(1.0f));
    write(image, image.width - std::min(image.width, width + margin), top + 3 * size, size, greatest, vec3(0.0f));
}

}  // namespace

NumberView viewNumbers(std::span<const double> values, uint32_t width, uint32_t height) {
    RAIG_CHECK_OP(values.size(), ==, size_t{width} * height);
    NumberView view;
    bool any = false;
    for (const double value : values) {
        if (!std::isfinite(value)) continue;
        view.low = any ? std::min(view.low, value) : value;
        view.high = any ? std::max(view.high, value) : value;
        any = true;
    }
    const auto place = [&](double value) {
        return view.high > view.low ? (value - view.low) / (view.high - view.low) : 0.5;
    };
    view.image = Image(width, height);
    for (size_t i = 0; i < values.size(); ++i)
        view.image.pixels[i] = std::isfinite(values[i]) ? magma(place(values[i])) : noNumber;
    drawLegend(view.image, view.low, view.high);
    return view;
}

vec3 colourOfId(uint32_t id) {
    if (id == 0xffffffffu) return vec3(0.0f);
    // The finaliser of MurmurHash3 [Appleby 2011]: every bit of the id changes about half of the colour's.
    uint32_t h = id + 0x9e3779b9u;
    h = (h ^ h >> 16) * 0x85ebca6bu;
    h = (h ^ h >> 13) * 0xc2b2ae35u;
    h ^= h >> 16;
    const auto channel = [&](uint32_t shift) { return 0.25f + 0.75f * static_cast<float>(h >> shift & 255u) / 255.0f; };
    return shownAs({channel(0), channel(8), channel(16)});
}

vec3 shownAs(const vec3& shown) {
    const auto linear = [](float code) {
        return static_cast<float>(srgb::toLinear(code > 0.0f ? std::min(double{code}, 1.0) : 0.0));
    };
    return {linear(shown.x), linear(shown.y), linear(shown.z)};
}

}  // namespace raig
