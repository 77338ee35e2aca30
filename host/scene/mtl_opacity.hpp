/// Opacity by a picture of its own, made the alpha of a colour picture. Internal to the OBJ importer.
#pragma once

#include "scene/scene.hpp"

namespace raig {

/// How opaque a surface is, row by row from the top: 0 not at all, 255 wholly.
struct Opacity {
    uint32_t width = 0;
    uint32_t height = 0;
    std::vector<uint8_t> values;

    bool isOpaque() const;
};

/// True if any texel's alpha is less than 255.
bool hasAlpha(const Texels& picture);

/// A channel of a picture, as -imfchan names it: r, g, b, m (alpha), l (the luminance of the bytes as they are).
Opacity opacityOf(const Texels& picture, char channel);

/// The size that withOpacity gives: of each side the longer one.
uvec2 mergedSize(const Texels* color, const uvec2& opacity);

/// The colours of `color`, white where it is null, with that alpha. What is smaller than the merged size is resampled to it,
/// linearly between texel centres, colours in linear light; what is not keeps its bytes. Cost O(texels of the merged size).
Texels withOpacity(const Texels* color, const Opacity& opacity);

}  // namespace raig
