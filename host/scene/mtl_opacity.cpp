#include "scene/mtl_opacity.hpp"

#include "base/parallel.hpp"
#include "scene/color.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// Taps which two texels a texel of the larger picture lies, along one axis, and how near the second one.
struct Taps {
    uint32_t first, second;
    double share;
};

std::vector<Taps> linearTaps(uint32_t from, uint32_t to) {
    std::vector<Taps> all(to);
    for (uint32_t i = 0; i < to; ++i) {
        const double at = std::clamp((i + 0.5) * from / to - 0.5, 0.0, from - 1.0);
        const auto first = static_cast<uint32_t>(at);
        all[i] = {first, std::min(first + 1, from - 1), at - first};
    }
    return all;
}

/// Bytes of a picture of `width` x `height`, looked up as if it had another size: `byteOf(texel)` are those that it has.
class Resampled {
public:
    Resampled(uint32_t width, uint32_t height, const uvec2& size, const ByteEncoding& encoding)
        : width_(width),
          keeps_(size == uvec2(width, height)),
          columns_(linearTaps(width, size.x)),
          rows_(linearTaps(height, size.y)),
          encoding_(encoding) {}

    template <class ByteOf>
    uint8_t at(size_t x, size_t y, const ByteOf& byteOf) const {
        if (keeps_) return byteOf(y * width_ + x);
        const Taps &column = columns_[x], &row = rows_[y];
        const auto along = [&](size_t rowAt) {
            const double first = encoding_.values[byteOf(rowAt * width_ + column.first)];
            return std::lerp(first, encoding_.values[byteOf(rowAt * width_ + column.second)], column.share);
        };
        return encoding_.byteOf(std::lerp(along(row.first), along(row.second), row.share));
    }

private:
    size_t width_;
    bool keeps_;
    std::vector<Taps> columns_, rows_;
    const ByteEncoding& encoding_;
};

}  // namespace

bool Opacity::isOpaque() const {
    return std::ranges::all_of(values, [](uint8_t value) { return value == 255; });
}

bool hasAlpha(const Texels& picture) {
    for (size_t i = 3; i < picture.rgba.size(); i += 4)
        if (picture.rgba[i] < 255) return true;
    return false;
}

Opacity opacityOf(const Texels& picture, char channel) {
    const auto valueOf = [&](const uint8_t* texel) -> uint32_t {
        if (channel == 'r') return texel[0];
        if (channel == 'g') return texel[1];
        if (channel == 'b') return texel[2];
        if (channel == 'm') return texel[3];
        return (54u * texel[0] + 183u * texel[1] + 19u * texel[2] + 128u) / 256u;  // Rec. 709's weights: they add up to 256
    };
    Opacity opacity{picture.width, picture.height, std::vector<uint8_t>(picture.rgba.size() / 4)};
    for (size_t i = 0; i < opacity.values.size(); ++i)
        opacity.values[i] = static_cast<uint8_t>(valueOf(&picture.rgba[4 * i]));
    return opacity;
}

uvec2 mergedSize(const Texels* color, const uvec2& opacity) {
    return color ? glm::max(opacity, uvec2(color->width, color->height)) : opacity;
}

Texels withOpacity(const Texels* color, const Opacity& opacity) {
    const uvec2 size = mergedSize(color, {opacity.width, opacity.height});
    const ByteEncoding encoded(true), plain(false);
    const Resampled colors(color ? color->width : 1, color ? color->height : 1, size, encoded);
    const Resampled alphas(opacity.width, opacity.height, size, plain);
    Texels merged{size.x, size.y, std::vector<uint8_t>(size_t{4} * size.x * size.y, 255)};
    parallelFor(size.y, std::max<size_t>(1, 16384 / size.x), [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (size_t x = 0; x < size.x; ++x) {
                uint8_t* texel = &merged.rgba[4 * (y * size.x + x)];
                for (size_t k = 0; color && k < 3; ++k)
                    texel[k] = colors.at(x, y, [&](size_t i) { return color->rgba[4 * i + k]; });
                texel[3] = alphas.at(x, y, [&](size_t i) { return opacity.values[i]; });
            }
    });
    return merged;
}

}  // namespace raig
