/// Charts as declarations: what varies, what is held, what is measured, how it is drawn, and what must hold.
///
/// A declaration is a JSON object. In `settings`, an array varies and a scalar is held; several objects are taken one after
/// the other:
///
///     {"name": "grid-density", "title": "Uniform grids", "task": "trace", "scenes": ["given"],
///      "settings": [{"accel": "grid", "levels": [1, 2], "grid-density": [0.5, 1, 2, 4]}, {"accel": "bvh"}],
///      "draw": [{"x": "grid-density", "y": "milliseconds", "by": ["levels"], "style": "lines", "log": "xy"}],
///      "holds": [{"measure": "differing", "most": 0, "because": "a structure changes the cost, never the answer"}]}
///
/// The figures that raig draws of itself are declared so, too: host/measure/figures.json.
#pragma once

#include <nlohmann/json.hpp>

#include <optional>
#include <string>
#include <vector>

namespace raig {

using Json = nlohmann::ordered_json;

/// One picture a panel: y over x, a series for each combination of the values named in `by`.
struct Drawing {
    enum class Style {
        points,  ///< one dot a configuration
        lines,   ///< the dots of a series joined by x; what has no x is a level line
        heat,    ///< y as colour over x and the first of `by`, with the contours of `contour`
    };
    std::string title;
    std::string x, y;                 ///< settings or measures
    std::vector<std::string> by;      ///< settings whose values tell series apart; empty: "label"
    std::vector<std::string> panels;  ///< settings (or "scene") with a panel for each of their values
    Style style = Style::points;
    bool logX = false, logY = false;  ///< a logarithmic axis has a band of its own for exactly 0
    bool pareto = false;              ///< the front of what nothing is both cheaper and more accurate than is marked
    std::string band;                 ///< a measure under which y must lie: a band
    std::string theory;               ///< a measure drawn as a line: what y should be
    std::string contour;              ///< heat: a measure whose contours are drawn
    std::string hollow;               ///< a measure: where it is above 0 in any panel, the method's dots are hollow in all
    double guide = 0.0;               ///< the slope of a guide line on logarithmic axes; 0: none
};

/// What theory says of measured points. Where it does not hold, the chart says so, and raig exits with 1.
struct Law {
    enum class Kind {
        most,    ///< measure <= bound + plus
        equals,  ///< |measure - bound| <= within * |bound| + plus
        slope,   ///< the least-squares slope of log measure over log `over`, a series, lies in [least, greatest]
    };
    Kind kind = Kind::most;
    std::string measure;
    std::string over;                 ///< slope
    std::optional<double> bound;      ///< a number,
    std::string boundMeasure;         ///< or another measure
    double within = 0.0, plus = 0.0;  ///< rounding, and what else theory leaves open
    double least = 0.0, greatest = 0.0;
    Json where = Json::object();  ///< settings that points must have for it to be about them
    std::string because;
};

/// What the figure asks for that raig cannot do: named, never drawn.
struct Missing {
    std::string what, why;
};

struct Sweep {
    std::string name;  ///< of its files: lower-case letters, digits, hyphens
    std::string title;
    std::string text;                   ///< what to see in it
    std::string task;                   ///< what is run for a point: see tasks.hpp
    std::vector<std::string> scenes;    ///< "given": all of the command line; "first"; "mirroring": those with mirrors or
                                        ///< glass among them; or the name of one that is made here
    std::vector<Json> settings;         ///< the points of a scene: objects of scalars, expanded
    std::vector<std::string> measures;  ///< columns of its table
    std::vector<Drawing> drawings;
    std::vector<Law> laws;
    std::vector<Missing> missing;
};

/// Reads a document: one declaration, an array of them, or {"sweeps": [...]}. Checks keys and kinds of values; what settings
/// and measures there are, the task knows. At most 10,000 points a scene. Throws inputError with `place` and a JSON
/// pointer.
std::vector<Sweep> readSweeps(const std::string& text, const std::string& place);

/// The text of host/measure/figures.json.
std::string_view builtInSweeps();

}  // namespace raig
