// What the page of charts shows: pictures with a slider, and figures with their tables.
#include "measure/chart_page_parts.hpp"

#include "measure/junit.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig::page {

namespace {

struct Label {
    const char* name;
    const char* text;
    bool isFault;  ///< whether it should be 0
};

/// What is known of pictures: what is wrong with them before how long they took.
constexpr Label pictureNumbers[] = {{"missed", "missed hits", true},
                                    {"phantom", "phantom hits", true},
                                    {"wrong", "wrong hits", true},
                                    {"nan", "pixels that are not finite", true},
                                    {"flip_mean", "FLIP, mean", false},
                                    {"flip_p99", "FLIP, 99th percentile", false},
                                    {"flip_max", "FLIP, largest", false},
                                    {"rmse", "RMSE in linear light", false},
                                    {"device_s", "seconds on the device", false},
                                    {"reference_s", "seconds of the reference", false}};

std::string numberList(const Json& numbers) {
    std::string list;
    const auto add = [&](const std::string& label, const Json& content, bool isFault) {
        const bool isBad = isFault && content.is_number() && content.get<double>() != 0.0;
        list +=
            fmt::format("<dt>{}</dt><dd{}>{}</dd>\n", escapedMarkup(label), isBad ? " class=\"bad\"" : "", value(content));
    };
    for (const Label& label : pictureNumbers)
        if (numbers.contains(label.name)) add(label.text, numbers[label.name], label.isFault);
    for (const auto& [name, content] : numbers.items())
        if (std::none_of(std::begin(pictureNumbers), std::end(pictureNumbers),
                         [&name = name](const Label& label) { return name == label.name; }))
            add(name, content, false);
    return list.empty() ? "" : "<dl class=\"numbers\">\n" + list + "</dl>\n";
}

std::string picture(const ChartPictures& pictures, const std::vector<std::byte>& png, const char* kind, const char* what,
                    const char* caption) {
    if (png.empty()) return "";
    constexpr uint32_t small = 400;  // pixels across: such are shown at twice their size, as the squares they are
    return fmt::format(
        "<figure class=\"{}\"><img{} width=\"{}\" height=\"{}\" alt=\"{}, {}\" "
        "src=\"{}\"><figcaption>{}</figcaption></figure>\n",
        kind, pictures.width < small ? " class=\"small\"" : "", pictures.width, pictures.height,
        escapedMarkup(pictures.scene), what, dataUri("image/png", png), caption);
}

std::string panel(const ChartPanel& panel) {
    const auto svg = [](const std::string& text) { return dataUri("image/svg+xml", text); };
    return fmt::format(
        "<figure><picture><source media=\"(prefers-color-scheme: dark)\" srcset=\"{}\"><img width=\"600\" height=\"440\" "
        "alt=\"{}\" src=\"{}\"></picture>\n<figcaption><span>{}</span><span "
        "class=\"files\">{}{}</span></figcaption></figure>\n",
        svg(panel.dark.empty() ? panel.light : panel.dark), escapedMarkup(panel.description), svg(panel.light),
        escapedMarkup(panel.title), fileLink(panel.stem + ".svg", "SVG"), fileLink(panel.stem + ".png", "PNG"));
}

/// Adds those names of `from` that `names` has not.
void addNames(std::vector<std::string>& names, const Json& from) {
    for (const auto& [name, content] : from.items())
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

std::string dataTable(const ChartFigure& figure) {
    const Json held = heldOf(figure.points);
    std::vector<std::string> settings, measures = figure.sweep.measures;
    bool isLeftOut = false, hasScene = false;
    for (const ChartPoint& point : figure.points) {
        addNames(settings, point.settings);
        if (figure.sweep.measures.empty()) addNames(measures, point.measures);
        isLeftOut |= !point.leftOut.empty();
        hasScene |= !point.scene.empty();
    }
    std::erase_if(settings, [&](const std::string& name) { return held.contains(name); });

    std::vector<std::string> columns;
    if (hasScene) columns.emplace_back("scene");
    columns.insert(columns.end(), settings.begin(), settings.end());
    columns.insert(columns.end(), measures.begin(), measures.end());
    if (isLeftOut) columns.emplace_back("left out");
    std::vector<std::vector<Cell>> rows;
    for (const ChartPoint& point : figure.points) {
        std::vector<Cell>& row = rows.emplace_back();
        if (hasScene) row.emplace_back(point.scene);
        for (const std::string& name : settings) row.emplace_back(member(point.settings, name));
        for (const std::string& name : measures) row.emplace_back(member(point.measures, name));
        if (isLeftOut) row.emplace_back(point.leftOut.empty() ? Json() : Json(point.leftOut), "reason");
    }
    std::string markup = table("Data of " + figure.sweep.title, columns, rows);
    if (!held.empty())
        markup += fmt::format("<p class=\"soft note\">The same in all: {}.</p>\n", escapedMarkup(describe(held)));
    return markup;
}

/// What is asked for and not there: by the declaration, and of the points.
std::string missingOf(const ChartFigure& figure) {
    std::string items;
    for (const Missing& missing : figure.sweep.missing)
        items +=
            fmt::format("<li>Missing: <b>{}</b>, as {}</li>\n", escapedMarkup(missing.what), escapedMarkup(missing.why));
    std::vector<std::pair<std::string, size_t>> reasons;
    for (const ChartPoint& point : figure.points) {
        if (point.leftOut.empty()) continue;
        const auto known =
            std::find_if(reasons.begin(), reasons.end(), [&](const auto& r) { return r.first == point.leftOut; });
        if (known == reasons.end())
            reasons.emplace_back(point.leftOut, 1);
        else
            ++known->second;
    }
    for (const auto& [reason, many] : reasons)
        items += fmt::format("<li>{} left out: {}</li>\n", count(many, "configuration"), escapedMarkup(reason));
    return items.empty() ? "" : "<div class=\"missing\"><ul>\n" + items + "</ul></div>\n";
}

std::string lawsOf(const ChartFigure& figure) {
    std::string items;
    for (const Breach& breach : figure.breaches) items += "<li>" + describe(breach) + "</li>\n";
    if (!items.empty()) return "<div class=\"broke\"><ul>\n" + items + "</ul></div>\n";
    if (!hasMeasured(figure)) return "";
    std::vector<std::string> reasons;
    for (const Law& law : figure.sweep.laws)
        if (!law.because.empty() && std::find(reasons.begin(), reasons.end(), law.because) == reasons.end())
            reasons.push_back(law.because);
    for (const std::string& reason : reasons) items += (items.empty() ? "" : "; ") + prose(reason);
    return items.empty() ? "" : "<p class=\"good note\">✓ Held: " + items + ".</p>\n";
}

}  // namespace

std::string pictures(const ChartPictures& pictures, size_t index) {
    const bool isPair = !pictures.device.empty() && !pictures.reference.empty();
    std::string markup = fmt::format(
        "<section class=\"scene\" id=\"pictures-{}\">\n<h3>{}</h3>\n<div class=\"views{}\" style=\"--ratio: {}\">\n<div>",
        index, escapedMarkup(pictures.scene), isPair ? " both" : "",
        pictures.height > 0 ? double(pictures.width) / double(pictures.height) : 1.0);
    if (isPair && !pictures.difference.empty())
        markup += fmt::format(
            "<div class=\"picker\" role=\"radiogroup\" aria-label=\"View\"><label><input type=\"radio\" name=\"view-{0}\" "
            "value=\"slider\" checked>Slider</label><label><input type=\"radio\" name=\"view-{0}\" "
            "value=\"difference\">Difference</label></div>\n",
            index);
    markup += "<div class=\"stage\">\n";
    markup += picture(pictures, pictures.device, "device", "by the device", "Device");
    markup += picture(pictures, pictures.reference, "reference", "by the reference in double precision",
                      "Reference<span class=\"more\">, double precision</span>");
    markup += picture(pictures, pictures.difference, "difference", "how the two differ, FLIP in false colour",
                      "Difference, FLIP: <span style=\"white-space: nowrap\">0 <span class=\"scale\"></span> 1</span>");
    if (isPair)
        markup += fmt::format(
            "<input class=\"cut\" type=\"range\" min=\"0\" max=\"100\" step=\"0.5\" value=\"50\" autocomplete=\"off\" "
            "aria-label=\"Border between the device's picture of {} and the reference\"><div class=\"handle\"></div>\n",
            escapedMarkup(pictures.scene));
    return markup + "</div></div>\n" + numberList(pictures.numbers) + "</div>\n</section>\n";
}

bool hasMeasured(const ChartFigure& figure) {
    return std::any_of(figure.points.begin(), figure.points.end(), [](const ChartPoint& p) { return p.leftOut.empty(); });
}

std::string figurePlace(const ChartFigure& figure) {
    return escapedMarkup("#fig-" + figure.sweep.name);
}

std::string figure(const ChartFigure& figure, size_t index) {
    const Sweep& sweep = figure.sweep;
    std::string markup = fmt::format("<section class=\"figure\" id=\"{}\">\n<h3><small>Figure {}</small>{}</h3>\n",
                                     figurePlace(figure).substr(1), index + 1, escapedMarkup(sweep.title));
    if (!sweep.text.empty()) markup += fmt::format("<p>{}</p>\n", prose(sweep.text));
    markup += lawsOf(figure);
    if (!figure.panels.empty()) {
        markup += fmt::format("<div class=\"panels{}\">\n", figure.panels.size() == 1 ? " one" : "");
        for (const ChartPanel& one : figure.panels) markup += panel(one);
        markup += "</div>\n";
    }
    markup += missingOf(figure);
    if (!figure.points.empty())
        markup += fmt::format(
            "<div class=\"data\"><span class=\"files\">{}{}</span><details><summary>Data of "
            "{}</summary>\n{}</details></div>\n",
            fileLink(sweep.name + ".csv", "CSV"), fileLink(sweep.name + ".json", "JSON"),
            count(figure.points.size(), "configuration"), dataTable(figure));
    return markup + "</section>\n";
}

}  // namespace raig::page
