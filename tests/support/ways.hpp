/// A picture by every way there is: the processor, the devices, and the reference in double precision.
#pragma once

#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <memory>

namespace raig::test {

/// "cpu", "reference", and devicesToTest().
std::vector<std::string> waysToTest();

/// A scene that is rendered by one of waysToTest().
class WayOfScene {
public:
    /// Requires a way that is there.
    WayOfScene(const std::string& way, const Scene& scene);
    ~WayOfScene();

    /// The radiance of each pixel, row by row. Of the reference, `options` have no crop and no lens.
    std::vector<dvec3> render(const FrameOptions& options);

private:
    struct State;
    std::unique_ptr<State> state_;
};

/// A test that runs by every way, and skips by name devices that are not there.
class ByEveryWay : public testing::TestWithParam<std::string> {
protected:
    void SetUp() override;

    /// The first pixel of the picture by camera `camera`, in a picture of one pixel and one sample.
    std::vector<dvec3> firstPixels(const Scene& scene, uint32_t maxDepth) const;
};

/// Mean and standard error of numbers that are independent of each other and equally distributed.
struct Sample {
    double mean = 0.0;
    double error = 0.0;
    size_t count = 0;
};
Sample sampleOf(const std::vector<double>& values);

/// Expects that the mean is `want` by Student's t-test, two-sided at p = 1e-4, and that it is known to `precision` of it: a
/// test that could not tell is none.
void expectMean(const Sample& sample, double want, double precision);

/// Expects the picture on the processor, side x side, two samples a pixel, followed to `depth`, to be the reference's to
/// 2e-4 and its discarded weight to 1e-4, in three of four pixels at least: those that rounding does not move.
void expectTheReferences(const Stage& stage, uint32_t side, uint32_t depth);

/// Expects pictures of the device to have the processor's bits: by `options`, by Whitted's integrator after them, then in
/// small tiles with the costs of pixels, and where samples are needed.
void expectTheCpusBits(Device& device, const Stage& stage, FrameOptions options);

}  // namespace raig::test
