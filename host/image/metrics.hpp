/// How far two pictures are apart: in light, in codes, in structure, and to an eye.
#pragma once

#include "image/image.hpp"

#include <cstdint>
#include <span>
#include <vector>

namespace raig {

/// Pixels to leave out, one byte a pixel, 0: keep. Empty: keep all.
using PixelMask = std::span<const uint8_t>;

/// Differences of a picture from a reference, over the pixels compared. Of two equal pictures: 0, psnr infinite, ssim 1,
/// all exactly. A pixel with a NaN or infinite channel in either picture is counted in `nan` and left out, as are those
/// of the mask; to their neighbours (ssim, flip) they look the same in both pictures.
struct PictureDifference {
    uint64_t pixels = 0;  ///< compared; if 0, all below is as for equal pictures
    uint64_t nan = 0;     ///< left out, as a channel is not finite in either picture
    double max = 0.0;     ///< largest absolute difference of a channel, linear light
    double rmse = 0.0;    ///< root of the mean squared difference of the channels, linear light
    double relmse = 0.0;  ///< mean of (a - b)^2 / (b^2 + 0.01) over the channels, b the reference [Rousselle et al. 2011]
    double psnr = 0.0;  ///< dB: 10 log10(1 / mean squared difference) of sRGB values clamped to [0, 1], not rounded to bytes
    double ssim = 1.0;  ///< mean structural similarity of sRGB luma [Wang et al. 2004]
    double flipMean = 0.0;
    double flipP99 = 0.0;  ///< 99th percentile, nearest rank
    double flipMax = 0.0;
};

/// FLIP's viewing distance: 0.7 m from a screen 0.7 m and 3840 pixels wide, in pixels per degree (67.02).
inline constexpr double defaultPixelsPerDegree = 0.7 * 3840 / 0.7 * 3.14159265358979323846 / 180.0;

/// All of the above, in double precision. Sums are taken row by row in order: the same bits on any number of threads.
///
/// ssim: windows of 11 x 11, Gaussian of 1.5 pixels, K1 0.01, K2 0.03, over windows wholly inside the picture; of a picture
/// narrower than 11 pixels, over all windows, its border repeated.
///
/// Requires `leaveOut` empty or one byte a pixel. Throws inputError if the sizes differ. Cost O(pixels): 0.35 s of one
/// core for 512 x 512, most of it FLIP.
PictureDifference comparePictures(const Image& test, const Image& reference, PixelMask leaveOut = {},
                                  double pixelsPerDegree = defaultPixelsPerDegree);

/// FLIP of every pixel, in [0, 1]; NaN where a pixel is left out [Andersson et al. 2020, "FLIP: A Difference Evaluator for
/// Alternating Images"]. The pictures are clamped to [0, 1] (the low dynamic range variant); the filters see the border
/// repeated. Symmetric in its pictures. Requirements and errors as comparePictures.
std::vector<double> flipValues(const Image& test, const Image& reference, PixelMask leaveOut = {},
                               double pixelsPerDegree = defaultPixelsPerDegree);

/// The largest absolute difference of a pixel's channels in linear light; NaN where it is left out.
std::vector<double> absoluteDifference(const Image& test, const Image& reference, PixelMask leaveOut = {});

/// The magma colour map, dark (0) to light (1) with evenly growing lightness; linear RGB. Values are clamped; NaN is green.
vec3 magma(double value);

/// `values` divided by `top` in magma. Requires width * height values and top > 0.
Image falseColour(std::span<const double> values, uint32_t width, uint32_t height, double top = 1.0);

}  // namespace raig
