#include "base/error.hpp"
#include "base/files.hpp"
#include "measure/chart_axes.hpp"
#include "measure/gnuplot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <map>
#include <set>

namespace raig {

namespace {

/// Colours that eyes of all kinds tell apart [Okabe, Ito 2008], and lighter ones for a dark page.
struct Theme {
    const char *ink, *soft, *grid, *band;
    std::array<const char*, 8> colours;
};
constexpr Theme light = {"#1c2024",
                         "#60656b",
                         "#d8dce0",
                         "#eceff2",
                         {"#0072b2", "#d55e00", "#009e73", "#aa4499", "#b8860b", "#2a9fd6", "#7a4419", "#555555"}};
constexpr Theme dark = {"#e4e7ea",
                        "#9aa1a8",
                        "#363c42",
                        "#262c32",
                        {"#4db2ff", "#ff8a4c", "#3fd6a8", "#e58fd8", "#f0c040", "#8fd3ff", "#c99a6b", "#b5b5b5"}};
constexpr std::array<int, 5> filled = {7, 5, 9, 11, 13}, open = {6, 4, 8, 10, 12};

constexpr int width = 520, plotHeight = 380, keyRow = 19;

std::string axisLines(const char* name, const std::optional<LogAxis>& axis, const Theme& theme) {
    if (!axis) return "";
    std::string text = fmt::format("set logscale {0}\nset {0}range [{1:.9g}:{2:.9g}]\nset {0}tics ({3})\n", name,
                                   axis->least, axis->greatest, axis->tics());
    if (!axis->hasZero) return text;
    const bool isX = name[0] == 'x';
    text += isX ? fmt::format("set object rectangle from {:.9g}, graph 0 to {:.9g}, graph 1", axis->least, axis->border())
                : fmt::format("set object rectangle from graph 0, first {:.9g} to graph 1, first {:.9g}", axis->least,
                              axis->border());
    return text + fmt::format(" behind fillcolor rgb '{}' fillstyle solid noborder\n", theme.band);
}

/// The script's head: the frame, and what is written around it. Coordinates of a rectangle name both systems.
std::string frameLines(const Panel& panel, const Axes& axes, const Theme& theme) {
    std::string text = "reset\nset datafile separator whitespace\nset datafile missing '?'\n";
    text += fmt::format("set border 3 linecolor rgb '{}'\nset tics nomirror textcolor rgb '{}'\n", theme.soft, theme.ink);
    text += fmt::format("set grid linecolor rgb '{0}' linewidth 1 dashtype solid, linecolor rgb '{0}'\n", theme.grid);
    text += fmt::format("set title {} textcolor rgb '{}' font ',17'\n", gnuplotText(panel.title), theme.ink);
    text += fmt::format("set xlabel {} offset 0,0.4 textcolor rgb '{}'\n", gnuplotText(panel.xLabel), theme.ink);
    text += fmt::format(
        "set key outside below center horizontal Left reverse textcolor rgb '{}' samplen 1 spacing 1.05 height 0.7 font "
        "',13'\n",
        theme.ink);
    if (panel.drawing->style != Drawing::Style::heat) {
        text += fmt::format("set ylabel {} textcolor rgb '{}'\n", gnuplotText(panel.yLabel), theme.ink);
        text += axisLines("x", axes.x, theme) + axisLines("y", axes.y, theme);
        if (!axes.y) text += "set yrange [0:*]\nset offsets graph 0, graph 0, graph 0.05, graph 0\n";
        if (!axes.x) text += linearRange(panel);
    }
    return text;
}

/// A block of data that the script names.
std::string block(const std::string& name, const std::vector<std::array<double, 3>>& rows) {
    std::string text = "$" + name + " << EOD\n";
    for (const auto& row : rows) text += fmt::format("{:.9g} {:.9g} {:.9g}\n", row[0], row[1], row[2]);
    return text + "EOD\n";
}

/// Data blocks and the plot command, put together piece by piece.
struct Plot {
    std::string data, command;
    void add(const std::string& clause) { command += (command.empty() ? "plot " : ", \\\n     ") + clause; }
};

void addSeries(Plot& plot, const Panel& panel, const Axes& axes, size_t index, const Theme& theme) {
    const Series& series = panel.series[index];
    const std::string colour = theme.colours[index % theme.colours.size()];
    const size_t shape = (index + index / theme.colours.size()) % filled.size();
    const std::string title = series.label.empty() ? "notitle" : "title " + gnuplotText(series.label);
    std::vector<std::array<double, 3>> full, hollow, line, theory, band;
    for (const Dot& dot : series.dots) {
        const double x = axes.atX(dot.x);
        (dot.hollow ? hollow : full).push_back({x, axes.atY(dot.y), 0.0});
        line.push_back({x, axes.atY(dot.y), 0.0});
        if (dot.theory) theory.push_back({x, axes.atY(*dot.theory), 0.0});
        if (dot.band) band.push_back({x, axes.atY(*dot.band), axes.y ? axes.y->least : 0.0});
    }
    const auto draw = [&](const char* what, const auto& rows, const std::string& how) {
        if (rows.empty()) return;
        const std::string name = fmt::format("{}{}", what, index);
        plot.data += block(name, rows);
        plot.add(fmt::format("${} {}", name, how));
    };
    draw("band", band,
         fmt::format("using 1:3:2 with filledcurves fillstyle transparent solid 0.18 noborder linecolor rgb '{}' title {}",
                     colour, gnuplotText(panel.series.size() == 1 ? "bound" : "bound of " + series.label)));
    draw("theory", theory, fmt::format("using 1:2 with lines linewidth 1.5 dashtype 2 linecolor rgb '{}' notitle", colour));
    const bool joins = panel.drawing->style == Drawing::Style::lines;
    if (joins) draw("line", line, fmt::format("using 1:2 with lines linewidth 2 linecolor rgb '{}' notitle", colour));
    const double size = joins ? 0.9 : 1.5;
    draw("full", full,
         fmt::format("using 1:2 with points pointtype {} pointsize {} linecolor rgb '{}' {}", filled[shape], size, colour,
                     title));
    draw("hollow", hollow,
         fmt::format("using 1:2 with points pointtype {} pointsize {} linewidth 2 linecolor rgb '{}' {}", open[shape], size,
                     colour, full.empty() ? title : "notitle"));
    for (size_t i = 0; i < series.levels.size(); ++i)
        plot.add(fmt::format("{:.9g} with lines linewidth 2 dashtype 4 linecolor rgb '{}' {}", axes.atY(series.levels[i]),
                             colour, i == 0 ? title : "notitle"));
}

/// From the first dot on, by the slope of theory.
void addGuide(Plot& plot, const Panel& panel, const Theme& theme) {
    for (const Series& series : panel.series) {
        if (series.dots.size() < 2 || !(series.dots[0].x > 0.0) || !(series.dots[0].y > 0.0)) continue;
        const Dot &first = series.dots.front(), &last = series.dots.back();
        const double end = first.y * std::pow(last.x / first.x, panel.drawing->guide);
        plot.data += block("guide", {{first.x, first.y, 0.0}, {last.x, end, 0.0}});
        plot.add(fmt::format("$guide using 1:2 with lines linewidth 1.5 dashtype 3 linecolor rgb '{}' title 'slope {:g}'",
                             theme.soft, panel.drawing->guide));
        return;
    }
}

Plot plotOf(const Panel& panel, const Axes& axes, const Theme& theme) {
    Plot plot;
    if (panel.drawing->pareto) {
        std::vector<std::array<double, 3>> front;
        for (const Dot& dot : paretoFront(panel)) front.push_back({axes.atX(dot.x), axes.atY(dot.y), 0.0});
        plot.data += block("front", front);
        plot.add(fmt::format("$front using 1:2 with steps linewidth 4 linecolor rgb '{}' title 'Pareto front'", theme.grid));
    }
    if (panel.drawing->guide != 0.0) addGuide(plot, panel, theme);
    for (size_t i = 0; i < panel.series.size(); ++i) addSeries(plot, panel, axes, i, theme);
    return plot;
}

std::string categoryTics(const char* axis, const std::set<double>& values) {
    std::string text;
    size_t at = 0;
    for (const double value : values) text += fmt::format("{}'{:.6g}' {}", text.empty() ? "" : ", ", value, at++);
    return fmt::format("set {}tics ({})\n", axis, text);
}

/// The cells of a heat map, on whole numbers: the places of its categories.
struct HeatCells {
    std::set<double> xs, ys;
    std::map<std::pair<double, double>, const Dot*> dots;
    double least = INFINITY, greatest = 0.0;  ///< of the values above 0

