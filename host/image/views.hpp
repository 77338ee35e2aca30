/// Pictures of what is no light: numbers, ids and directions in false colours, as a screen is to show them.
#pragma once

#include "image/image.hpp"

namespace raig {

/// Numbers in magma (image/metrics.hpp), from the least to the greatest, evenly.
struct NumberView {
    Image image;
    double low = 0.0, high = 0.0;  ///< what is finite lies between; both 0 where nothing is
};

/// What is not finite is grey; where all numbers are equal they have the middle colour. From 64 x 48 pixels on a legend
/// takes the lowest rows: the map from left to right, with the least and the greatest number written in it, to four digits.
/// Requires width * height values. Cost O(pixels).
NumberView viewNumbers(std::span<const double> values, uint32_t width, uint32_t height);

/// A colour an id, the same in every picture, by its hash: neighbouring ids look different. 0xffffffff, which is none, is
/// black, and no other is dark.
vec3 colourOfId(uint32_t id);

/// The linear colour that a screen shows as `shown`, 0 to 1 a channel (clamped; NaN as 0): what is encoded as a PNG comes
/// out as these numbers.
vec3 shownAs(const vec3& shown);

}  // namespace raig
