/// The sRGB transfer function [IEC 61966-2-1:1999], in double precision.
#pragma once

#include <cmath>

namespace raig::srgb {

/// Linear light of an encoded value; both in [0, 1].
inline double toLinear(double encoded) {
    return encoded <= 0.04045 ? encoded / 12.92 : std::pow((encoded + 0.055) / 1.055, 2.4);
}

/// The encoded value of linear light; both in [0, 1].
inline double toEncoded(double linear) {
    return linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1.0 / 2.4) - 0.055;
}

/// Relative luminance (or, of encoded values, luma) of sRGB's primaries [ITU-R BT.709].
inline constexpr double redWeight = 0.2126, greenWeight = 0.7152, blueWeight = 0.0722;

}  // namespace raig::srgb
