/// The sRGB transfer function [IEC 61966-2-1:1999], for colours that files store encoded.
#pragma once

#include "base/vectors.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdint>

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

/// The same in double precision. Requires 0 <= encoded <= 1.
inline double linearFromSrgb(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// What bytes mean, sRGB if `encoded`, else linear: values[b] is the light of byte b, in [0, 1], and byteOf(light) the byte
/// that stands nearest to it as it is encoded. What lies outside is clamped.
struct ByteEncoding {
    explicit ByteEncoding(bool encoded) {
        for (size_t i = 0; i < 256; ++i) {
            values[i] = encoded ? linearFromSrgb(i / 255.0) : i / 255.0;
            const double middle = (i + 0.5 - 1e-6) / 255.0;  // so that a half, however it was rounded, goes upwards
            middles[i] = encoded ? linearFromSrgb(middle) : middle;
        }
    }
    uint8_t byteOf(double value) const {
        return static_cast<uint8_t>(std::upper_bound(middles.begin(), middles.end() - 1, value) - middles.begin());
    }
    std::array<double, 256> values{}, middles{};
};

}  // namespace raig
