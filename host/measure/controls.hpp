/// Controls: textbook methods that must fail on the hard cases. Where one does not, the cases ask nothing, or whoever counts
/// failures does not see them: the instrument is broken.
#pragma once

#include "measure/hard_cases.hpp"

#include <functional>
#include <optional>
#include <string>
#include <vector>

namespace raig {

/// How often a method failed, of the rays for which it counts.
struct ControlFindings {
    uint64_t rays = 0;
    uint64_t missed = 0;   ///< no hit where there is one, or a box, cell or wall on the way that is left out
    uint64_t phantom = 0;  ///< a hit that is nowhere near its triangle
    uint64_t wrong = 0;    ///< another triangle than the nearest
    uint64_t hung = 0;     ///< does not end
    /// Where it is not counted how often, but measured by how much it errs: that, in the control's unit.
    std::optional<double> measured = {};

    uint64_t failures() const { return missed + phantom + wrong + hung; }
    double percent() const { return rays == 0 ? 0.0 : 100.0 * double(failures()) / double(rays); }
    double rate() const { return measured ? *measured : percent(); }
};

struct Control {
    uint32_t number;  ///< of the case
    std::string method;
    /// In its unit: how often it fails, by the catalogue; where that gives no rate, as measured with twelve seeds, or both
    /// 0.
    double low, high;
    std::function<ControlFindings(const hard::Draw&)> run;
    uint32_t draws = 1;  ///< of the case: more where failures are rare, or differ from scene to scene
    /// The catalogue's rate is the highest there is: the draw where it fails most often counts, not all together.
    bool worst = false;
    const char* unit = "%";  ///< percent of the rays, unless it is measured by how much the method errs

    bool hasRate() const { return high > 0.0; }
    /// True if it fails as often as that, to a factor of two; where there is no rate, if it fails at all.
    bool failsAsItShould(const ControlFindings& findings) const;
};

/// By the number of the case.
std::vector<Control> allControls();

struct ControlResult {
    Control control;
    ControlFindings findings;
    bool fails = false;  ///< as it should
};

/// Runs it with the rays of its draws; those of the first are what the seed draws for a short run.
ControlResult runControl(const Control& control, uint32_t seed);

}  // namespace raig
