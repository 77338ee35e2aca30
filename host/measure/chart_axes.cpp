#include "measure/chart_axes.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// 20, 0.05; from 10^5 on, and below 10^-3, powers of ten by their exponent.
std::string tic(double times, int power) {
    const double value = times * std::pow(10.0, power);
    if (times > 1.0 || (power > -4 && power < 5)) return fmt::format("{:.6g}", value);
    constexpr const char* digits[] = {"⁰", "¹", "²", "³", "⁴", "⁵", "⁶", "⁷", "⁸", "⁹"};
    std::string text = power < 0 ? "10⁻" : "10";
    for (const char digit : std::to_string(std::abs(power))) text += digits[digit - '0'];
    return text;
}

}  // namespace

LogAxis::LogAxis(const std::vector<double>& values) {
    double lo = INFINITY, hi = 0.0;
    for (const double value : values) {
        hasZero |= value == 0.0;
        if (value > 0.0) lo = std::min(lo, value), hi = std::max(hi, value);
    }
    if (hi == 0.0) lo = hi = 1.0;
    const double floor = std::pow(10.0, std::floor(std::log10(lo) + 1e-9));
    zero = floor / 10.0;
    least = hasZero ? zero / 3.0 : lo / 1.5;
    greatest = std::max(hi * 1.6, lo * 1.8);
}

std::string LogAxis::tics() const {
    const double from = hasZero ? border() : least, decades = std::log10(greatest / from);
    const bool isShort = decades <= 2.0;  // then 2 and 5 are written, too
    const int step = decades > 9.0 ? 3 : decades > 5.0 ? 2 : 1;
    std::string text = hasZero ? fmt::format("'0' {:.6g}", zero) : "";
    for (int power = static_cast<int>(std::floor(std::log10(from))); std::pow(10.0, power) <= greatest; power += step)
        for (const double times : {1.0, 2.0, 5.0}) {
            const double value = times * std::pow(10.0, power);
            if ((times > 1.0 && !isShort) || value < from || value > greatest) continue;
            text += fmt::format("{}'{}' {:.6g}", text.empty() ? "" : ", ", tic(times, power), value);
        }
    return text;
}

Axes::Axes(const Panel& panel) {
    std::vector<double> xs, ys;
    for (const Series& series : panel.series) {
        for (const Dot& dot : series.dots) {
            xs.push_back(dot.x);
            ys.push_back(dot.y);
            for (const auto& other : {dot.band, dot.theory})
                if (other) ys.push_back(*other);
        }
        ys.insert(ys.end(), series.levels.begin(), series.levels.end());
    }
    if (panel.drawing->logX) x.emplace(xs);
    if (panel.drawing->logY) y.emplace(ys);
}

std::string linearRange(const Panel& panel) {
    double lo = INFINITY, hi = -INFINITY;
    for (const Series& series : panel.series)
        for (const Dot& dot : series.dots) lo = std::min(lo, dot.x), hi = std::max(hi, dot.x);
    const double room = hi > lo ? 0.04 * (hi - lo) : std::max(0.1 * std::abs(hi), 0.1);
    const double from = lo > 0.0 && lo < 0.5 * hi ? 0.0 : lo - room;
    return fmt::format("set xrange [{:.9g}:{:.9g}]\n", from, hi + room);
}

}  // namespace raig
