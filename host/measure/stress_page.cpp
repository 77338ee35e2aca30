#include "measure/stress_page.hpp"

#include "measure/junit.hpp"
#include "measure/page_style.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <map>

namespace raig {

namespace {

constexpr const char* style = R"(
td.what, th.what { text-align: left; white-space: normal; min-width: 9rem; }
td.how { white-space: normal; } tbody th { font-weight: 400; white-space: normal; min-width: 8.5rem; }
@media (max-width: 30rem) { table { font-size: 0.7rem; } th, td { padding: 0.3rem 0.13rem; }
  thead th { white-space: normal; } tbody th { min-width: 4.6rem; } td.what, th.what { min-width: 4.5rem; } }
)";

/// "1,234,567"
std::string grouped(uint64_t number) {
    std::string text = std::to_string(number);
    for (size_t at = text.size(); at > 3; at -= 3) text.insert(at - 3, 1, ',');
    return text;
}

std::string numberCell(uint64_t count) {
    return fmt::format("<td class=\"{}\">{}</td>", count == 0 ? "zero" : "bad", grouped(count));
}

std::string countOf(const StressResult& result) {
    return grouped(result.rays) + (result.isOfPixels ? " px" : "");
}

std::string nameOf(const hard::Case& hardCase) {
    return fmt::format("<b>{}</b> {}", hardCase.number, escapedMarkup(hardCase.what));
}

/// Cases by structures, on one device: what must not be, of all ways to build and walk each.
std::string overview(const StressDocument& document, size_t device) {
    std::vector<std::string> structures;
    std::map<std::pair<uint32_t, std::string>, uint64_t> forbidden;
    std::map<uint32_t, std::string> rays;
    for (const StressResult& result : document.results) {
        if (result.deviceNumber != device) continue;
        if (std::find(structures.begin(), structures.end(), result.structure) == structures.end())
            structures.push_back(result.structure);
        forbidden[{result.number, result.structure}] += result.forbidden();
        rays[result.number] = countOf(result);
    }
    std::string table = "<div class=\"wide\"><table><thead><tr><th>case</th>";
    for (const std::string& structure : structures) table += "<th>" + escapedMarkup(structure) + "</th>";
    table += "<th>rays or pixels</th></tr></thead><tbody>\n";
    for (const hard::Case& hardCase : document.cases) {
        if (!rays.contains(hardCase.number)) continue;
        table += "<tr><th>" + nameOf(hardCase) + "</th>";
        for (const std::string& structure : structures) table += numberCell(forbidden[{hardCase.number, structure}]);
        table += fmt::format("<td class=\"how\">{}</td></tr>\n", rays[hardCase.number]);
    }
    return table + "</tbody></table></div>\n";
}

std::string controlTable(const StressDocument& document) {
    std::string table =
        "<div class=\"wide\"><table><thead><tr><th>case</th><th class=\"what\">control</th><th>of rays</th><th>fail</th>"
        "<th>rate</th><th>should</th><th>as it should</th></tr></thead><tbody>\n";
    for (const ControlResult& r : document.controls) {
        std::string failures;
        for (const auto& [count, how] : {std::pair(r.findings.missed, "missed"), std::pair(r.findings.phantom, "phantom"),
                                         std::pair(r.findings.wrong, "wrong"), std::pair(r.findings.hung, "hung")})
            if (count > 0) failures += fmt::format("{}{} {}", failures.empty() ? "" : ", ", grouped(count), how);
        table += fmt::format(
            "<tr><td><b>{}</b></td><td class=\"what\">{}</td><td>{}</td><td class=\"how\">{}</td>"
            "<td class=\"how\">{:.2f} {}</td><td class=\"how\">{}</td><td class=\"{}\">{}</td></tr>\n",
            r.control.number, escapedMarkup(r.control.method), grouped(r.findings.rays),
            !failures.empty()     ? failures
            : r.findings.measured ? ""
                                  : "0",
            r.findings.rate(), r.control.unit, expectedRate(r.control), r.fails ? "good" : "bad", r.fails ? "yes" : "NO");
    }
    return table + "</tbody></table></div>\n";
}

std::string caseDetails(const StressDocument& document, const hard::Case& hardCase) {
    std::string rows;
    uint64_t forbidden = 0;
    for (const StressResult& result : document.results) {
        if (result.number != hardCase.number) continue;
        forbidden += result.forbidden();
        rows += fmt::format("<tr><td>{} <span class=\"soft\">{}</span></td><td>{}</td><td>{}</td><td>{}</td>",
                            escapedMarkup(result.structure), escapedMarkup(result.options), countOf(result),
                            result.isOfPixels ? "" : grouped(result.hits), result.isOfPixels ? "" : grouped(result.open));
        for (size_t fault = 1; fault < stressFaults; ++fault) rows += numberCell(result.counts[fault]);
        rows += "<td class=\"what soft\">" + escapedMarkup(result.device) + "</td></tr>\n";
    }
    if (rows.empty()) return "";
    std::string details = fmt::format(
        "<details{}><summary>{}: {}</summary><div class=\"wide\"><table><thead><tr>"
        "<th>structure</th><th>rays</th><th>hits</th><th>open</th>",
        forbidden > 0 ? " open" : "", nameOf(hardCase),
        forbidden > 0 ? fmt::format("<span class=\"bad\">{} forbidden</span>", grouped(forbidden))
                      : "<span class=\"soft\">0</span>");
    for (size_t fault = 1; fault < stressFaults; ++fault) details += fmt::format("<th>{}</th>", stressFaultNames[fault]);
    return details + "<th class=\"what\">device</th></tr></thead><tbody>\n" + rows + "</tbody></table></div></details>\n";
}

std::string describe(const StressExample& example, bool isOfPixels) {
    return fmt::format("{} {} of scene \"{}\" ({}): {}", isOfPixels ? "pixel" : "ray", example.ray, example.scene,
                       stressFaultNames[static_cast<size_t>(example.fault)], example.what);
}

std::string failureList(const StressDocument& document) {
    std::string items;
    for (const StressResult& result : document.results) {
        if (result.forbidden() == 0) continue;
        items += fmt::format("<li>Case {}, {} on {}: <b>{}</b>\n<ul>\n", result.number, escapedMarkup(result.name()),
                             escapedMarkup(result.device), describeFaults(result));
        for (const StressExample& example : result.examples)
            items += fmt::format("<li>{}<br><code>{}</code></li>\n", escapedMarkup(describe(example, result.isOfPixels)),
                                 escapedMarkup(document.replayOf(result, example.ray)));
        items += "</ul></li>\n";
    }
    for (const StressDevice& device : document.devices)
        if (device.stopped) items += fmt::format("<li>Not all was run: {}</li>\n", escapedMarkup(device.stopped->what()));
    for (const ControlResult& result : document.controls)
        if (!result.fails)
            items += fmt::format("<li>Control of case {}, {}: {}</li>\n", result.control.number,
                                 escapedMarkup(result.control.method), escapedMarkup(describeFailure(result)));
    return items.empty() ? "" : "<h2 class=\"bad\">What fell short</h2>\n<ul>\n" + items + "</ul>\n";
}

std::string verdictOf(const StressDocument& document) {
    const uint64_t forbidden = document.forbidden(), rays = document.rays();
    const size_t broken = document.brokenControls();
    std::string text;
    if (rays > 0 && forbidden == 0)
        text += fmt::format("<p class=\"verdict good\">0 of {} answers are wrong.</p>\n", grouped(rays));
    else if (rays > 0)
        text += fmt::format("<p class=\"verdict bad\">{} of {} answers are wrong.</p>\n", grouped(forbidden), grouped(rays));
    if (document.stoppedDevices() > 0)
        text += fmt::format("<p class=\"verdict bad\">Not all was run on {} of {} devices.</p>\n", document.stoppedDevices(),
                            document.devices.size());
    if (broken > 0)
        text += fmt::format(
            "<p class=\"verdict bad\">The instrument is broken: {} of {} controls do not fail as they should."
            "</p>\n",
            broken, document.controls.size());
    else if (!document.controls.empty())
        text += fmt::format("<p class=\"good\">All {} controls fail, as they must.</p>\n", document.controls.size());
    return text;
}

std::string missing(const StressDocument& document) {
    if (document.notRun.empty()) return "";
    std::string list = "<h2>Not run</h2>\n<ul>\n";
    for (const hard::NotRun& one : document.notRun)
        list += fmt::format("<li><b>{}</b> {}: {}.</li>\n", one.number, escapedMarkup(one.what), escapedMarkup(one.why));
    return list + "</ul>\n";
}

std::string foot(const StressDocument& document) {
    std::string list = "<h2>How this was measured</h2>\n<dl>\n";
    const auto add = [&](const std::string& what, const std::string& text) {
        list += fmt::format("<dt>{}</dt><dd>{}</dd>\n", escapedMarkup(what), escapedMarkup(text));
    };
    for (const StressDevice& device : document.devices) {
        add("device", device.driver.empty() ? device.name : fmt::format("{}, driver {}", device.name, device.driver));
        add("its arithmetic, measured", device.arithmetic);
    }
    add("processor", fmt::format("{}, {} threads", document.processor, document.threads));
    add("command", document.command);
    add("seed", std::to_string(document.seed));
    add("raig", fmt::format("{}, commit {}, compiled with -ffp-contract=off", document.version, document.commit));
    add("took", fmt::format("{:.1f} s", document.seconds));
    return list + "</dl>\n";
}

}  // namespace

