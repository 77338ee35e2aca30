/// Speed against accuracy: sweeps measured point by point, drawn, checked against theory, and told on one page.
#pragma once

#include "device/device.hpp"
#include "measure/chart_document.hpp"

#include <filesystem>
#include <functional>

namespace raig {

struct ChartSettings {
    std::vector<std::filesystem::path> scenes;
    std::filesystem::path folder;  ///< it must exist
    std::vector<Sweep> sweeps;
    Device* device = nullptr;  ///< none: the CPU path
    uint32_t seed = 0;
    std::string identity;  ///< what measured points depend on beside their settings: points of another are not taken up
    uint32_t pictureSide = 320;  ///< of the pictures on the page; 0: none
};

/// Told before each point: what is at hand, and the share done.
using ChartProgress = std::function<void(const std::string&, double)>;

/// Measures what points.jsonl in the folder does not hold yet, appending to it point by point; then draws all panels, and
/// writes NAME.csv and NAME.json for each sweep, with `figures`, `pictures` of the document filled in.
///
/// Throws usageError or inputError for a sweep that asks for what does not exist, before anything is measured; what
/// importing scenes, devices and gnuplot throw. A point that reaches a limit is left out, and says why.
void runChart(const ChartSettings& settings, ChartDocument& document, const ChartProgress& progress);

/// The points of a figure as a table: settings, then measures, a column each.
std::string toCsv(const ChartFigure& figure);
Json toJson(const ChartFigure& figure);

}  // namespace raig
