/// Two pictures made ready for comparing: sizes checked, pixels left out made equal.
#pragma once

#include "image/metrics.hpp"

namespace raig::image {

struct Pair {
    Image test;
    Image reference;
    std::vector<uint8_t> kept;  ///< one a pixel: 1 if it is compared
    uint64_t nan = 0;           ///< pixels not finite in either
};

/// Copies both, so that a pixel left out is the same in both: the reference's, or the test's where that is not finite, or
/// black where neither is. Throws inputError if the sizes differ.
Pair prepare(const Image& test, const Image& reference, PixelMask leaveOut);

/// FLIP of every pixel of a prepared pair, left out ones too.
std::vector<double> flip(const Pair& pair, double pixelsPerDegree);

}  // namespace raig::image
