/// Radiance RGBE pictures [Ward 1991, "Real Pixels", Graphics Gems II]. Written through stb_image_write; read here, as
/// stb_image takes a cut-short file for a whole one, and can loop for ever on a damaged one.
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "image/formats.hpp"

#include <stb_image_write.h>

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <limits>
#include <optional>

namespace raig::image {

namespace {

const float largestRgbe = std::ldexp(255.0f, 119);

/// The nearest colour that RGBE can hold: three mantissas of 8 bits under the largest channel's exponent. stb truncates;
/// rounding before halves the error and takes its bias.
vec3 nearestRgbe(const vec3& c) {
    if (std::isnan(c.x) || std::isnan(c.y) || std::isnan(c.z)) return {1.0f, 0.0f, 1.0f};
    const vec3 kept = glm::clamp(c, 0.0f, largestRgbe);
    const float largest = std::max({kept.x, kept.y, kept.z});
    if (largest < 1e-32f) return vec3(0.0f);
    int exponent = 0;
    std::frexp(largest, &exponent);
    if (std::round(std::ldexp(largest, 8 - exponent)) > 255.0f) ++exponent;  // rounds up to 2^exponent
    vec3 rounded;
    for (int k = 0; k < 3; ++k) rounded[k] = std::ldexp(std::round(std::ldexp(kept[k], 8 - exponent)), exponent - 8);
    return rounded;
}

}  // namespace

Bytes encodeHdr(const Image& image, const Notes& notes) {
    if (image.width > 65536 * 16 || image.height > 65536 * 16)
        throw limitError("an hdr of {} x {} pixels is too large to write; write .exr or .pfm", image.width, image.height);
    Image rounded(image.width, image.height);
    parallelFor(image.pixels.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) rounded.pixels[i] = nearestRgbe(image.pixels[i]);
    });

    std::string whole;
    const auto append = [](void* user, void* data, int size) {
        static_cast<std::string*>(user)->append(static_cast<const char*>(data), static_cast<size_t>(size));
    };
    if (!stbi_write_hdr_to_func(append, &whole, static_cast<int>(image.width), static_cast<int>(image.height), 3,
                                &rounded.pixels[0].x))
        throw limitError("no memory to write an hdr of {} x {} pixels", image.width, image.height);

    std::string comments;
    for (const auto& [key, value] : notes) {
        std::string line = fmt::format("# {}: {}", key, value);
        std::replace_if(
            line.begin(), line.end(), [](char c) { return c == '\n' || c == '\r' || c == '\0'; }, ' ');
        comments += line + '\n';
    }
    whole.insert(whole.find('\n') + 1, comments);  // after the first line, which names the format
    const auto* begin = reinterpret_cast<const std::byte*>(whole.data());
    return {begin, begin + whole.size()};
}

namespace {

/// Reads bytes and header lines, and never beyond the end.
struct Reader {
    ByteSpan bytes;
    const std::string& place;
    size_t at = 0;

    uint8_t byte() {
        if (at >= bytes.size()) throw inputError(place, "is cut short: the picture goes on where the file ends");
        return static_cast<uint8_t>(bytes[at++]);
    }
    std::string line() {
        std::string text;
        for (char c; (c = static_cast<char>(byte())) != '\n';) {
            if (text.size() >= 65536) throw inputError(place, "is damaged: a header line is longer than 65536 bytes");
            text.push_back(c);
        }
        return text;
    }
};

/// Width and height of "-Y height +X width", the only orientation read: rows from the top, left to right.
std::optional<std::array<uint32_t, 2>> parseResolution(std::string_view line) {
    std::array<uint32_t, 2> size{};
    const auto take = [&](std::string_view sign, uint32_t& number) {
        if (!line.starts_with(sign)) return false;
        line.remove_prefix(sign.size());
        const auto [end, error] = std::from_chars(line.data(), line.data() + line.size(), number);
        line.remove_prefix(static_cast<size_t>(end - line.data()));
        return error == std::errc();
    };
    if (!take("-Y ", size[1]) || !take(" +X ", size[0]) || !line.empty()) return std::nullopt;
    return size;
}

using Rgbe = std::array<uint8_t, 4>;

/// One channel of a run-length encoded row.
void readRuns(Reader& in, std::vector<Rgbe>& row, int channel) {
    for (size_t x = 0; x < row.size();) {
        const uint8_t code = in.byte();
        const size_t count = code > 128 ? code - 128u : code;
        if (count == 0 || count > row.size() - x) throw inputError(in.place, "is damaged: a run of pixels leaves its row");
        if (code > 128) {
            const uint8_t value = in.byte();
            for (size_t i = 0; i < count; ++i) row[x++][channel] = value;
        } else {
            for (size_t i = 0; i < count; ++i) row[x++][channel] = in.byte();
        }
    }
}

/// One row: run-length encoded channel by channel, or else pixel by pixel.
void readRow(Reader& in, std::vector<Rgbe>& row) {
    const auto pixel = [&] { return Rgbe{in.byte(), in.byte(), in.byte(), in.byte()}; };  // braces: left to right
    const Rgbe first = pixel();
    const bool runs = row.size() >= 8 && row.size() < 32768 && first[0] == 2 && first[1] == 2 && first[2] < 128;
    if (runs) {
        if (size_t{first[2]} * 256 + first[3] != row.size())
            throw inputError(in.place, "is damaged: a row has another width");
        for (int channel = 0; channel < 4; ++channel) readRuns(in, row, channel);
        return;
    }
    row[0] = first;
    for (size_t x = 1; x < row.size(); ++x) row[x] = pixel();
    // A mantissa below 128 in every channel is not normalised; (1, 1, 1, n) was a run in the first version of the format.
    for (const Rgbe& p : row)
        if (p[0] == 1 && p[1] == 1 && p[2] == 1)
            throw inputError(in.place, "has runs of the kind used before 1991, which is not read; save it anew");
}

vec3 toColour(const Rgbe& p) {
    if (p[3] == 0) return vec3(0.0f);
    const float unit = std::ldexp(1.0f, int{p[3]} - 136);
    return {static_cast<float>(p[0]) * unit, static_cast<float>(p[1]) * unit, static_cast<float>(p[2]) * unit};
}

}  // namespace

Image decodeHdr(ByteSpan bytes, const std::string& place) {
    Reader in{bytes, place};
    const std::string magic = in.line();
    if (magic != "#?RADIANCE" && magic != "#?RGBE")
        throw inputError(place, "is no Radiance picture: it begins with {:.20}", magic);
    for (std::string line = in.line(); !line.empty(); line = in.line())
        if (line.starts_with("FORMAT=") && line != "FORMAT=32-bit_rle_rgbe")
            throw inputError(place, "has the pixels of {:.40}; only FORMAT=32-bit_rle_rgbe is read", line);
    const std::string resolution = in.line();
    const auto size = parseResolution(resolution);
    if (!size) throw inputError(place, "has the size '{:.40}', which should be like '-Y 480 +X 640'", resolution);
    const auto [width, height] = *size;
    checkSize(width, height, bytes.size(), 16, place);  // a run makes 127 pixels of 4 times 2 bytes

    Image image(width, height);
    std::vector<Rgbe> row(width);
    for (uint32_t y = 0; y < height; ++y) {
        readRow(in, row);
        for (uint32_t x = 0; x < width; ++x) image.at(x, y) = toColour(row[x]);
    }
    return image;
}

}  // namespace raig::image
