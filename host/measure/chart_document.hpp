/// What a run of `raig chart` found: the data of its page.
#pragma once

#include "measure/sweep.hpp"

#include <cstddef>
#include <cstdint>
#include <string>
#include <vector>

namespace raig {

/// One configuration, measured.
struct ChartPoint {
    std::string scene;
    Json settings = Json::object();  ///< name -> number or text
    Json measures = Json::object();  ///< name -> number; null where it is not finite
    std::string leftOut;             ///< why it could not be measured; empty: it was
};

/// A panel of a figure, drawn.
struct ChartPanel {
    std::string title;
    std::string stem;         ///< of its files: STEM.svg and STEM.png in the chart's folder
    std::string light, dark;  ///< SVG documents, for light and for dark surroundings
    std::string description;  ///< in words, for who does not see it
};

/// A measured point, or a series, outside its theoretical band.
struct Breach {
    std::string sweep, scene, text;
};

struct ChartFigure {
    Sweep sweep;
    std::vector<ChartPoint> points;
    std::vector<ChartPanel> panels;
    std::vector<Breach> breaches;
};

/// Pictures of a scene, as PNG files.
struct ChartPictures {
    std::string scene;
    uint32_t width = 0, height = 0;
    std::vector<std::byte> device, reference, difference;  ///< the last: FLIP in false colour
    Json numbers = Json::object();  ///< rmse, flip_mean, flip_p99, nan, missed, phantom, wrong, device_s, reference_s
};

struct ChartDocument {
    std::string version, commit, processor, device, driver, arithmetic, flags, command;
    size_t threads = 0;
    uint32_t seed = 0;
    double seconds = 0.0;
    std::vector<ChartPictures> pictures;
    std::vector<ChartFigure> figures;

    std::vector<Breach> breaches() const;
};

/// One page that opens from disk and loads nothing: what failed, pictures with a slider, figures with their tables, and how
/// all was measured. Only the slider and the sorting of tables need JavaScript; for dark and light, narrow and wide screens.
std::string chartPage(const ChartDocument& document);

}  // namespace raig
