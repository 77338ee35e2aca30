/// A progress bar for a person at a terminal.
#pragma once

#include <chrono>
#include <functional>
#include <string>

namespace raig {

/// Told by the renderer from time to time, from one thread at a time: the share of the work done, in [0, 1], and the rays
/// traced so far.
using ProgressCallback = std::function<void(double fractionDone, double raysDone)>;

/// One line of at most `columns` characters: label, bar, percentage, rate in Mrays/s, time left. What does not fit is left
/// out, the bar first. `seconds` is the time since the start.
std::string progressLine(const std::string& label, double fractionDone, double raysDone, double seconds, size_t columns);

/// Draws on standard error if that is a terminal and --quiet is not set; else does nothing. At most 10 updates a second,
/// none in the first half second. The line is erased when the object ends, so nothing of it stays.
class Progress {
public:
    explicit Progress(std::string label);
    ~Progress();
    Progress(const Progress&) = delete;
    Progress& operator=(const Progress&) = delete;

    void update(double fractionDone, double raysDone);
    /// The same of work without rays, which is at `step` now.
    void update(const std::string& step, double fractionDone) {
        label = step;
        update(fractionDone, 0.0);
    }
    ProgressCallback callback() {
        return [this](double fractionDone, double raysDone) { update(fractionDone, raysDone); };
    }

private:
    using Clock = std::chrono::steady_clock;
    std::string label;
    bool enabled;
    bool drawn = false;
    Clock::time_point start = Clock::now();
    Clock::time_point nextDraw;
};

}  // namespace raig
