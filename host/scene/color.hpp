/// The sRGB transfer function [IEC 61966-2-1:1999], for colours that files store encoded.
#pragma once

#include "base/vectors.hpp"

#include <cmath>

namespace raig {

/// An sRGB-encoded component in [0, 1] as linear light. What lies outside is clamped; NaN gives 0.
inline float linearFromSrgb(float encoded) {
    if (!(encoded > 0.0f)) return 0.0f;
    if (encoded >= 1.0f) return 1.0f;
    return encoded <= 0.04045f ? encoded / 12.92f : std::pow((encoded + 0.055f) / 1.055f, 2.4f);
}

inline vec3 linearFromSrgb(const vec3& encoded) {
    return {linearFromSrgb(encoded.x), linearFromSrgb(encoded.y), linearFromSrgb(encoded.z)};
}

}  // namespace raig
