/// What a run of the hard cases found, and the page that shows it.
#pragma once

#include "measure/controls.hpp"
#include "measure/stress.hpp"

#include <optional>
#include <string>
#include <vector>

namespace raig {

struct StressDevice {
    std::string name;        ///< with its index, where others have the same
    std::string driver;      ///< and version; empty: the CPU path
    std::string arithmetic;  ///< as measured, in words
    std::string argument;    ///< what --device takes for it: its index, or cpu
    std::optional<Error> stopped;  ///< why not all cases were run on it
};

/// A whole run.
struct StressDocument {
    std::string version, commit, processor;
    size_t threads = 0;
    std::string command;  ///< that does the same again, without where results are written and by how many threads
    std::string replay;   ///< how one ray is called up again, up to the device and the numbers of the case and the ray
    uint32_t seed = 0;
    double seconds = 0.0;
    std::vector<StressDevice> devices;
    std::vector<hard::Case> cases;
    std::vector<StressResult> results;
    std::vector<ControlResult> controls;
    std::vector<hard::NotRun> notRun;

    uint64_t forbidden() const;
    size_t brokenControls() const;
    size_t stoppedDevices() const;
    /// An answer that must not be, a device where not all were run, or a control that does not fail: whoever runs this in a
    /// script must notice.
    bool fellShort() const { return forbidden() > 0 || brokenControls() > 0 || stoppedDevices() > 0; }
    uint64_t rays() const;  ///< answers, by all structures on all devices
    /// The command that shows a ray of a result again; of pixels, that runs their case again.
    std::string replayOf(const StressResult& result, uint64_t ray) const;
};

/// "50", "74 to 88", or "any" where there is no rate.
std::string expectedRate(const Control& control);

/// "2 missed, 1 hung". Empty if nothing is wrong.
std::string describeFaults(const StressResult& result);

/// The same with an example: "2 missed; ray 17 of scene "edges" (missed): ...; see: COMMAND". Empty if nothing is wrong.
std::string describeFailure(const StressDocument& document, const StressResult& result);

/// What is wrong with a control that does not fail as it should. Empty if it does.
std::string describeFailure(const ControlResult& result);

/// One self-contained page: nothing is loaded, no script runs; for dark and light, and for narrow screens.
std::string stressPage(const StressDocument& document);

}  // namespace raig
