/// The panels of a figure: which points belong to which, in which series, and gnuplot's scripts that draw them.
#pragma once

#include "measure/chart_document.hpp"

#include <filesystem>

namespace raig {

/// One dot.
struct Dot {
    double x = 0.0, y = 0.0;
    std::optional<double> band, theory, contour, second;  ///< second: heat, the other axis
    bool hollow = false;
};

struct Series {
    std::string label;
    std::vector<Dot> dots;       ///< by x
    std::vector<double> levels;  ///< y of points without x: level lines
};

struct Panel {
    std::string title, stem;
    const Drawing* drawing = nullptr;
    std::string xLabel, yLabel, contourLabel, secondLabel;
    std::vector<Series> series;
    size_t dots() const;
};

/// Cuts a figure into panels, in the order of its points. `labels`: the task's measures in words. `prefix` begins the names
/// of files. Panels without a dot are left out.
std::vector<Panel> panelsOf(const ChartFigure& figure, const Json& labels, const std::string& prefix);

/// The dots that no other is at least as good as on both axes, and better on one; by x. Requires what is less to be better.
std::vector<Dot> paretoFront(const Panel& panel);

/// The script that draws a panel into `folder`: STEM.svg, STEM.dark.svg and STEM.png. Requires names that gnuplotText takes.
std::string scriptOf(const Panel& panel, const std::filesystem::path& folder);

/// What the panel shows, in words.
std::string describePanel(const Panel& panel);

/// Draws all panels by one run of gnuplot, and reads them back. Throws inputError.
std::vector<ChartPanel> drawPanels(const std::vector<Panel>& panels, const std::filesystem::path& folder);

}  // namespace raig
