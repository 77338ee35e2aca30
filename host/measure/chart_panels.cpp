#include "measure/chart_panels.hpp"

#include "measure/chart_points.hpp"

#include <algorithm>
#include <cmath>
#include <set>

namespace raig {

namespace {

std::string wordsFor(const Json& labels, const std::string& name) {
    return labels.contains(name) ? labels[name].get<std::string>() : name;
}

/// "levels 2"; of a text, and of what is called a label, the text alone.
std::string seriesLabel(const ChartPoint& point, const Drawing& drawing) {
    std::string label;
    for (const std::string& name : drawing.by) {
        const std::string value = nameOf(point, name);
        if (value.empty()) continue;
        const bool isText = name == "scene" || !valueOf(point, name);
        label += fmt::format("{}{}", label.empty() ? "" : ", ", isText ? value : name + " " + value);
    }
    const std::string own = nameOf(point, "label");
    if (!own.empty()) return own;
    return label.empty() ? nameOf(point, "accel") : label;
}

std::string panelTitle(const ChartPoint& point, const Drawing& drawing) {
    std::string title;
    for (const std::string& name : drawing.panels) {
        const std::string value = nameOf(point, name);
        if (value.empty() || (name == "offset" && value == "0")) continue;
        title += (title.empty() ? "" : ", ") + (name == "scene" ? value : name + " " + value);
    }
    return title;
}

/// Lower-case letters, digits and hyphens.
std::string plain(const std::string& text) {
    std::string name;
    for (const char c : text) {
        const bool isLetter = (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || (c >= 'A' && c <= 'Z');
        if (isLetter || c == '_')
            name += static_cast<char>(c >= 'A' && c <= 'Z' ? c - 'A' + 'a' : c);
        else if (!name.empty() && name.back() != '-')
            name += '-';
    }
    while (!name.empty() && name.back() == '-') name.pop_back();
    return name;
}

bool isDrawable(double value, bool isLog) {
    return std::isfinite(value) && (!isLog || value >= 0.0);
}

void add(Panel& panel, const ChartPoint& point, bool hollow) {
    const Drawing& drawing = *panel.drawing;
    const auto x = valueOf(point, drawing.x), y = valueOf(point, drawing.y);
    if (!y || !isDrawable(*y, drawing.logY) || (x && !isDrawable(*x, drawing.logX))) return;
    const bool isHeat = drawing.style == Drawing::Style::heat;
    const std::string label = isHeat ? "" : seriesLabel(point, drawing);
    auto series = std::find_if(panel.series.begin(), panel.series.end(), [&](const Series& s) { return s.label == label; });
    if (series == panel.series.end()) series = panel.series.insert(series, Series{label, {}, {}});
    if (!x) {
        if (!isHeat) series->levels.push_back(*y);
        return;
    }
    const auto optional = [&](const std::string& name) { return name.empty() ? std::nullopt : valueOf(point, name); };
    const std::optional<double> second = isHeat ? valueOf(point, drawing.by[0]) : std::nullopt;
    if (isHeat && !second) return;
    series->dots.push_back(
        {*x, *y, optional(drawing.band), optional(drawing.theory), optional(drawing.contour), second, hollow});
}

/// Labels of series with a dot somewhere that fails, in any panel.
std::set<std::string> failingLabels(const ChartFigure& figure, const Drawing& drawing) {
    std::set<std::string> labels;
    for (const ChartPoint& point : figure.points)
        if (const auto value = valueOf(point, drawing.hollow); value && *value > 0.0)
            labels.insert(seriesLabel(point, drawing));
    return labels;
}

std::vector<Panel> panelsOf(const ChartFigure& figure, const Drawing& drawing, const Json& labels,
                            const std::string& prefix) {
    std::vector<Panel> panels;
    const std::set<std::string> failing = failingLabels(figure, drawing);
    for (const ChartPoint& point : figure.points) {
        if (!point.leftOut.empty()) continue;
        const std::string own = panelTitle(point, drawing);
        const std::string title = drawing.title + (drawing.title.empty() || own.empty() ? "" : ": ") + own;
        auto panel = std::find_if(panels.begin(), panels.end(), [&](const Panel& p) { return p.title == title; });
        if (panel == panels.end())
            panel = panels.insert(panel, Panel{title,
                                               prefix + plain(own),
                                               &drawing,
                                               wordsFor(labels, drawing.x),
                                               wordsFor(labels, drawing.y),
                                               wordsFor(labels, drawing.contour),
                                               drawing.by.empty() ? "" : wordsFor(labels, drawing.by[0]),
                                               {}});
        add(*panel, point, failing.count(seriesLabel(point, drawing)) > 0);
    }
    for (Panel& panel : panels)
        for (Series& series : panel.series)
            std::stable_sort(series.dots.begin(), series.dots.end(), [](const Dot& a, const Dot& b) { return a.x < b.x; });
    std::erase_if(panels, [](const Panel& panel) { return panel.dots() == 0; });
    return panels;
}

}  // namespace

size_t Panel::dots() const {
    size_t count = 0;
    for (const Series& one : series) count += one.dots.size();
    return count;
}

std::vector<Panel> panelsOf(const ChartFigure& figure, const Json& labels, const std::string& prefix) {
    std::vector<Panel> all;
    std::set<std::string> stems;
    char letter = 'a';
    for (const Drawing& drawing : figure.sweep.drawings) {
        const bool several = figure.sweep.drawings.size() > 1;
        const std::string start =
            fmt::format("{}-{}{}", prefix, figure.sweep.name, several ? fmt::format("-{}", letter++) : "");
        for (Panel& panel : panelsOf(figure, drawing, labels, start + "-")) {
            while (!panel.stem.empty() && panel.stem.back() == '-') panel.stem.pop_back();
            std::string stem = panel.stem;
            for (int number = 2; !stems.insert(stem).second; ++number) stem = fmt::format("{}-{}", panel.stem, number);
            panel.stem = stem;
            all.push_back(std::move(panel));
        }
    }
    return all;
}

std::vector<Dot> paretoFront(const Panel& panel) {
    std::vector<Dot> dots;
    for (const Series& series : panel.series) dots.insert(dots.end(), series.dots.begin(), series.dots.end());
    std::sort(dots.begin(), dots.end(),
              [](const Dot& a, const Dot& b) { return std::pair(a.x, a.y) < std::pair(b.x, b.y); });
    std::vector<Dot> front;
    for (const Dot& dot : dots)
        if (front.empty() || dot.y < front.back().y) front.push_back(dot);
    return front;
}

std::string describePanel(const Panel& panel) {
    std::string names;
    for (const Series& series : panel.series)
        if (!series.label.empty()) names += (names.empty() ? "" : ", ") + series.label;
    const std::string heat = panel.drawing->style == Drawing::Style::heat ? " and " + panel.secondLabel : "";
    return fmt::format("{}: {} over {}{}, {} points{}", panel.title.empty() ? "Chart" : panel.title, panel.yLabel,
                       panel.xLabel, heat, panel.dots(), names.empty() ? "" : " of " + names);
}

}  // namespace raig
