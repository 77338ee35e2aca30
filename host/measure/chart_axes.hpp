/// The axes of a panel: where values lie on them, and what is written at them.
#pragma once

#include "measure/chart_panels.hpp"

#include <optional>
#include <string>
#include <vector>

namespace raig {

/// A logarithmic axis: its decades, and below them, apart, a place for exactly 0.
struct LogAxis {
    double least = 0.1, greatest = 1.0, zero = 0.0;
    bool hasZero = false;

    /// Of values that are not negative.
    explicit LogAxis(const std::vector<double>& values);
    double place(double value) const { return value == 0.0 ? zero : value; }
    /// Where 0 ends and the decades begin.
    double border() const { return zero * 3.0; }
    /// As gnuplot takes them: 'text' place, ...
    std::string tics() const;
};

/// Both axes of a panel; those that are not logarithmic are gnuplot's own.
struct Axes {
    std::optional<LogAxis> x, y;
    explicit Axes(const Panel& panel);
    double atX(double value) const { return x ? x->place(value) : value; }
    double atY(double value) const { return y ? y->place(value) : value; }
};

/// The range of an x that is not logarithmic, with room for the dots at its ends; from 0 where that is near.
std::string linearRange(const Panel& panel);

}  // namespace raig
