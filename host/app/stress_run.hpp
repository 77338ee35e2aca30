/// The cases of `raig stress`, run on one device after the other.
#pragma once

#include "app/options.hpp"
#include "measure/stress_page.hpp"
#include "measure/stress_pictures.hpp"

#include <nlohmann/json.hpp>

#include <optional>
#include <vector>

namespace raig {

/// Who answers: structures as they are; tests put others in their places. No device means the CPU.
struct StressMakers {
    std::function<StressSubject(const Variant&, Device*)> rays = subjectOf;
    std::function<PictureSubject(const Variant&, Device*)> pictures = pictureSubjectOf;
    std::function<TraceCorrupt(Device*)> corrupt = corruptTraceOf;
};

/// The command, with these. `raig stress` is that with structures as they are.
int stress(const Options& options, const StressMakers& makers);

/// Those that --case names, by number; all if it is not given. Throws usageError for one that is not there, or not yet.
std::vector<hard::Case> chooseCases(const Options& options);

/// Without options of one structure: all ways to walk, or all there are; with them: this one.
std::vector<Variant> chooseVariants(const Options& options);

/// The devices to run on; nothing means the CPU path.
std::vector<std::optional<DeviceInfo>> chooseDevices(const Options& options);

/// What of no device is known. `others`: all there are in the run; where one has the same name, the index is told, too.
StressDevice describeDevice(const std::optional<DeviceInfo>& info, const std::vector<std::optional<DeviceInfo>>& others);

/// Runs the document's cases on one device, the last of the document's: adds its results, and its arithmetic.
void runOn(const std::optional<DeviceInfo>& info, const Options& options, const StressMakers& makers,
           const std::vector<Variant>& variants, StressDocument& document, std::vector<nlohmann::ordered_json>& arithmetic,
           std::optional<StressReplay>& replay);

}  // namespace raig
