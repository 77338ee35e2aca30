// `raig stress`: the hard cases, for every structure, by exact arithmetic; and controls that must fail.
#include "app/command_text.hpp"
#include "app/commands.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "app/stress_json.hpp"
#include "app/stress_run.hpp"
#include "app/stress_text.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "base/log.hpp"

#include <algorithm>
#include <chrono>
#include <cstdio>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

/// The command line again, without where results go; if it is for other rays of the same batch, without what chooses cases
/// and the device.
std::string commandOf(const Options& options, bool forReplay) {
    std::string text = fmt::format("raig stress --seed {}", options.seed);
    if (!forReplay)
        for (const uint32_t number : options.cases) text += fmt::format(" --case {}", number);
    if (options.isLong) text += " --long";
    if (options.rayCount > 0) text += fmt::format(" --rays {}", options.rayCount);
    if (options.accelGiven) text += " --accel " + options.accel;
    const std::string given = describeOptions(options.buildParams);
    if (!given.empty()) text += " " + given;
    if (!forReplay && options.device != "auto") text += " --device " + quoted(options.device);
    if (!forReplay && options.onlyControls) text += " --controls";
    if (!forReplay && options.ray) text += fmt::format(" --ray {}", *options.ray);
    return text;
}

/// Those of the cases; none with one ray, which are for the structures only.
std::vector<Control> chooseControls(const Options& options, const std::vector<hard::Case>& cases) {
    if (options.onlyControls && options.ray)
        throw usageError("--ray is for structures, and --controls runs none; leave out one of them");
    if (options.ray) return {};
    std::vector<Control> controls = allControls();
    std::erase_if(controls, [&](const Control& control) {
        return std::none_of(cases.begin(), cases.end(), [&](const hard::Case& one) { return one.number == control.number; });
    });
    if (options.onlyControls && controls.empty())
        throw usageError("--controls: there is none of what --case names; leave that out to run all");
    return controls;
}

void runControls(const Options& options, const std::vector<Control>& controls, StressDocument& document) {
    Progress progress("controls");
    for (size_t i = 0; i < controls.size(); ++i) {
        progress.update("controls", double(i) / double(controls.size()));
        document.controls.push_back(runControl(controls[i], options.seed));
    }
}

void write(const std::filesystem::path& file, const std::string& text) {
    writeFileAtomically(file, std::as_bytes(std::span(text)));
}

/// The text of a document: names come from drivers, and what is not UTF-8 in them must not spoil it.
std::string textOf(const Json& json) {
    return json.dump(2, ' ', false, Json::error_handler_t::replace) + "\n";
}

/// One line for each thing that fell short, the worst first; no more than some.
void warnOfFailures(const StressDocument& document) {
    constexpr size_t shown = 10;
    std::vector<const StressResult*> failed;
    for (const StressResult& r : document.results)
        if (r.forbidden() > 0) failed.push_back(&r);
    std::stable_sort(failed.begin(), failed.end(),
                     [](const auto* a, const auto* b) { return a->forbidden() > b->forbidden(); });
    for (size_t i = 0; i < std::min(shown, failed.size()); ++i)
        log::warn("fell short: case {}, {} on {}: {}", failed[i]->number, failed[i]->name(), failed[i]->device,
                  describeFailure(document, *failed[i]));
    if (failed.size() > shown) log::warn("fell short: and {} more; see --verbose or --json", failed.size() - shown);
    for (const ControlResult& r : document.controls)
        if (!r.fails)
            log::warn("fell short: control of case {}, {}: {}", r.control.number, r.control.method, describeFailure(r));
}

/// Throws what stopped the first device that did not run all, for the exit code; of others a warning tells.
void tellOfStops(const StressDocument& document) {
    const StressDevice* first = nullptr;
    for (const StressDevice& device : document.devices) {
        if (device.stopped && first != nullptr) log::warn("{}", device.stopped->what());
        if (device.stopped && first == nullptr) first = &device;
    }
    if (first != nullptr) throw Error(*first->stopped);
}

void makeFolder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !std::filesystem::is_directory(folder, error))
        throw inputError(folder, "cannot be made a folder; name another one for the results");
}

}  // namespace

int stress(const Options& options) {
    return stress(options, StressMakers{});
}

int stress(const Options& options, const StressMakers& makers) {
    const auto start = std::chrono::steady_clock::now();
    StressDocument document;
    document.version = RAIG_VERSION;
    document.processor = processorName();
    document.threads = threadCount();
    document.command = commandOf(options, /* forReplay= */ false);
    document.replay = commandOf(options, /* forReplay= */ true);
    document.seed = options.seed;
    document.cases = chooseCases(options);
    document.commit = commitId();
    for (const hard::NotRun& one : hard::notRun())
        if (options.cases.empty() || std::count(options.cases.begin(), options.cases.end(), one.number) > 0)
            document.notRun.push_back(one);
    if (options.ray && document.cases.size() != 1) throw usageError("--ray is a ray of one case; name that by --case");
    const std::vector<Variant> variants = chooseVariants(options);
    const std::vector<Control> controls = chooseControls(options, document.cases);
    if (!options.folder.empty()) makeFolder(options.folder);

    std::vector<Json> arithmetic;
    std::optional<StressReplay> replay;
    if (!options.onlyControls) {
        const std::vector<std::optional<DeviceInfo>> devices = chooseDevices(options);
        for (const std::optional<DeviceInfo>& info : devices) {
            document.devices.push_back(describeDevice(info, devices));
            runOn(info, options, makers, variants, document, arithmetic, replay);
        }
    }
    runControls(options, controls, document);
    document.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();

    const std::string json = textOf(toJson(document, arithmetic, replay));
    if (!options.folder.empty()) {
        write(options.folder / "stress.json", json);
        write(options.folder / "index.html", stressPage(document));
        log::note("wrote {} and stress.json beside it", (options.folder / "index.html").string());
    }
    if (!options.junit.empty()) write(options.junit, toJUnit(document));
    const uint64_t forbidden = document.forbidden();
    if (options.json) {
        std::fputs(json.c_str(), stdout);
    } else {
        if (replay)
            printReplay(document, *replay, *options.ray);
        else if (!document.results.empty())
            printResults(document, options.verbose);
        printControls(document);
        printNotRun(document);
        if (!document.results.empty()) fmt::print("\n{} of {} answers are wrong", forbidden, document.rays());
        if (!document.controls.empty())
            fmt::print("{}{} of {} controls fail as they should", document.results.empty() ? "\n" : "; ",
                       document.controls.size() - document.brokenControls(), document.controls.size());
        fmt::print("; {:.1f} s\n", document.seconds);
    }
    warnOfFailures(document);
    tellOfStops(document);
    return static_cast<int>(document.fellShort() ? ExitCode::fellShort : ExitCode::done);
}

}  // namespace raig
