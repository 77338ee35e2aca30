#include "image/image.hpp"

#include "base/error.hpp"
#include "base/files.hpp"
#include "image/formats.hpp"

#include <algorithm>
#include <cctype>
#include <cstring>

namespace raig {

namespace image {

void checkSize(uint64_t width, uint64_t height, uint64_t bytesHeld, uint64_t pixelsPerByte, const std::string& place) {
    if (width == 0 || height == 0)
        throw inputError(place, "is a picture of {} x {} pixels: there is nothing in it", width, height);
    if (width > 65536 || height > 65536 || width * height > largestPicture)
        throw limitError("{}: is a picture of {} x {} pixels; at most {} pixels, 65536 a side, can be read", place, width,
                         height, largestPicture);
    if (width * height / pixelsPerByte > bytesHeld)
        throw inputError(place, "promises {} x {} pixels, but its {} bytes cannot hold them: it is cut short or damaged",
                         width, height, bytesHeld);
}

bool startsWith(ByteSpan bytes, std::string_view magic) {
    return bytes.size() >= magic.size() && std::memcmp(bytes.data(), magic.data(), magic.size()) == 0;
}

}  // namespace image

PictureFormat pictureFormat(const std::filesystem::path& path) {
    std::string ending = path.extension().string();
    for (char& c : ending) c = static_cast<char>(std::tolower(static_cast<unsigned char>(c)));
    if (ending == ".png") return PictureFormat::png;
    if (ending == ".hdr") return PictureFormat::hdr;
    if (ending == ".exr") return PictureFormat::exr;
    if (ending == ".pfm") return PictureFormat::pfm;
    throw usageError("{}: pictures are written as .png, .hdr, .exr or .pfm; name the file so", path.string());
}

namespace {

void checkNotes(const Notes& notes) {
    for (const auto& [key, value] : notes) {
        RAIG_CHECK(!key.empty() && key.size() < 80 && key.front() != ' ' && key.back() != ' ');
        RAIG_CHECK(std::all_of(key.begin(), key.end(), [](char c) { return c >= ' ' && c <= '~'; }));
    }
}

}  // namespace

std::vector<std::byte> encodePicture(const Image& image, PictureFormat format, const Notes& notes) {
    RAIG_CHECK(image.width > 0 && image.height > 0);
    RAIG_CHECK_OP(image.pixels.size(), ==, size_t{image.width} * image.height);
    checkNotes(notes);
    switch (format) {
        case PictureFormat::png:
            return image::encodePng(image, notes);
        case PictureFormat::hdr:
            return image::encodeHdr(image, notes);
        case PictureFormat::exr:
            return image::encodeExr(image.width, image.height, image.pixels, {}, notes);
        case PictureFormat::pfm:
            return image::encodePfm(image);
    }
    RAIG_CHECK(!"a picture format");
    return {};
}

std::vector<std::byte> encodeLayers(uint32_t width, uint32_t height, std::span<const vec3> pixels,
                                    std::span<const Layer> layers, const Notes& notes) {
    RAIG_CHECK(width > 0 && height > 0 && !(pixels.empty() && layers.empty()));
    const size_t count = size_t{width} * height;
    if (!pixels.empty()) RAIG_CHECK_OP(pixels.size(), ==, count);
    for (const Layer& layer : layers) RAIG_CHECK_OP(layer.words.size(), ==, count * layer.channels.size());
    checkNotes(notes);
    return image::encodeExr(width, height, pixels, layers, notes);
}

uint64_t countNonFinite(const Image& image) {
    return static_cast<uint64_t>(
        std::count_if(image.pixels.begin(), image.pixels.end(), [](const vec3& c) { return !isFinite(c); }));
}

uint64_t writePicture(const std::filesystem::path& path, const Image& image, const Notes& notes) {
    writeFileAtomically(path, encodePicture(image, pictureFormat(path), notes));
    return countNonFinite(image);
}

Image decodePicture(std::span<const std::byte> bytes, const std::string& place) {
    using namespace image;
    if (startsWith(bytes, "\x89PNG\r\n\x1a\n") || startsWith(bytes, "\xff\xd8\xff")) return decodeSrgb(bytes, place);
    if (startsWith(bytes, "#?")) return decodeHdr(bytes, place);
    if (startsWith(bytes, "\x76\x2f\x31\x01")) return decodeExr(bytes, place);
    if (startsWith(bytes, "PF") || startsWith(bytes, "Pf")) return decodePfm(bytes, place);
    throw inputError(place, "is none of the pictures that can be read: png, jpg, hdr, exr, pfm");
}

Image readPicture(const std::filesystem::path& path) {
    return decodePicture(readFile(path), path.string());
}

}  // namespace raig
