#include "measure/chart_document.hpp"

#include "measure/chart_page_parts.hpp"
#include "measure/junit.hpp"
#include "measure/page_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <set>
#include <span>

namespace raig {

namespace {

using page::count;

/// Answers that must not be, of a method on a scene.
struct Faults {
    std::string scene, method;
    std::array<Json, 3> counts;  ///< missed, phantom, wrong, per million; null where it was not measured
    size_t configurations = 0;

    double sum() const {
        double total = 0.0;
        for (const Json& one : counts) total += one.is_number() ? one.get<double>() : 0.0;
        return total;
    }
};

/// What a method is called: by its label or name, if it has one, else by the settings that tell it apart from others.
std::string methodOf(const Json& settings, Json held) {
    for (const char* name : {"label", "method"})
        if (settings.contains(name) && settings[name].is_string()) return settings[name].get<std::string>();
    held.erase("accel");
    return page::describe(settings, held);
}

constexpr std::array faultNames = {"missed", "phantom", "wrong"};

/// Of each method on each scene the configuration with the most; worst first.
std::vector<Faults> faultsOf(const ChartDocument& document) {
    std::map<std::pair<std::string, std::string>, Faults> worst;
    for (const ChartFigure& figure : document.figures) {
        const Json held = page::heldOf(figure.points);
        for (const ChartPoint& point : figure.points) {
            Faults faults{point.scene, methodOf(point.settings, held), {}, 1};
            bool isMeasured = false;
            for (size_t i = 0; i < faultNames.size(); ++i) {
                faults.counts[i] = page::member(point.measures, faultNames[i]);
                isMeasured |= faults.counts[i].is_number();
            }
            if (!isMeasured || !point.leftOut.empty()) continue;
            const auto [known, isNew] = worst.try_emplace({faults.scene, faults.method}, faults);
            if (isNew) continue;
            faults.configurations = known->second.configurations + 1;
            if (faults.sum() > known->second.sum()) known->second = faults;
            known->second.configurations = faults.configurations;
        }
    }
    std::vector<Faults> sorted;
    for (auto& [key, faults] : worst) sorted.push_back(std::move(faults));
    std::stable_sort(sorted.begin(), sorted.end(), [](const Faults& a, const Faults& b) { return a.sum() > b.sum(); });
    return sorted;
}

std::string faultTable(std::span<const Faults> all) {
    const bool isOneEach =
        std::all_of(all.begin(), all.end(), [](const Faults& faults) { return faults.configurations == 1; });
    std::vector<std::string> columns{"method", "missed", "phantom", "wrong", "scene"};
    if (!isOneEach) columns.emplace_back("configurations");
    std::vector<std::vector<page::Cell>> rows;
    for (const Faults& faults : all) {
        std::vector<page::Cell>& row = rows.emplace_back();
        row.emplace_back(faults.method);
        for (const Json& one : faults.counts) row.emplace_back(one, one.is_number() && one.get<double>() > 0.0 ? "bad" : "");
        row.emplace_back(faults.scene);
        if (!isOneEach) row.emplace_back(Json(faults.configurations));
    }
    return page::table("Hit faults per million rays", columns, rows);
}

std::string hitFaults(const ChartDocument& document) {
    const std::vector<Faults> all = faultsOf(document);
    if (all.empty()) return "";
    const auto end = std::find_if(all.begin(), all.end(), [](const Faults& faults) { return faults.sum() == 0.0; });
    const size_t bad = static_cast<size_t>(end - all.begin());
    std::string markup = "<h3>Hit faults, per million rays</h3>\n";
    if (bad > 0) markup += faultTable(std::span(all).first(bad));
    if (bad == 0) markup += "<p class=\"good\">No hit is missed, invented or misplaced.</p>\n";
    if (bad < all.size())
        markup += fmt::format("<details><summary>{} of a method and a scene without a fault</summary>\n{}</details>\n",
                              count(all.size() - bad, "pair"), faultTable(std::span(all).subspan(bad)));
    return markup + R"(<p class="soft note">Missed: the ray hits something, and the method says it does not. Phantom: it hits
nothing, and the method says it does. Wrong: another place than where it hits. Of several configurations of a method the
worst is shown. None in n rays means a rate below 3/n, with 95 % confidence.</p>
)";
}

std::string verdict(const ChartDocument& document) {
    size_t laws = 0, points = 0, leftOut = 0, missing = 0;
    std::set<std::string> scenes;
    for (const ChartFigure& figure : document.figures) {
        if (page::hasMeasured(figure)) laws += figure.sweep.laws.size();
        missing += figure.sweep.missing.size();
        for (const ChartPoint& point : figure.points) {
            if (!point.scene.empty()) scenes.insert(point.scene);
            ++(point.leftOut.empty() ? points : leftOut);
        }
    }
    const size_t breaches = document.breaches().size();
    std::string markup;
    if (breaches > 0)
        markup += fmt::format("<p class=\"verdict bad\">{} where theory says {} cannot.</p>\n",
                              breaches == 1 ? "1 measurement lies" : count(breaches, "measurement") + " lie",
                              breaches == 1 ? "it" : "they");
    else if (laws > 0)
        markup +=
            fmt::format("<p class=\"verdict good\">{} of theory held, in all that was measured.</p>\n", count(laws, "law"));
    markup += fmt::format("<p class=\"soft\">{} measured on {}, in {}, in {} s", count(points, "configuration"),
                          count(scenes.size(), "scene"), count(document.figures.size(), "figure"),
                          page::number(std::round(document.seconds)));
    if (leftOut > 0) markup += fmt::format("; {} left out", page::number(double(leftOut)));
    if (missing > 0) markup += fmt::format("; <a href=\"#missing\">{} missing</a>", count(missing, "part"));
    return markup + ".</p>\n";
}

std::string contents(const ChartDocument& document) {
    std::string items;
    if (!document.pictures.empty()) items += "<li><a href=\"#pictures\">Pictures</a></li>\n";
    for (size_t i = 0; i < document.figures.size(); ++i)
        items += fmt::format("<li><a href=\"{}\">{}. {}</a></li>\n", page::figurePlace(document.figures[i]), i + 1,
                             escapedMarkup(document.figures[i].sweep.title));
    return "<nav aria-label=\"Contents\"><ol>\n" + items +
           "<li><a href=\"#how\">How this was measured</a></li>\n</ol></nav>\n";
}

std::string broken(const ChartDocument& document) {
    std::string items;
    for (size_t i = 0; i < document.figures.size(); ++i)
        for (const Breach& breach : document.figures[i].breaches)
            items += fmt::format("<li><a href=\"{}\">Figure {}</a>, {}</li>\n", page::figurePlace(document.figures[i]),
                                 i + 1, page::describe(breach));
    for (const ChartPictures& pictures : document.pictures) {
        const double pixels = double(pictures.width) * pictures.height;
        for (const auto& [name, what] : {std::pair("missed", "hits are missed"),
                                         {"phantom", "hits are phantoms"},
                                         {"wrong", "hits are wrong"},
                                         {"nan", "pixels are not finite"}})
            if (const Json found = page::member(pictures.numbers, name); found.is_number() && found.get<double>() > 0.0)
                items += fmt::format("<li>Picture of <b>{}</b>: {} of {} {}</li>\n", escapedMarkup(pictures.scene),
                                     page::value(found), page::number(pixels), what);
    }
    return items.empty() ? "" : "<div class=\"broke\"><ul>\n" + items + "</ul></div>\n";
}

std::string missing(const ChartDocument& document) {
    std::string items;
    for (size_t i = 0; i < document.figures.size(); ++i)
        for (const Missing& one : document.figures[i].sweep.missing)
            items += fmt::format("<li><b>{}</b> (<a href=\"{}\">figure {}</a>): {}</li>\n", escapedMarkup(one.what),
                                 page::figurePlace(document.figures[i]), i + 1, escapedMarkup(one.why));
    return items.empty() ? "" : "<h3 id=\"missing\">Missing</h3>\n<div class=\"missing\"><ul>\n" + items + "</ul></div>\n";
}

std::string foot(const ChartDocument& document) {
    std::string list = "<h2 id=\"how\">How this was measured</h2>\n<dl>\n";
    const auto add = [&](const char* what, const std::string& text, bool isCode = false) {
        if (text.empty()) return;
        const std::string shown = escapedMarkup(text);
        list += fmt::format("<dt>{}</dt><dd>{}</dd>\n", what, isCode ? "<code>" + shown + "</code>" : shown);
    };
    add("processor", fmt::format("{}, {}", document.processor, count(document.threads, "thread")));
    add("device", document.device);
    add("driver", document.driver);
    add("its arithmetic, measured", document.arithmetic);
    add("raig", document.version);
    add("commit", document.commit, true);
    add("compiled with", document.flags, true);
    add("seed", std::to_string(document.seed));
    add("command", document.command, true);
    add("took", fmt::format("{:.1f} s", document.seconds));
    return list + "</dl>\n";
}

/// The page may show what is in it, and load nothing.
constexpr const char* head =
    "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
    "<meta http-equiv=\"Content-Security-Policy\" content=\"default-src 'none'; img-src data:; style-src 'unsafe-inline'; "
    "script-src 'unsafe-inline'; base-uri 'none'; form-action 'none'\">\n"
    "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
    "<meta name=\"color-scheme\" content=\"light dark\">\n<link rel=\"icon\" href=\"data:,\">\n"
    "<title>raig: speed against accuracy</title>\n<script>document.documentElement.className = 'js';</script>\n<style>";

}  // namespace