uint64_t StressDocument::forbidden() const {
    uint64_t sum = 0;
    for (const StressResult& result : results) sum += result.forbidden();
    return sum;
}

size_t StressDocument::brokenControls() const {
    return static_cast<size_t>(
        std::count_if(controls.begin(), controls.end(), [](const ControlResult& result) { return !result.fails; }));
}

size_t StressDocument::stoppedDevices() const {
    return static_cast<size_t>(std::count_if(devices.begin(), devices.end(),
                                             [](const StressDevice& device) { return device.stopped.has_value(); }));
}

uint64_t StressDocument::rays() const {
    uint64_t sum = 0;
    for (const StressResult& result : results) sum += result.rays;
    return sum;
}

std::string StressDocument::replayOf(const StressResult& result, uint64_t ray) const {
    const std::string command =
        fmt::format("{} --device {} --case {}", replay, devices.at(result.deviceNumber).argument, result.number);
    return hard::caseOf(result.number).isOfRays() ? fmt::format("{} --ray {}", command, ray) : command;
}

std::string expectedRate(const Control& control) {
    if (!control.hasRate()) return "any";
    return control.low == control.high ? fmt::format("{:g}", control.low)
                                       : fmt::format("{:g} to {:g}", control.low, control.high);
}

std::string describeFaults(const StressResult& result) {
    std::string text;
    for (size_t fault = 1; fault < stressFaults; ++fault)
        if (result.counts[fault] > 0)
            text += fmt::format("{}{} {}", text.empty() ? "" : ", ", result.counts[fault], stressFaultNames[fault]);
    return text;
}

