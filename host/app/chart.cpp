// `raig chart`: speed against accuracy, as figures, data and one page.
#include "measure/chart.hpp"

#include "app/command_text.hpp"
#include "app/commands.hpp"
#include "app/machine.hpp"
#include "app/progress.hpp"
#include "base/error.hpp"
#include "base/files.hpp"
#include "base/log.hpp"

#include <chrono>
#include <cstdio>

namespace raig {

namespace {

void write(const std::filesystem::path& file, const std::string& text) {
    writeFileAtomically(file, std::as_bytes(std::span(text)));
}

std::string readText(const std::filesystem::path& file) {
    const std::vector<std::byte> bytes = readFile(file, size_t{16} << 20);
    return {reinterpret_cast<const char*>(bytes.data()), bytes.size()};
}

/// raig's own figures and those of --sweep; of them all, those of --figure.
std::vector<Sweep> chooseSweeps(const Options& options) {
    std::vector<Sweep> sweeps = readSweeps(std::string(builtInSweeps()), "figures.json");
    for (const std::filesystem::path& file : options.sweeps)
        for (Sweep& sweep : readSweeps(readText(file), file.string())) {
            for (const Sweep& other : sweeps)
                if (other.name == sweep.name || sweep.name == "chart" || sweep.name == "sweeps")
                    throw inputError(file.string(),
                                     "\"{}\" is the name of another sweep, or of a file of raig's; give it one of its own",
                                     sweep.name);
            sweeps.push_back(std::move(sweep));
        }
    if (options.figures.empty()) return sweeps;
    std::vector<Sweep> chosen;
    for (const std::string& name : options.figures) {
        const auto known =
            std::find_if(sweeps.begin(), sweeps.end(), [&](const Sweep& sweep) { return sweep.name == name; });
        if (known == sweeps.end()) {
            std::vector<std::string> names;
            for (const Sweep& sweep : sweeps) names.push_back(sweep.name);
            throw usageError("--figure {}: there is no such figure; there are {}", name, fmt::join(names, ", "));
        }
        const auto isSame = [&](const Sweep& sweep) { return sweep.name == name; };
        if (std::none_of(chosen.begin(), chosen.end(), isSame)) chosen.push_back(*known);
    }
    return chosen;
}

/// A declaration must not be replaced by what is measured by it.
void checkSweepFiles(const Options& options, const std::vector<Sweep>& sweeps) {
    std::vector<std::string> written = {"sweeps", "chart"};
    for (const Sweep& sweep : sweeps) written.push_back(sweep.name);
    for (const std::filesystem::path& file : options.sweeps)
        for (const std::string& name : written) {
            std::error_code ignored;
            const std::filesystem::path target = options.folder / (name + ".json");
            if (std::filesystem::equivalent(file, target, ignored))
                throw usageError("{} would be read and replaced: name another folder to write", target.string());
        }
}

/// A build of sources that no commit holds is told apart by when it was made.
std::string buildId() {
    const std::string commit(commitId());
    if (commit != "unknown" && commit.find("dirty") == commit.npos) return commit;
    std::error_code error;
    const auto made = std::filesystem::last_write_time("/proc/self/exe", error);
    return fmt::format("{} {}", commit, error ? 0 : made.time_since_epoch().count());
}

std::string commandOf(const Options& options) {
    std::string text = "raig chart";
    for (const std::filesystem::path& file : options.inputs) text += " " + quoted(file.string());
    for (const std::filesystem::path& file : options.sweeps) text += " --sweep " + quoted(file.string());
    for (const std::string& name : options.figures) text += " --figure " + name;
    if (options.device != "auto") text += " --device " + quoted(options.device);
    if (options.threads != 0) text += fmt::format(" --threads {}", options.threads);
    return text + fmt::format(" --seed {} -o {}", options.seed, quoted(options.folder.string()));
}

Json toJson(const ChartDocument& document) {
    Json json = {{"version", document.version},
                 {"commit", document.commit},
                 {"machine", {{"processor", document.processor}, {"threads", document.threads}}},
                 {"device", document.device},
                 {"driver", document.driver},
                 {"arithmetic", document.arithmetic},
                 {"flags", document.flags},
                 {"seed", document.seed},
                 {"command", document.command},
                 {"seconds", document.seconds},
                 {"pictures", Json::array()},
                 {"figures", Json::array()},
                 {"breaches", Json::array()}};
    for (const ChartPictures& one : document.pictures)
        json["pictures"].push_back({{"scene", one.scene}, {"numbers", one.numbers}});
    for (const ChartFigure& figure : document.figures) json["figures"].push_back(toJson(figure));
    for (const Breach& breach : document.breaches())
        json["breaches"].push_back({{"figure", breach.sweep}, {"scene", breach.scene}, {"what", breach.text}});
    return json;
}

void printFigures(const ChartDocument& document) {
    fmt::print("{:16} {:>7} {:>9} {:>7} {:>9}  {}\n", "figure", "points", "left out", "panels", "breaches", "title");
    for (const ChartFigure& figure : document.figures) {
        const auto leftOut = std::count_if(figure.points.begin(), figure.points.end(),
                                           [](const ChartPoint& point) { return !point.leftOut.empty(); });
        fmt::print("{:16} {:>7} {:>9} {:>7} {:>9}  {}\n", figure.sweep.name, figure.points.size(), leftOut,
                   figure.panels.size(), figure.breaches.size(), figure.sweep.title);
    }
    fmt::print("\n{} of what was measured lies outside its theoretical band; {:.0f} s\n", document.breaches().size(),
               document.seconds);
}

void makeFolder(const std::filesystem::path& folder) {
    std::error_code error;
    std::filesystem::create_directories(folder, error);
    if (error || !std::filesystem::is_directory(folder, error))
        throw inputError(folder, "cannot be made a folder; name another one for the chart");
}

}  // namespace

int chart(const Options& options) {
    const auto start = std::chrono::steady_clock::now();
    const std::optional<DeviceInfo> info = chooseDevice(options.device);
    ChartSettings settings{.scenes = options.inputs,
                           .folder = options.folder,
                           .sweeps = chooseSweeps(options),
                           .device = nullptr,
                           .seed = options.seed,
                           .identity = ""};
    std::unique_ptr<Device> device;
    if (info) device = std::make_unique<Device>(*info, DeviceOptions{.graphics = info->features.graphics});
    settings.device = device.get();
    const MeasuredArithmetic measured =
        device ? measureArithmetic(*device) : MeasuredArithmetic{measureHostArithmetic(), ""};

    ChartDocument document;
    document.version = RAIG_VERSION;
    document.commit = commitId();
    document.processor = processorName();
    document.threads = threadCount();
    document.device = info ? info->name : "cpu";
    document.driver = info ? info->driver : "";
    document.arithmetic = describe(measured);
    document.flags = "-ffp-contract=off -fno-fast-math";
    document.seed = options.seed;
    document.command = commandOf(options);
    settings.identity = fmt::format("raig {} {}, {} {}, {} threads of {}, seed {}", RAIG_VERSION, buildId(), document.device,
                                    document.driver, document.threads, document.processor, options.seed);

    checkSweepFiles(options, settings.sweeps);
    makeFolder(options.folder);
    if (options.fresh) std::filesystem::remove(options.folder / "points.jsonl");
    {
        Progress progress("chart");
        runChart(settings, document, [&](const std::string& step, double done) { progress.update(step, done); });
    }
    document.seconds = std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
    const std::string json = toJson(document).dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
    write(options.folder / "chart.json", json);
    write(options.folder / "sweeps.json", std::string(builtInSweeps()));
    write(options.folder / "index.html", chartPage(document));
    log::note("wrote {} and what it shows beside it", (options.folder / "index.html").string());
    if (options.json)
        std::fputs(json.c_str(), stdout);
    else
        printFigures(document);
    for (const ChartFigure& figure : document.figures)
        if (figure.panels.empty())
            log::warn("{}: nothing is drawn, as {}", figure.sweep.name,
                      figure.points.empty() ? "no scene is what it is for" : "no point has what its axes ask for");
    const std::vector<Breach> breaches = document.breaches();
    for (const Breach& breach : breaches)
        log::warn("fell short: {}{}{}: {}", breach.sweep, breach.scene.empty() ? "" : ", ", breach.scene, breach.text);
    return static_cast<int>(breaches.empty() ? ExitCode::done : ExitCode::fellShort);
}

}  // namespace raig
