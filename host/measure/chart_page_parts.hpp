/// What the page of charts is put together from.
#pragma once

#include "measure/chart_document.hpp"

#include <cstddef>
#include <span>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace raig::page {

/// The look of the page, after pageStyle; what `script` does to it is under the class "js" of <html>.
extern const char* const style;

/// Sliders, pickers and the sorting of tables; the page can be read without it.
extern const char* const script;

/// A number as a person reads it: "0", "1,234,567", "0.1235", "1.234e-5", four digits where it is not whole. "–" if it is
/// not finite.
std::string number(double value);

/// The same of a number of the document: "–" of null; text, escaped, of what is no number.
std::string value(const Json& value);

/// The member of that name; null if there is none, or `object` is none.
Json member(const Json& object, const std::string& name);

/// Text as it may stand in the page, with "10^6" and "K^(N+1)" as people write them.
std::string prose(const std::string& text);

/// How much there is of something: "1 figure", "2 figures".
std::string count(size_t many, std::string_view one);

/// data:TYPE;base64,...
std::string dataUri(std::string_view type, std::span<const std::byte> bytes);
std::string dataUri(std::string_view type, std::string_view bytes);

/// A link to a file beside the page: whatever is in its name, it leads nowhere else.
std::string fileLink(const std::string& name, const std::string& text);

/// Of a table.
struct Cell {
    explicit Cell(const Json& content, std::string mark = "") : content(content), mark(std::move(mark)) {}
    /// Empty text is shown as null is.
    explicit Cell(const std::string& text) : content(text.empty() ? Json() : Json(text)) {}

    Json content;      ///< a number, a text, or null
    std::string mark;  ///< a class
};

/// A table that sorts by each of its columns, in a box that scrolls. Columns with nothing but numbers stand to the right.
/// Requires rows as long as `columns`.
std::string table(const std::string& label, const std::vector<std::string>& columns,
                  const std::vector<std::vector<Cell>>& rows);

/// The settings that all points share, if there is more than one point.
Json heldOf(const std::vector<ChartPoint>& points);

/// Settings in words: "bvh, arity 4, walk links". What `without` has of them is left out.
std::string describe(const Json& settings, const Json& without = Json::object());

/// A breach as markup, with its scene if it is of one.
std::string describe(const Breach& breach);

/// The pictures of a scene: device against reference, and how they differ. `index` tells those of a page apart.
std::string pictures(const ChartPictures& pictures, size_t index);

/// A figure: its panels, what broke, what is missing, its table. `index` counts from 0.
std::string figure(const ChartFigure& figure, size_t index);

/// Whether any of its configurations could be measured: laws about none have not held.
bool hasMeasured(const ChartFigure& figure);

/// Where figure() is on the page: "#fig-grid-density".
std::string figurePlace(const ChartFigure& figure);

}  // namespace raig::page