std::string describeFailure(const StressDocument& document, const StressResult& result) {
    if (result.examples.empty()) return describeFaults(result);
    const StressExample& example = result.examples.front();
    return fmt::format("{}; {}; see: {}", describeFaults(result), describe(example, result.isOfPixels),
                       document.replayOf(result, example.ray));
}

std::string describeFailure(const ControlResult& result) {
    if (result.fails) return "";
    return fmt::format("the instrument is broken: this method {} {:.2f} {} of {} rays, and should {}",
                       result.findings.measured ? "errs by" : "fails", result.findings.rate(), result.control.unit,
                       result.findings.rays,
                       result.control.hasRate()
                           ? fmt::format("{} {}, to a factor of two", expectedRate(result.control), result.control.unit)
                           : "some of them");
}

std::string stressPage(const StressDocument& document) {
    std::string page =
        "<!DOCTYPE html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n"
        "<meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n"
        "<meta name=\"color-scheme\" content=\"light dark\">\n<title>raig: hard cases</title>\n<style>";
    page += pageStyle;
    page += style;
    page += "</style>\n</head>\n<body>\n<h1>Hard cases</h1>\n";
    page += verdictOf(document) + failureList(document);
    for (size_t i = 0; i < document.devices.size() && !document.results.empty(); ++i)
        page += fmt::format("<h2>On {}</h2>\n", escapedMarkup(document.devices[i].name)) + overview(document, i);
    if (!document.results.empty())
        page +=
            "<p class=\"soft\">Each number counts rays with an answer that must not be: hits that are missed, invented "
            "(phantom) or in the wrong place by exact arithmetic, answers with other bits than brute force has, any-hit "
            "queries that disagree with closest-hit ones, walks that do not end, and errors; or pixels (px) that are not "
            "what is known of them; over all ways to build and walk the structure. None in n rays means a rate below 3/n, "
            "with 95 % confidence.</p>\n";
    if (!document.controls.empty())
        page += "<h2>Controls: textbook methods that must fail</h2>\n" + controlTable(document) +
                "<p class=\"soft\">A control fails as it should if its rate is within a factor of two of the one that "
                "is known; where none is, if it fails at all.</p>\n";
    if (!document.results.empty()) {
        page += "<h2>Case by case</h2>\n";
        for (const hard::Case& hardCase : document.cases) page += caseDetails(document, hardCase);
        page +=
            "<p class=\"soft\">Open: rays whose answer differs from the exact one where rounding may decide, as they pass "
            "an edge that nothing continues, or end on a surface.</p>\n";
    }
    return page + missing(document) + foot(document) + "</body>\n</html>\n";
}

}  // namespace raig
