/// Pictures: linear RGB in float, and the four file formats they are written to and read from.
#pragma once

#include "base/vectors.hpp"

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <span>
#include <string>
#include <utility>
#include <vector>

namespace raig {

/// Linear RGB with sRGB primaries, row by row from the top. `pixels` holds width * height colours.
struct Image {
    Image() = default;
    Image(uint32_t w, uint32_t h, const vec3& fill = vec3(0.0f)) : width(w), height(h), pixels(size_t{w} * h, fill) {}

    vec3& at(uint32_t x, uint32_t y) { return pixels[size_t{y} * width + x]; }
    const vec3& at(uint32_t x, uint32_t y) const { return pixels[size_t{y} * width + x]; }

    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<vec3> pixels;
};

/// What is read is limited to this many pixels, and to 65536 a side.
inline constexpr uint64_t largestPicture = uint64_t{16384} * 16384;

enum class PictureFormat { png, hdr, exr, pfm };

/// The format that the ending of `path` names (any case). Throws usageError naming the four if it names none.
PictureFormat pictureFormat(const std::filesystem::path& path);

/// Text kept in the file, as (key, value): what the picture was made with. Keys are ASCII of 1..79 characters.
using Notes = std::vector<std::pair<std::string, std::string>>;

/// More that is known of each pixel, for OpenEXR: its channels are called `name`.`channel` there.
struct Layer {
    std::string name;
    std::vector<std::string> channels;
    bool isWhole = false;         ///< whole numbers (UINT), else floats (FLOAT)
    std::vector<uint32_t> words;  ///< row by row from the top, a pixel's channels side by side: numbers, or bits of floats
};

/// A picture as the bytes of a file. The same picture and notes give the same bits.
///
///     png   8 bits a channel, sRGB: clamped to [0, 1], rounded half up; a pixel with a NaN is magenta. Notes: text chunks.
///     hdr   Radiance RGBE: 8 bits of mantissa, rounded to nearest; below 0 is 0, a pixel with a NaN is magenta, what is too
///           large for it the largest. Notes: comment lines.
///     exr   32-bit float, zip, every bit kept. Notes: the `comments` attribute.
///     pfm   32-bit float, little-endian, every bit kept. Notes: none, as the format has no place for them.
///
/// Requires width, height > 0 and width * height pixels. Throws limitError if the format cannot hold so large a picture.
/// Cost: O(pixels); some 40 ms of one core for 512 x 512 as png.
std::vector<std::byte> encodePicture(const Image& image, PictureFormat format, const Notes& notes = {});

/// The same of a picture with layers, or of layers alone (then without channels R, G and B), as one part of an exr; every
/// bit is kept. Requires one or the other, and in each layer width * height * channels words.
std::vector<std::byte> encodeLayers(uint32_t width, uint32_t height, std::span<const vec3> pixels,
                                    std::span<const Layer> layers, const Notes& notes = {});

/// Pixels with a NaN or infinite channel.
uint64_t countNonFinite(const Image& image);

/// Encodes by the ending of `path` and writes atomically. Returns countNonFinite(image), for the caller to warn of.
/// Throws usageError for an unknown ending, an Error if the file cannot be written.
uint64_t writePicture(const std::filesystem::path& path, const Image& image, const Notes& notes = {});

/// A file's bytes as a picture: PNG or JPEG (decoded from sRGB, alpha ignored), Radiance HDR, OpenEXR (one part, scan lines
/// or tiles; R G B or Y, alpha and other channels ignored; the data window), PFM (both byte orders, colour or grey). The
/// format is told by the content, not by a name. `place` names the file in errors.
///
/// Throws inputError if the bytes are no such file, are cut short or damaged; limitError beyond largestPicture. Memory is
/// bounded by the length of `bytes`, as a header may promise anything.
Image decodePicture(std::span<const std::byte> bytes, const std::string& place);

/// Reads a picture file: readFile, then decodePicture.
Image readPicture(const std::filesystem::path& path);

}  // namespace raig
