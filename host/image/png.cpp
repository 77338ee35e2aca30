/// PNG and JPEG, through stb_image and stb_image_write. What those leave unchecked is checked here: a PNG's chunks (lengths,
/// CRCs, the end), reading beyond the end, and sizes before they are allocated.
#include "base/error.hpp"
#include "base/parallel.hpp"
#include "image/formats.hpp"
#include "image/srgb.hpp"

#include <stb_image.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <bit>
#include <cstdlib>
#include <cstring>
#include <limits>
#include <memory>

namespace {

/// What stb_image_write deflates with, in place of its own: zlib makes a third less bytes in half the time.
unsigned char* deflate(unsigned char* data, int size, int* outSize, int level) {
    uLongf length = compressBound(static_cast<uLong>(size));
    auto* out = static_cast<unsigned char*>(std::malloc(length));
    if (!out || compress2(out, &length, data, static_cast<uLong>(size), level) != Z_OK) {
        std::free(out);
        return nullptr;
    }
    *outSize = static_cast<int>(length);
    return out;
}

}  // namespace

// The writer is compiled here, for this file alone, as the packaged one cannot be told to use zlib.
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#define STBIW_ZLIB_COMPRESS deflate
#define STB_IMAGE_WRITE_STATIC
#define STB_IMAGE_WRITE_IMPLEMENTATION
#include <stb_image_write.h>
#pragma GCC diagnostic pop

namespace raig::image {

namespace {

constexpr size_t signatureBytes = 8;

/// The CRC of PNG's chunks [ISO 15948:2004, annex D].
uint32_t crc(ByteSpan bytes) {
    static const std::array<uint32_t, 256> table = [] {
        std::array<uint32_t, 256> made{};
        for (uint32_t n = 0; n < 256; ++n) {
            made[n] = n;
            for (int bit = 0; bit < 8; ++bit) made[n] = (made[n] >> 1) ^ ((made[n] & 1) ? 0xedb88320u : 0u);
        }
        return made;
    }();
    uint32_t value = 0xffffffffu;
    for (const std::byte b : bytes) value = table[(value ^ static_cast<uint32_t>(b)) & 0xff] ^ (value >> 8);
    return ~value;
}

uint32_t loadBig(const std::byte* at) {
    uint32_t value;
    std::memcpy(&value, at, sizeof value);
    return __builtin_bswap32(value);
}

void appendBig(Bytes& bytes, uint32_t value) {
    for (int shift = 24; shift >= 0; shift -= 8) bytes.push_back(static_cast<std::byte>(value >> shift));
}

void appendText(Bytes& bytes, std::string_view text) {
    for (const char c : text) bytes.push_back(static_cast<std::byte>(c));
}

void appendChunk(Bytes& bytes, std::string_view type, std::string_view data) {
    appendBig(bytes, static_cast<uint32_t>(data.size()));
    const size_t begin = bytes.size();
    appendText(bytes, type);
    appendText(bytes, data);
    appendBig(bytes, crc(ByteSpan(bytes).subspan(begin)));
}

/// A text chunk: tEXt holds Latin-1, so what is not ASCII goes into an iTXt chunk, as UTF-8.
void appendNote(Bytes& bytes, const std::string& key, std::string value) {
    std::erase(value, '\0');
    const bool ascii = std::all_of(value.begin(), value.end(), [](char c) { return static_cast<unsigned char>(c) < 0x80; });
    if (ascii)
        appendChunk(bytes, "tEXt", key + '\0' + value);
    else
        appendChunk(bytes, "iTXt", key + std::string("\0\0\0\0\0", 5) + value);
}

/// Rounds linear light to sRGB bytes, half up, without a power function a pixel.
class ByteTable {
public:
    ByteTable() {
        for (size_t k = 0; k < thresholds.size(); ++k)
            thresholds[k] = srgb::toLinear((static_cast<double>(k) + 0.5) / 255.0);
        for (uint32_t i = 0; i < first.size(); ++i) first[i] = advance(0, std::bit_cast<float>((i + lowest) << 15));
    }
    /// Requires `linear` not NaN.
    uint8_t operator()(float linear) const {
        if (linear < smallest) return 0;
        if (linear >= 1.0f) return 255;
        return advance(first[(std::bit_cast<uint32_t>(linear) >> 15) - lowest], linear);
    }

private:
    /// The number of thresholds at or below `linear`, where threshold k is the light that encodes to k + 1/2.
    uint8_t advance(uint8_t from, float linear) const {
        while (from < 255 && double{linear} >= thresholds[from]) ++from;
        return from;
    }
    static constexpr float smallest = 0x1p-13f;  // encodes to less than 1/2
    static constexpr uint32_t lowest = std::bit_cast<uint32_t>(smallest) >> 15;
    std::array<double, 255> thresholds;
    std::array<uint8_t, 13 * 256> first;  // the byte of the least float with these exponent and top 8 mantissa bits
};

std::vector<uint8_t> toBytes(const Image& image) {
    static const ByteTable toByte;
    std::vector<uint8_t> texels(image.pixels.size() * 3);
    parallelFor(image.pixels.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const vec3& c = image.pixels[i];
            const bool bad = std::isnan(c.x) || std::isnan(c.y) || std::isnan(c.z);
            const vec3 shown = bad ? vec3(1.0f, 0.0f, 1.0f) : c;
            for (int k = 0; k < 3; ++k) texels[3 * i + k] = toByte(shown[k]);
        }
    });
    return texels;
}

}  // namespace