std::vector<Breach> ChartDocument::breaches() const {
    std::vector<Breach> all;
    for (const ChartFigure& figure : figures) all.insert(all.end(), figure.breaches.begin(), figure.breaches.end());
    for (const ChartPictures& picture : pictures)
        for (const char* const name : {"missed", "phantom", "wrong", "nan"})
            if (picture.numbers.contains(name) && picture.numbers[name].is_number() && picture.numbers[name] > 0)
                all.push_back(
                    {"pictures", picture.scene, fmt::format("{} is {}; must be 0", name, picture.numbers[name].dump())});
    return all;
}

std::string chartPage(const ChartDocument& document) {
    std::string text = head;
    text += pageStyle;
    text += page::style;
    text += "</style>\n</head>\n<body>\n<header>\n<h1>Speed against accuracy</h1>\n";
    text += verdict(document) + contents(document) + "</header>\n<main>\n";
    const std::string failures = broken(document) + hitFaults(document) + missing(document);
    if (!failures.empty()) text += "<h2 id=\"failures\">What fails</h2>\n" + failures;
    if (!document.pictures.empty()) text += "<h2 id=\"pictures\">Pictures</h2>\n";
    for (size_t i = 0; i < document.pictures.size(); ++i) text += page::pictures(document.pictures[i], i);
    if (!document.figures.empty()) text += "<h2>Figures</h2>\n";
    for (size_t i = 0; i < document.figures.size(); ++i) text += page::figure(document.figures[i], i);
    text += foot(document) + "</main>\n<script>";
    text += page::script;
    return text + "</script>\n</body>\n</html>\n";
}

}  // namespace raig
