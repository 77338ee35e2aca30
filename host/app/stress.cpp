// `raig stress`: the hard cases, for every structure, by exact arithmetic; and controls that must fail.
#include "app/commands.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "app/stress_json.hpp"
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

constexpr uint32_t longTimes = 30;

/// The devices to run on; nothing means the CPU path.
std::vector<std::optional<DeviceInfo>> chooseDevices(const Options& options) {
    if (options.device != "all") return {chooseDevice(options.device)};
    std::vector<std::optional<DeviceInfo>> devices;
    for (const DeviceInfo& info : listDevices()) devices.emplace_back(info);
    devices.emplace_back();
    return devices;
}

/// Without options of one structure: all ways to walk, or all there are; with them: this one.
std::vector<Variant> chooseVariants(const Options& options) {
    BuildParams own = options.buildParams;
    own.memoryBudget = BuildParams{}.memoryBudget;  // every structure's
    const std::string given = describeOptions(own);
    if (!given.empty() && (!options.accelGiven || options.accel == "all"))
        throw usageError("{}: options are a structure's; name it by --accel", given);
    if (!given.empty()) {
        const Variant one{options.accel, options.buildParams};
        one.build({});  // refuses what the structure does not offer
        return {one};
    }
    std::vector<Variant> variants = options.isLong ? allVariants(/* thorough= */ true) : walkVariants();
    std::erase_if(variants, [&](const Variant& variant) {
        return variant.structure == "brute" ||
               (options.accelGiven && options.accel != "all" && variant.structure != options.accel);
    });
    for (Variant& variant : variants) variant.params.memoryBudget = options.buildParams.memoryBudget;
    return variants;
}

std::vector<hard::Case> chooseCases(const Options& options) {
    if (options.cases.empty()) return hard::allCases();
    std::vector<uint32_t> numbers = options.cases;
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    std::vector<hard::Case> cases;
    for (const uint32_t number : numbers) cases.push_back(hard::caseOf(number));
    return cases;
}

/// As a shell takes it for one word.
std::string quoted(const std::string& text) {
    const bool isPlain = !text.empty() && std::all_of(text.begin(), text.end(), [](unsigned char c) {
        return std::isalnum(c) || std::string_view("-_./:=,").find(static_cast<char>(c)) != std::string_view::npos;
    });
    if (isPlain) return text;
    std::string word = "'";
    for (const char c : text) word += c == '\'' ? "'\\''" : std::string(1, c);
    return word + "'";
}

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

/// What of no device is known. `others`: all there are in the run; where one has the same name, the index is told, too.
StressDevice describeDevice(const std::optional<DeviceInfo>& info, const std::vector<std::optional<DeviceInfo>>& others) {
    if (!info) return {"cpu", "", "", "cpu", {}};
    const auto same = std::count_if(others.begin(), others.end(),
                                    [&](const auto& other) { return other && other->name == info->name; });
    return {same > 1 ? fmt::format("{} ({})", info->name, info->index) : info->name, info->driver, "",
            std::to_string(info->index), {}};
}

/// A device that cannot be opened answers no ray: so the first case says, and the run goes on with the others.
StressSubject unopened(const Error& error) {
    return {"brute", "", [error](const hard::Scene&) -> AnswerRays { throw error; }};
}

/// Runs the cases on one device, the last of the document's.
void runOn(const std::optional<DeviceInfo>& info, const Options& options, const std::vector<Variant>& variants,
           StressDocument& document, std::vector<Json>& arithmetic, std::optional<StressReplay>& replay) {
    std::unique_ptr<Device> device;
    std::optional<Error> failure;
    try {
        if (info) device = std::make_unique<Device>(*info);
    } catch (const Error& error) {
        failure = error;
    }
    const MeasuredArithmetic measured = failure  ? MeasuredArithmetic{std::nullopt, failure->what()}
                                        : device ? measureArithmetic(*device)
                                                 : MeasuredArithmetic{measureHostArithmetic(), ""};
    document.devices.back().arithmetic = describe(measured);
    arithmetic.push_back(toJson(measured));
    const Variant brute{"brute", {}};
    StressSettings settings{.cases = document.cases,
                            .draw = {.seed = options.seed, .times = options.isLong ? longTimes : 1},
                            .rays = options.rayCount,
                            .ray = options.ray,
                            .device = document.devices.back().name,
                            .deviceNumber = document.devices.size() - 1,
                            .brute = failure ? unopened(*failure) : subjectOf(brute, device.get()),
                            .bruteOnCpu = {},
                            .subjects = {}};
    for (const Variant& variant : variants) settings.subjects.push_back(subjectOf(variant, device.get()));
    // Where the device computes as the CPU does, down to denormals, it must find what that finds.
    if (device && measured.arithmetic && measured.arithmetic->ieee() && measured.arithmetic->denormals == "kept")
        settings.bruteOnCpu = subjectOf(brute, nullptr);
    Progress progress("stress");
    const std::string prefix = options.device == "all" ? document.devices.back().name.substr(0, 12) + ", " : "";
    StressReport report =
        raig::stress(settings, [&](const std::string& step, double done) { progress.update(prefix + step, done); });
    document.results.insert(document.results.end(), report.results.begin(), report.results.end());
    document.devices.back().stopped = report.stopped;
    if (replay && report.replay)
        replay->answers.insert(replay->answers.end(), report.replay->answers.begin(), report.replay->answers.end());
    else if (report.replay)
        replay = std::move(report.replay);
}

/// Those of the cases; none with one ray, which are for the structures only.
std::vector<Control> chooseControls(const Options& options, const std::vector<hard::Case>& cases) {
    if (options.onlyControls && options.ray)
        throw usageError("--ray is for structures, and --controls runs none; leave out one of them");
    if (options.ray) return {};
    std::vector<Control> controls = allControls();
    std::erase_if(controls, [&](const Control& control) {
        return std::none_of(cases.begin(), cases.end(),
                            [&](const hard::Case& one) { return one.number == control.number; });
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
    const auto start = std::chrono::steady_clock::now();
    StressDocument document;
    document.version = RAIG_VERSION;
    document.processor = processorName();
    document.threads = threadCount();
    document.command = commandOf(options, /* forReplay= */ false);
    document.replay = commandOf(options, /* forReplay= */ true);
    document.seed = options.seed;
    document.cases = chooseCases(options);
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
            runOn(info, options, variants, document, arithmetic, replay);
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