Bytes encodePng(const Image& image, const Notes& notes) {
    // stb counts bytes in int, and its deflate needs room to spare.
    if (uint64_t{image.width} * image.height * 3 + image.height > uint64_t{1} << 30)
        throw limitError("a png of {} x {} pixels is too large to write; write .exr or .pfm", image.width, image.height);

    // Measured on 512 x 512 with noise: level 4 takes 24 ms for 315 KB, 6 takes 93 ms for 294 KB, and trying all filters a
    // row, 42 ms for 325 KB.
    static const bool configured = [] {
        stbi_write_png_compression_level = 4;
        stbi_write_force_png_filter = 1;  // each byte less the one to its left
        return true;
    }();
    RAIG_CHECK(configured);
    const std::vector<uint8_t> texels = toBytes(image);
    const auto width = static_cast<int>(image.width), height = static_cast<int>(image.height);
    Bytes whole;
    const auto append = [](void* user, void* data, int size) {
        const auto* begin = static_cast<const std::byte*>(data);
        static_cast<Bytes*>(user)->insert(static_cast<Bytes*>(user)->end(), begin, begin + size);
    };
    if (!stbi_write_png_to_func(append, &whole, width, height, 3, texels.data(), 3 * width))
        throw limitError("no memory to write a png of {} x {} pixels", width, height);

    const size_t headerEnd = signatureBytes + 12 + 13;
    Bytes bytes(whole.begin(), whole.begin() + headerEnd);
    appendChunk(bytes, "sRGB", std::string_view("\0", 1));  // perceptual intent
    for (const auto& [key, value] : notes) appendNote(bytes, key, value);
    bytes.insert(bytes.end(), whole.begin() + headerEnd, whole.end());
    return bytes;
}

namespace {

/// At best deflate makes 1032 bytes of one, with 8 pixels in each; JPEG is far from that.
constexpr uint64_t pixelsPerByte = 8 * 1032;

/// Walks a PNG's chunks: every length must fit, every CRC be right, IEND be there, and the size be one that can be read.
/// stb checks none of the CRCs, and has no words for a picture that is merely too large.
void checkChunks(ByteSpan bytes, const std::string& place) {
    for (size_t at = signatureBytes; bytes.size() - at >= 12;) {
        const uint64_t length = loadBig(bytes.data() + at);
        if (length > bytes.size() - at - 12) break;
        const ByteSpan typeAndData = bytes.subspan(at + 4, 4 + length);
        if (crc(typeAndData) != loadBig(bytes.data() + at + 8 + length))
            throw inputError(place, "is damaged: the checksum of the chunk at byte {} is wrong", at);
        if (startsWith(typeAndData, "IHDR") && length >= 8)
            checkSize(loadBig(typeAndData.data() + 4), loadBig(typeAndData.data() + 8), bytes.size(), pixelsPerByte, place);
        if (startsWith(typeAndData, "IEND")) return;
        at += 12 + length;
    }
    throw inputError(place, "is cut short: a PNG ends with an IEND chunk, and this one does not");
}

/// Bytes handed to stb, which takes the end of the file for zeros: `beyond` says that it asked for more than there is.
struct Source {
    ByteSpan bytes;
    size_t at = 0;
    bool beyond = false;

