/// Pictures to try things on.
#pragma once

#include "image/image.hpp"

#include <random>

namespace raig::test {

/// Every channel uniform in [0, scale); the same for the same seed.
inline Image noise(uint32_t width, uint32_t height, unsigned seed, float scale = 1.0f) {
    std::mt19937 random(seed);
    Image image(width, height);
    for (vec3& c : image.pixels)
        for (int k = 0; k < 3; ++k) c[k] = scale * static_cast<float>(random() >> 8) / 16777216.0f;
    return image;
}

}  // namespace raig::test
