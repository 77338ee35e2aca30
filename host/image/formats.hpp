/// The codecs behind encodePicture and decodePicture, one pair a format. Only image.cpp and they include this.
#pragma once

#include "image/image.hpp"

namespace raig::image {

using Bytes = std::vector<std::byte>;
using ByteSpan = std::span<const std::byte>;

Bytes encodePng(const Image& image, const Notes& notes);
Bytes encodeHdr(const Image& image, const Notes& notes);
Bytes encodeExr(uint32_t width, uint32_t height, std::span<const vec3> pixels, std::span<const Layer> layers,
                const Notes& notes);
Bytes encodePfm(const Image& image);

/// PNG and JPEG.
Image decodeSrgb(ByteSpan bytes, const std::string& place);
Image decodeHdr(ByteSpan bytes, const std::string& place);
Image decodeExr(ByteSpan bytes, const std::string& place);
Image decodePfm(ByteSpan bytes, const std::string& place);

/// Throws inputError for 0 x n pictures and for more pixels than `bytesHeld` bytes can encode at `pixelsPerByte`; limitError
/// beyond largestPicture. To be asked before anything is allocated.
void checkSize(uint64_t width, uint64_t height, uint64_t bytesHeld, uint64_t pixelsPerByte, const std::string& place);

/// True if `bytes` begins with `magic`.
bool startsWith(ByteSpan bytes, std::string_view magic);

}  // namespace raig::image