    static int read(void* user, char* data, int size) {
        auto& self = *static_cast<Source*>(user);
        const size_t got = std::min(static_cast<size_t>(size), self.bytes.size() - self.at);
        if (got == 0 && size > 0) self.beyond = true;
        if (got > 0) std::memcpy(data, self.bytes.data() + self.at, got);
        self.at += got;
        return static_cast<int>(got);
    }
    static void skip(void* user, int count) {
        auto& self = *static_cast<Source*>(user);
        const auto target = static_cast<int64_t>(self.at) + count;
        if (target > static_cast<int64_t>(self.bytes.size())) self.beyond = true;
        self.at = static_cast<size_t>(std::clamp<int64_t>(target, 0, static_cast<int64_t>(self.bytes.size())));
    }
    static int eof(void* user) {
        const auto& self = *static_cast<Source*>(user);
        return self.at == self.bytes.size() ? 1 : 0;
    }
};

/// Fills `image` from RGB samples of `Sample`, each decoded by a table of all its values.
template <class Sample>
void fill(Image& image, const Sample* samples) {
    constexpr size_t count = size_t{std::numeric_limits<Sample>::max()} + 1;
    std::vector<float> table(count);
    for (size_t i = 0; i < count; ++i)
        table[i] = static_cast<float>(srgb::toLinear(static_cast<double>(i) / static_cast<double>(count - 1)));
    for (size_t i = 0; i < image.pixels.size(); ++i)
        image.pixels[i] = vec3(table[samples[3 * i]], table[samples[3 * i + 1]], table[samples[3 * i + 2]]);
}

}  // namespace

Image decodeSrgb(ByteSpan bytes, const std::string& place) {
    if (bytes.size() > static_cast<size_t>(std::numeric_limits<int>::max()))
        throw limitError("{}: holds {} bytes, more than can be read as a picture", place, bytes.size());
    const bool isPng = startsWith(bytes, "\x89PNG");
    if (isPng) checkChunks(bytes, place);

    const stbi_io_callbacks callbacks{Source::read, Source::skip, Source::eof};
    const auto reason = [] { return stbi_failure_reason() ? stbi_failure_reason() : "unknown"; };
    int width = 0, height = 0, channels = 0;
    Source source{bytes};
    if (!stbi_info_from_callbacks(&callbacks, &source, &width, &height, &channels) || width < 1 || height < 1)
        throw inputError(place, "cannot be read as a picture ({}): it is cut short or damaged", reason());
    checkSize(static_cast<uint64_t>(width), static_cast<uint64_t>(height), bytes.size(), pixelsPerByte, place);

    source = {bytes};
    const bool deep = isPng && stbi_is_16_bit_from_callbacks(&callbacks, &source);
    source = {bytes};
    int gotWidth = 0, gotHeight = 0;
    const std::unique_ptr<void, void (*)(void*)> samples(
        deep ? static_cast<void*>(stbi_load_16_from_callbacks(&callbacks, &source, &gotWidth, &gotHeight, &channels, 3))
             : static_cast<void*>(stbi_load_from_callbacks(&callbacks, &source, &gotWidth, &gotHeight, &channels, 3)),
        stbi_image_free);
    if (!samples) throw inputError(place, "cannot be read as a picture ({}): it is cut short or damaged", reason());
    if (source.beyond) throw inputError(place, "is cut short: the picture goes on where the file ends");
    if (gotWidth != width || gotHeight != height)
        throw inputError(place, "is damaged: it gives its size twice, differently");

    Image image(static_cast<uint32_t>(width), static_cast<uint32_t>(height));
    if (deep)
        fill(image, static_cast<const uint16_t*>(samples.get()));
    else
        fill(image, static_cast<const uint8_t*>(samples.get()));
    return image;
}

}  // namespace raig::image
