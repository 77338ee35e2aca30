/// Pictures made in passes: with samples where they are needed, or as many as go into a time.
///
/// With a tolerance, pixels have as many samples as their error asks for. All get 8. Then, pass after pass, those whose
/// error is still above the tolerance get as many again as they have, up to FrameOptions::samples; a pixel that was once
/// left is left for good. The error of a pixel's mean is estimated by two terms, whose squares are added:
///
/// 1. What the last doubling has changed the mean by: that is half the difference of two halves which are stratified each,
///    so it sees how fast stratified samples converge, which their variance does not. One such difference is a rough guess,
///    so its square is averaged over 3 x 3 pixels with weights 4, 2 and 1: noise and edges go on in the neighbours.
/// 2. What all samples have missed: of an edge of contrast c, somewhere between a pixel and its neighbour, less than one of
///    n strata may be in the pixel. That has a probability of 1/n, and is then wrong by up to c/n, evenly; so the mean
///    square is c^2 / (3 n^3), for the neighbour of greatest contrast.
///
/// Errors are root mean squares over the three channels in linear light, whatever the exposure. To drive all pixels to the
/// same error is what makes the picture's the least for the rays it takes. As a pixel stops when its samples happen to
/// agree, its mean is not quite free of bias. Of a thin line, which takes half of the weights of 3 x 3 pixels, the error may
/// be the tolerance times the square root of 2.
///
/// Source: Whitted 1980, "An Improved Illumination Model for Shaded Display" (more samples where corners of a pixel differ);
/// Lee, Redner and Uselton 1985, "Statistically Optimized Sampling for Distributed Ray Tracing" (until the error's estimate
/// is below a tolerance).
///
/// With a deadline, pass after pass doubles the samples of all pixels, or of those whose error is above the tolerance. How
/// long a pass takes is foreseen from the last one; if it does not go into the time that is left it is cut to what does.
#pragma once

#include "base/vectors.hpp"
#include "rays/frame.hpp"

#include <span>
#include <vector>

namespace raig {

class FramePasses;

/// Of each pixel, before its error is estimated.
constexpr uint32_t firstSamples = 8;

/// What is known of the errors in a picture's pixels.
class PixelErrors {
public:
    PixelErrors(uint32_t width, uint32_t height);

    /// The pixel at `place` had mean `before` of `from` samples, and has `after` of `to`, which are more.
    void learn(size_t place, const vec3& before, uint32_t from, const vec3& after, uint32_t to);

    /// The mean square of the error of the pixel at `place`, as estimated. What is not finite counts for nothing.
    double meanSquare(size_t place) const;

    /// Those of `places` whose error exceeds `tolerance`, in their order. Cost O(places), over all cores.
    std::vector<uint32_t> above(double tolerance, std::span<const uint32_t> places) const;

private:
    uint32_t width_, height_;
    std::vector<vec3> means_;
    std::vector<float> changes_;  ///< mean squares of what the last samples changed, as if they had been a doubling
    std::vector<uint32_t> samples_;
};

/// `options`, with a part that reaches as far around the one that is wanted as pixels can have a say in its pixels' samples:
/// one pixel a pass. So a part has the bits of the whole. Without a tolerance, or a part: as they are.
FrameOptions withMargin(const FrameOptions& options);

/// Makes all passes over the part with its margin, and of that the picture that is wanted: means, and with a tolerance
/// picture.samples. Requires options.tolerance == 0 or options.samples >= firstSamples.
void renderInPasses(FramePasses& passes, const FrameOptions& options, Picture& picture);

}  // namespace raig