    explicit HeatCells(const Series& series) {
        for (const Dot& dot : series.dots) {
            xs.insert(dot.x);
            ys.insert(*dot.second);
            dots[{dot.x, *dot.second}] = &dot;
            if (dot.y > 0.0) least = std::min(least, dot.y), greatest = std::max(greatest, dot.y);
        }
    }

    /// A block of a grid, as gnuplot reads it: column, row, and what `columns` makes of the cell, which may not be there.
    std::string block(const char* name, const std::function<std::string(const Dot*)>& columns) const {
        std::string text = fmt::format("${} << EOD\n", name);
        size_t row = 0;
        for (const double y : ys) {
            size_t column = 0;
            for (const double x : xs) {
                const auto cell = dots.find({x, y});
                text += fmt::format("{} {} {}\n", column++, row, columns(cell == dots.end() ? nullptr : cell->second));
            }
            ++row;
            text += "\n";
        }
        return text + "EOD\n";
    }

    bool isDark(const Dot& dot) const {
        return dot.y > 0.0 && std::log(dot.y / least) > 0.45 * std::log(std::max(greatest / least, 1.01));
    }
};

/// Colour over two settings, with contours of another measure. All of it is one series.
std::string heatLines(const Panel& panel, const Theme& theme) {
    const HeatCells cells(panel.series.front());
    const auto number = [](const std::optional<double>& value) { return value ? fmt::format("{:.9g}", *value) : "?"; };
    std::string text = cells.block(
        "cells", [&](const Dot* dot) { return dot ? number(dot->y) + " " + number(dot->contour) : std::string("? ?"); });
    const auto labels = [&](const char* name, bool dark) {
        text += cells.block(name, [&](const Dot* dot) {
            return dot && dot->contour && cells.isDark(*dot) == dark ? fmt::format("{:.3g}", *dot->contour)
                                                                     : std::string("\"\"");
        });
    };
    labels("onlight", false);
    labels("ondark", true);
    text += categoryTics("x", cells.xs) + categoryTics("y", cells.ys);
    text += fmt::format("set ylabel {} textcolor rgb '{}'\nset cblabel {} offset 1.3,0 textcolor rgb '{}'\n",
                        gnuplotText(panel.secondLabel), theme.ink, gnuplotText(panel.yLabel), theme.ink);
    text += fmt::format("set xrange [-0.5:{}]\nset yrange [-0.5:{}]\nunset grid\n", double(cells.xs.size()) - 0.5,
                        double(cells.ys.size()) - 0.5);
    if (panel.drawing->logY && cells.greatest > 0.0) {
        const LogAxis axis({cells.least, cells.greatest});
        text += fmt::format("set logscale cb\nset cbrange [{:.9g}:{:.9g}]\nset cbtics ({})\n", cells.least,
                            std::max(cells.greatest, 1.01 * cells.least), axis.tics());
    }
    text += "set palette defined (0 '#fde725', 0.25 '#5ec962', 0.5 '#21918c', 0.75 '#3b528b', 1 '#440154')\n";
    const bool hasContours = !panel.contourLabel.empty() && cells.xs.size() > 1 && cells.ys.size() > 1;
    if (hasContours)
        text +=
            "set contour base\nunset surface\nset cntrparam levels discrete 1.25, 1.5, 2, 3, 5, 10, 20, 50, 100, 500\n"
            "set table $contours\nsplot $cells using 1:2:4\nunset table\nunset contour\nset surface\n";
    text += "plot $cells using 1:2:3 with image pixels notitle";
    if (hasContours)
        text += fmt::format(
            ", \\\n     $contours using 1:2 with lines linewidth 2 linecolor rgb '#d55e00' notitle, \\\n"
            "     $onlight using 1:2:3 with labels textcolor rgb '#1c2024' font ',12' title {}, \\\n"
            "     $ondark using 1:2:3 with labels textcolor rgb '#ffffff' font ',12' notitle",
            gnuplotText("written: " + panel.contourLabel));
    return text + "\n";
}

size_t keyRows(const Panel& panel) {
    size_t entries = panel.drawing->pareto + (panel.drawing->guide != 0.0), letters = 0;
    for (const Series& series : panel.series) {
        entries += !series.label.empty() + !panel.drawing->band.empty();
        letters = std::max(letters, series.label.size());
    }
    const size_t aRow = std::max<size_t>(1, 66 / (std::max<size_t>(letters, 8) + 6));
    return std::max<size_t>(1, (entries + aRow - 1) / aRow);
}

std::filesystem::path fileOf(const std::filesystem::path& folder, const Panel& panel, const char* ending) {
    return folder / (panel.stem + ending);
}

}  // namespace

std::string scriptOf(const Panel& panel, const std::filesystem::path& folder) {
    const Axes axes(panel);
    const int height = plotHeight + keyRow * static_cast<int>(keyRows(panel));
    std::string text;
    const auto draw = [&](const Theme& theme, const std::string& terminal, const char* ending) {
        text += frameLines(panel, axes, theme);
        text += terminal + fmt::format("set output {}\n", gnuplotText(fileOf(folder, panel, ending).string()));
        if (panel.drawing->style == Drawing::Style::heat) {
            text += heatLines(panel, theme);
        } else {
            const Plot plot = plotOf(panel, axes, theme);
            text += plot.data + plot.command + "\n";
        }
        text += "unset output\n";
    };
    const std::string svg =
        fmt::format("set terminal svg size {},{} dynamic noenhanced font 'system-ui,sans-serif,15'\n", width, height);
    draw(light, svg, ".svg");
    draw(dark, svg, ".dark.svg");
    draw(light,
         fmt::format("set terminal pngcairo size {},{} noenhanced font 'sans,15' fontscale 1.5 linewidth 2 pointscale 2 "
                     "background rgb '#ffffff'\n",
                     2 * width, 2 * height),
         ".png");
    return text;
}

std::vector<ChartPanel> drawPanels(const std::vector<Panel>& panels, const std::filesystem::path& folder) {
    std::string script;
    for (const Panel& panel : panels) script += scriptOf(panel, folder);
    if (!script.empty()) runGnuplot(script);
    // gnuplot does not notice that a file could not be written whole.
    const auto endsWith = [&](const Panel& panel, const char* ending, std::string_view end) {
        const std::vector<std::byte> bytes = readFile(fileOf(folder, panel, ending));
        const std::string_view text(reinterpret_cast<const char*>(bytes.data()), bytes.size());
        return text.size() >= end.size() &&
               text.substr(text.size() - std::min<size_t>(text.size(), end.size() + 8)).find(end) != std::string_view::npos;
    };
    for (const Panel& panel : panels)
        for (const auto& [ending, end] : {std::pair(".svg", "</svg>"), {".dark.svg", "</svg>"}, {".png", "IEND"}})
            if (!endsWith(panel, ending, end)) {
                std::error_code ignored;
                for (const char* const part : {".svg", ".dark.svg", ".png"})
                    std::filesystem::remove(fileOf(folder, panel, part), ignored);
                throw inputError(fileOf(folder, panel, ending).string(),
                                 "could not be written whole; is there room for it?");
            }
    std::vector<ChartPanel> drawn;
    const auto read = [&](const Panel& panel, const char* ending) {
        const std::vector<std::byte> bytes = readFile(fileOf(folder, panel, ending));
        return std::string(reinterpret_cast<const char*>(bytes.data()), bytes.size());
    };
    for (const Panel& panel : panels) {
        drawn.push_back({panel.title, panel.stem, read(panel, ".svg"), read(panel, ".dark.svg"), describePanel(panel)});
        std::error_code ignored;
        std::filesystem::remove(fileOf(folder, panel, ".dark.svg"), ignored);  // the page has it
    }
    return drawn;
}

}  // namespace raig
