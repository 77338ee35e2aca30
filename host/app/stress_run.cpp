#include "app/stress_run.hpp"

#include "app/machine.hpp"
#include "app/progress.hpp"
#include "base/error.hpp"

#include <algorithm>
#include <set>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

constexpr uint32_t longTimes = 30;
constexpr uint32_t placesCase = 63;  // of meshes in several places

/// A device that cannot be opened answers no ray: so the first case says, and the run goes on with the others.
StressSubject unopened(const Error& error) {
    return {"brute", "", [error](const hard::Scene&) -> AnswerRays { throw error; }};
}

using Told = std::function<void(const std::string&, double)>;

hard::Draw drawOf(const Options& options) {
    return {.seed = options.seed, .times = options.isLong ? longTimes : 1};
}

bool hasCase(const StressDocument& document, uint32_t number) {
    return std::any_of(document.cases.begin(), document.cases.end(),
                       [&](const hard::Case& one) { return one.number == number; });
}

/// The first way to build and walk each structure, unless one structure was asked for: that all ways find the same is seen
/// by rays, which take less time than pictures do.
std::vector<Variant> onePerStructure(const Options& options, std::vector<Variant> variants) {
    if (options.accelGiven && options.accel != "all") return variants;
    std::set<std::string> seen;
    std::erase_if(variants, [&](const Variant& variant) { return !seen.insert(variant.structure).second; });
    return variants;
}

StressReport runRays(const Options& options, const StressMakers& makers, const std::vector<Variant>& variants,
                     const std::vector<hard::Case>& cases, const StressDocument& document, Device* device,
                     const std::optional<Error>& failure, bool isExact, const Told& progress) {
    const Variant brute{"brute", {}};
    StressSettings settings{.cases = cases,
                            .draw = drawOf(options),
                            .rays = options.rayCount,
                            .ray = options.ray,
                            .device = document.devices.back().name,
                            .deviceNumber = document.devices.size() - 1,
                            .brute = failure ? unopened(*failure) : makers.rays(brute, device),
                            .bruteOnCpu = {},
                            .subjects = {}};
    for (const Variant& variant : variants) settings.subjects.push_back(makers.rays(variant, device));
    if (isExact) settings.bruteOnCpu = makers.rays(brute, nullptr);
    return raig::stress(settings, progress);
}

StressReport runPictures(const Options& options, const StressMakers& makers, const std::vector<Variant>& variants,
                         const StressDocument& document, Device* device, const Told& progress) {
    PictureSettings settings{.cases = hard::pictureCases(),
                             .draw = drawOf(options),
                             .device = document.devices.back().name,
                             .deviceNumber = document.devices.size() - 1,
                             .isDevice = device != nullptr,
                             .draws = device != nullptr && device->draws(),
                             .subjects = {makers.pictures({"brute", {}}, device)}};
    std::erase_if(settings.cases, [&](const hard::PictureCase& one) { return !hasCase(document, one.number); });
    for (const Variant& variant : onePerStructure(options, variants))
        settings.subjects.push_back(makers.pictures(variant, device));
    return stressPictures(settings, progress);
}

}  // namespace

std::vector<hard::Case> chooseCases(const Options& options) {
    if (options.cases.empty()) return hard::allCasesOfAnyKind();
    std::vector<uint32_t> numbers = options.cases;
    std::sort(numbers.begin(), numbers.end());
    numbers.erase(std::unique(numbers.begin(), numbers.end()), numbers.end());
    const std::vector<hard::Case> all = hard::allCasesOfAnyKind();
    std::vector<hard::Case> cases;
    for (const uint32_t number : numbers) {
        const bool isThere =
            std::any_of(all.begin(), all.end(), [&](const hard::Case& one) { return one.number == number; });
        for (const hard::NotRun& one : hard::notRun())
            if (!isThere && one.number == number)
                throw usageError("--case {}: {}: not run, as {}", number, one.what, one.why);
        cases.push_back(hard::caseOf(number));
        if (options.ray && !cases.back().isOfRays())
            throw usageError("--ray: case {} is not one of single rays; leave that out", number);
    }
    return cases;
}

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

