#include "app/progress.hpp"

#include "base/log.hpp"

#include <fmt/format.h>
#include <sys/ioctl.h>
#include <unistd.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <string_view>

namespace raig {

namespace {

/// Seconds as a person reads them: "8 s", "3:05", "2:03:05".
std::string duration(double seconds) {
    const auto whole = static_cast<uint64_t>(std::ceil(std::clamp(seconds, 0.0, 1e9)));
    if (whole < 60) return fmt::format("{} s", whole);
    if (whole < 3600) return fmt::format("{}:{:02}", whole / 60, whole % 60);
    return fmt::format("{}:{:02}:{:02}", whole / 3600, whole / 60 % 60, whole % 60);
}

bool isTerminal() {
    const char* const terminal = std::getenv("TERM");
    return ::isatty(STDERR_FILENO) == 1 && terminal && std::string_view(terminal) != "dumb";
}

/// The terminal's width less one: a line that fills the last column makes some terminals scroll.
size_t columnsToDraw() {
    winsize size{};
    const bool known = ::ioctl(STDERR_FILENO, TIOCGWINSZ, &size) == 0 && size.ws_col > 0;
    return (known ? size.ws_col : 80u) - 1u;
}

}  // namespace

std::string progressLine(const std::string& label, double fractionDone, double raysDone, double seconds, size_t columns) {
    const double fraction = std::clamp(fractionDone, 0.0, 1.0);
    // Rounded down: 100 % means done.
    std::string text = fmt::format(" {:3} %", static_cast<int>(fraction * 100.0));
    if (seconds > 0.0 && raysDone > 0.0) text += fmt::format("  {:.2f} Mrays/s", raysDone / seconds * 1e-6);
    if (fraction > 0.0 && seconds > 0.0) text += fmt::format("  {} left", duration(seconds * (1.0 - fraction) / fraction));

    constexpr size_t shortestBar = 10, longestBar = 40, brackets = 3;
    std::string line = label;
    if (line.size() + text.size() + shortestBar + brackets <= columns) {
        const size_t cells = std::min(longestBar, columns - line.size() - text.size() - brackets);
        const auto full = static_cast<size_t>(fraction * static_cast<double>(cells));
        line += " [" + std::string(full, '#') + std::string(cells - full, '.') + ']';
    }
    return (line + text).substr(0, columns);
}

Progress::Progress(std::string name)
    : label(std::move(name)), enabled(!log::quiet() && isTerminal()), nextDraw(start + std::chrono::milliseconds(500)) {}

Progress::~Progress() {
    if (drawn) std::fputs("\r\x1b[K", stderr);
}

void Progress::update(double fractionDone, double raysDone) {
    const Clock::time_point now = Clock::now();
    if (!enabled || now < nextDraw) return;
    const double seconds = std::chrono::duration<double>(now - start).count();
    std::fprintf(stderr, "\r\x1b[K%s\r", progressLine(label, fractionDone, raysDone, seconds, columnsToDraw()).c_str());
    std::fflush(stderr);
    drawn = true;
    nextDraw = now + std::chrono::milliseconds(100);
}

}  // namespace raig
