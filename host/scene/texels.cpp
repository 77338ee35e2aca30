#include "scene/import.hpp"

#include "base/error.hpp"

#include <climits>
#include <memory>

// Kept to this file, so that it cannot clash with another copy in the program.
#define STB_IMAGE_STATIC
#define STB_IMAGE_IMPLEMENTATION
#define STBI_ONLY_PNG
#define STBI_ONLY_JPEG
#define STBI_ONLY_BMP
#define STBI_ONLY_TGA
#define STBI_NO_STDIO
#define STBI_MAX_DIMENSIONS 16384
#pragma GCC diagnostic push
#pragma GCC diagnostic ignored "-Wunused-function"
#pragma GCC diagnostic ignored "-Wmissing-field-initializers"
#include <stb/stb_image.h>
#pragma GCC diagnostic pop

namespace raig {

Texels decodeImage(std::span<const std::byte> bytes, const std::string& place) {
    if (bytes.size() > INT_MAX) throw limitError("{}: an image of {} bytes is too large to decode", place, bytes.size());
    const auto* data = reinterpret_cast<const stbi_uc*>(bytes.data());
    const int size = static_cast<int>(bytes.size());
    int width = 0, height = 0, channels = 0;
    if (size == 0 || !stbi_info_from_memory(data, size, &width, &height, &channels)) {
        const char* reason = size == 0 ? "it is empty" : stbi_failure_reason();
        throw inputError(place, "the image cannot be decoded (PNG, JPEG, BMP and TGA can): {}",
                         reason ? reason : "unknown reason");
    }
    if (width > STBI_MAX_DIMENSIONS || height > STBI_MAX_DIMENSIONS)
        throw limitError("{}: the image has {} x {} texels; at most {} x {} are read", place, width, height,
                         STBI_MAX_DIMENSIONS, STBI_MAX_DIMENSIONS);
    const std::unique_ptr<stbi_uc, void (*)(void*)> decoded(stbi_load_from_memory(data, size, &width, &height, &channels, 4),
                                                            stbi_image_free);
    if (!decoded) {
        const char* reason = stbi_failure_reason();
        throw inputError(place, "the image cannot be decoded: {}", reason ? reason : "unknown reason");
    }
    Texels texels{static_cast<uint32_t>(width), static_cast<uint32_t>(height), {}};
    texels.rgba.assign(decoded.get(), decoded.get() + size_t{texels.width} * texels.height * 4);
    return texels;
}

}  // namespace raig
