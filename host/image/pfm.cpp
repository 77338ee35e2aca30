#include "base/error.hpp"
#include "image/formats.hpp"

#include <bit>
#include <charconv>
#include <cstring>

namespace raig::image {

static_assert(std::endian::native == std::endian::little, "floats are copied to and from little-endian files as they are");

Bytes encodePfm(const Image& image) {
    const std::string header = fmt::format("PF\n{} {}\n-1.0\n", image.width, image.height);
    const size_t row = size_t{image.width} * sizeof(vec3);
    Bytes bytes(header.size() + row * image.height);
    std::memcpy(bytes.data(), header.data(), header.size());
    for (uint32_t y = 0; y < image.height; ++y)  // the bottom row is first
        std::memcpy(bytes.data() + header.size() + row * (image.height - 1 - y), &image.at(0, y), row);
    return bytes;
}

namespace {

bool isSpace(char c) {
    return c == ' ' || c == '\n' || c == '\r' || c == '\t';
}

/// The header's words, parted by white space. The last is followed by exactly one such byte.
struct Words {
    std::string_view text;
    size_t at = 0;
    std::string_view next() {
        while (at < text.size() && isSpace(text[at])) ++at;
        const size_t begin = at;
        while (at < text.size() && !isSpace(text[at])) ++at;
        return text.substr(begin, at - begin);
    }
};

/// Whether the whole word is the number.
template <class Number>
bool parse(std::string_view word, Number& number) {
    const auto [end, error] = std::from_chars(word.data(), word.data() + word.size(), number);
    return error == std::errc() && end == word.data() + word.size();
}

float load(const std::byte* at, bool little) {
    uint32_t bits;
    std::memcpy(&bits, at, sizeof bits);
    if (!little) bits = __builtin_bswap32(bits);
    return std::bit_cast<float>(bits);
}

}  // namespace

Image decodePfm(ByteSpan bytes, const std::string& place) {
    const size_t headerLimit = std::min<size_t>(bytes.size(), 256);
    Words words{{reinterpret_cast<const char*>(bytes.data()), headerLimit}};
    const std::string_view magic = words.next(), widthWord = words.next(), heightWord = words.next(),
                           scaleWord = words.next();
    uint32_t width = 0, height = 0;
    double scale = 0.0;
    if ((magic != "PF" && magic != "Pf") || !parse(widthWord, width) || !parse(heightWord, height) ||
        !parse(scaleWord, scale) || !(std::abs(scale) > 0.0) || words.at >= headerLimit)
        throw inputError(place, "has no PFM header: PF or Pf, width, height and a scale that is not 0 should begin it");

    // The scale's sign is the byte order; its magnitude is a unit that no reader agrees on, and is left alone.
    const bool little = scale < 0.0;
    const size_t channels = magic == "PF" ? 3 : 1;
    const size_t begin = words.at + 1;
    checkSize(width, height, bytes.size(), 1, place);
    const uint64_t need = uint64_t{width} * height * channels * sizeof(float);
    if (bytes.size() - begin != need)
        throw inputError(place, "holds {} bytes of pixels, but {} x {} of {} channels take {}: it is cut short or damaged",
                         bytes.size() - begin, width, height, channels, need);

    Image image(width, height);
    const std::byte* at = bytes.data() + begin;
    for (uint32_t y = height; y-- > 0;) {
        for (uint32_t x = 0; x < width; ++x, at += channels * sizeof(float)) {
            const float first = load(at, little);
            image.at(x, y) = channels == 1 ? vec3(first) : vec3(first, load(at + 4, little), load(at + 8, little));
        }
    }
    return image;
}

}  // namespace raig::image