std::vector<std::optional<DeviceInfo>> chooseDevices(const Options& options) {
    if (options.device != "all") return {chooseDevice(options.device)};
    std::vector<std::optional<DeviceInfo>> devices;
    for (const DeviceInfo& info : listDevices()) devices.emplace_back(info);
    devices.emplace_back();
    return devices;
}

StressDevice describeDevice(const std::optional<DeviceInfo>& info, const std::vector<std::optional<DeviceInfo>>& others) {
    if (!info) return {"cpu", "", "", "cpu", {}};
    const auto same =
        std::count_if(others.begin(), others.end(), [&](const auto& other) { return other && other->name == info->name; });
    return {same > 1 ? fmt::format("{} ({})", info->name, info->index) : info->name,
            info->driver,
            "",
            std::to_string(info->index),
            {}};
}

void runOn(const std::optional<DeviceInfo>& info, const Options& options, const StressMakers& makers,
           const std::vector<Variant>& variants, StressDocument& document, std::vector<Json>& arithmetic,
           std::optional<StressReplay>& replay) {
    std::unique_ptr<Device> device;
    std::optional<Error> failure;
    try {
        if (info) device = std::make_unique<Device>(*info, DeviceOptions{.graphics = info->features.graphics});
    } catch (const Error& error) {
        failure = error;
    }
    const MeasuredArithmetic measured = failure  ? MeasuredArithmetic{std::nullopt, failure->what()}
                                        : device ? measureArithmetic(*device)
                                                 : MeasuredArithmetic{measureHostArithmetic(), ""};
    StressDevice& here = document.devices.back();
    here.arithmetic = describe(measured);
    arithmetic.push_back(toJson(measured));
    // Where the device computes as the CPU does, down to denormals, it must find what that finds.
    const bool isExact =
        device && measured.arithmetic && measured.arithmetic->ieee() && measured.arithmetic->denormals == "kept";
    Progress progress("stress");
    const std::string prefix = options.device == "all" ? here.name.substr(0, 12) + ", " : "";
    const auto take = [&](StressReport report) {
        document.results.insert(document.results.end(), report.results.begin(), report.results.end());
        if (!here.stopped) here.stopped = report.stopped;
        if (replay && report.replay)
            replay->answers.insert(replay->answers.end(), report.replay->answers.begin(), report.replay->answers.end());
        else if (report.replay)
            replay = std::move(report.replay);
    };
    std::vector<hard::Case> ofRays = document.cases, ofPlaces;
    std::erase_if(ofRays, [&](const hard::Case& one) { return !one.isOfRays(); });
    // Kernels for two levels are others than for one, and take long to be loaded.
    if (!options.isLong)
        std::erase_if(ofRays, [&](const hard::Case& one) {
            if (one.number == placesCase) ofPlaces.push_back(one);
            return one.number == placesCase;
        });
    take(runRays(options, makers, variants, ofRays, document, device.get(), failure, isExact,
                 [&](const std::string& step, double done) { progress.update(prefix + step, 0.8 * done); }));
    if (failure && !here.stopped) here.stopped = failure;
    if (!here.stopped)
        take(runRays(options, makers, onePerStructure(options, variants), ofPlaces, document, device.get(), failure, isExact,
                     [&](const std::string& step, double) { progress.update(prefix + step, 0.8); }));
    if (!here.stopped)
        take(runPictures(options, makers, variants, document, device.get(),
                         [&](const std::string& step, double done) { progress.update(prefix + step, 0.8 + 0.2 * done); }));
    if (!here.stopped && hasCase(document, 62))
        take(stressCorruption(onePerStructure(options, variants), makers.corrupt(device.get()), drawOf(options), here.name,
                              document.devices.size() - 1));
}

}  // namespace raig
