#include "app/stress_text.hpp"

#include "measure/oracle.hpp"

#include <fmt/format.h>

#include <algorithm>

namespace raig {

namespace {

constexpr const char* rowFormat = "{:>4}  {:48} {:>9} {:>7} {:>7} {:>7} {:>7} {:>5} {:>5} {:>6} {:>10}  {}\n";

void printRow(uint32_t number, const std::string& what, const StressResult& r, const std::string& note) {
    fmt::print(rowFormat, number, what.substr(0, 48), fmt::format("{}{}", r.rays, r.isOfPixels ? " px" : ""),
               r.count(StressFault::missed), r.count(StressFault::phantom), r.count(StressFault::wrong),
               r.count(StressFault::differs), r.count(StressFault::any), r.count(StressFault::hung),
               r.count(StressFault::error),
               fmt::format("{:.6g}", r.rays == 0 ? 0.0 : 1e6 * double(r.forbidden()) / double(r.rays)), note);
}

}  // namespace

void printResults(const StressDocument& document, bool verbose) {
    struct Line {
        const hard::Case* hardCase;
        const StressResult* worst;
        size_t structures = 0, failing = 0;
    };
    std::vector<Line> lines;
    for (const hard::Case& hardCase : document.cases)
        for (size_t device = 0; device < document.devices.size(); ++device) {
            Line line{&hardCase, nullptr};
            for (const StressResult& r : document.results) {
                if (r.number != hardCase.number || r.deviceNumber != device) continue;
                if (verbose) lines.push_back({&hardCase, &r});
                ++line.structures;
                line.failing += r.forbidden() > 0;
                if (line.worst == nullptr || r.forbidden() > line.worst->forbidden()) line.worst = &r;
            }
            if (!verbose && line.worst != nullptr) lines.push_back(line);
        }
    std::stable_sort(lines.begin(), lines.end(),
                     [](const Line& a, const Line& b) { return a.worst->forbidden() > b.worst->forbidden(); });
    fmt::print(rowFormat, "case", verbose ? "structure" : "what", "rays", "missed", "phantom", "wrong", "differs", "any",
               "hung", "error", "per 10^6", verbose ? "device" : "");
    for (const Line& line : lines) {
        const StressResult& r = *line.worst;
        if (verbose)
            printRow(r.number, r.name(), r, r.device);
        else if (line.failing == 0)
            printRow(r.number, line.hardCase->what, r, fmt::format("all {} alike", line.structures));
        else
            printRow(r.number, line.hardCase->what, r, fmt::format("{}, of {} that fail", r.name(), line.failing));
    }
}

void printControls(const StressDocument& document) {
    if (document.controls.empty()) return;
    fmt::print("\n{:>4}  {:58} {:>9} {:>9} {:>12}\n", "case", "control: must fail", "rays", "fails", "should");
    for (const bool fails : {false, true})
        for (const ControlResult& r : document.controls)
            if (r.fails == fails)
                fmt::print("{:>4}  {:58} {:>9} {:>9.2f} {:>12} {}{}\n", r.control.number, r.control.method.substr(0, 58),
                           r.findings.rays, r.findings.rate(), expectedRate(r.control), r.control.unit,
                           r.fails ? "" : "  the instrument is broken");
}

void printNotRun(const StressDocument& document) {
    if (!document.notRun.empty()) fmt::print("\n{:>4}  {:58} {}\n", "case", "not run", "as");
    for (const hard::NotRun& one : document.notRun) fmt::print("{:>4}  {:58} {}\n", one.number, one.what, one.why);
}

void printReplay(const StressDocument& document, const StressReplay& replay, uint64_t number) {
    const hard::Case& hardCase = document.cases[0];
    fmt::print("case {}, {}; seed {}, ray {}: in scene \"{}\" of {} triangles\n", hardCase.number, hardCase.what,
               document.seed, number, replay.scene, replay.triangles);
    fmt::print("{:48} {}\n", "the ray", hard::describe(replay.ray));
    fmt::print("{:48} {}{}\n", "exactly", hard::describe(replay.exact),
               replay.open ? ", but rounding may decide: any sound answer is let pass" : "");
    for (const StressReplay::Answer& answer : replay.answers) {
        std::string faults;
        for (const StressFault fault : answer.faults)
            faults += fmt::format("{}{}", faults.empty() ? "" : ", ", stressFaultNames[static_cast<size_t>(fault)]);
        const std::string any = (answer.any.primitive == NO_HIT) == (answer.closest.primitive == NO_HIT)
                                    ? ""
                                    : fmt::format("; any: {}", hard::describe(answer.any));
        std::string name = answer.structure + (answer.options.empty() ? "" : " " + answer.options);
        if (document.devices.size() > 1) name += fmt::format(" ({})", answer.device);
        fmt::print("{:48} {}{}  {}{}\n", name, hard::describe(answer.closest), any, faults.empty() ? "right" : faults,
                   answer.thrown.empty() ? "" : ": " + answer.thrown);
    }
}

}  // namespace raig
