#include "app/compare_options.hpp"

#include "app/option_parts.hpp"
#include "base/error.hpp"

#include <fmt/ranges.h>
#include <CLI/CLI.hpp>

#include <cmath>

namespace raig {

namespace {

std::optional<double> finiteNumber(std::string_view text) {
    const std::optional<double> value = numberOf<double>(text);
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// "rmse=0.01". `option`: --fail-above or --fail-below, of which only one suits a metric.
Bound parseBound(const std::string& option, bool below, const std::string& text) {
    const size_t equals = text.find('=');
    const std::string name = text.substr(0, equals);
    const CompareMetric* const metric = findCompareMetric(name);
    if (metric == nullptr)
        throw usageError("{} {}: METRIC=VALUE is wanted, METRIC one of {}", option, text,
                         fmt::join(compareMetricNames(/* ofScenes= */ true), ", "));
    const std::optional<double> limit = equals == text.npos ? std::nullopt : finiteNumber(text.substr(equals + 1));
    if (!limit) throw usageError("{} {}: a number is wanted after {}=, as {}=0.01", option, text, name, name);
    if (metric->largerIsBetter && !below)
        throw usageError("{} {}: the more {}, the better; write --fail-below {}", option, text, name, text);
    if (!metric->largerIsBetter && below)
        throw usageError("{} {}: the less {}, the better; write --fail-above {}", option, text, name, text);
    return {metric, *limit};
}

std::string namesOf(bool largerIsBetter, bool ofScenesOnly) {
    std::vector<std::string_view> names;
    for (const CompareMetric& metric : compareMetrics())
        if (metric.largerIsBetter == largerIsBetter && metric.ofScenesOnly == ofScenesOnly) names.push_back(metric.name);
    return fmt::format("{}", fmt::join(names, ", "));
}

void addBounds(CLI::App& command, Options& options, const std::string& name, bool below, const std::string& description) {
    const auto append = [&options, name, below](const std::vector<std::string>& texts) {
        for (const std::string& text : texts) options.bounds.push_back(parseBound(name, below, text));
    };
    command.add_option_function<std::vector<std::string>>(name, append, description)
        ->type_name("METRIC=VALUE")
        ->allow_extra_args(false)
        ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
}

}  // namespace

void addCompareOptions(CLI::App& command, Options& options) {
    addBounds(command, options, "--fail-above", false,
              fmt::format("exit with 1 if the metric is larger, or no number; of pictures {}; of scenes {} as well; may be "
                          "given several times",
                          namesOf(false, false), namesOf(false, true)));
    addBounds(command, options, "--fail-below", true,
              fmt::format("the same if it is smaller: {}; of scenes {} as well", namesOf(true, false), namesOf(true, true)));
    const auto parsePpd = [&options](const std::string& text) {
        const std::optional<double> value = finiteNumber(text);
        if (!value || !(*value >= 1.0 && *value <= 1000.0))
            throw usageError("--ppd {}: a number of pixels from 1 to 1000 is wanted", text);
        options.pixelsPerDegree = *value;
    };
    command
        .add_option_function<std::string>("--ppd", parsePpd,
                                          "pixels per degree of the eye, for FLIP (default: 67.02, those of a screen of "
                                          "0.7 m and 3840 pixels, 0.7 m away)")
        ->type_name("X");
    command.add_option("--junit", options.junit, "write the bounds and whether they are kept as JUnit's XML to this file")
        ->type_name("FILE");
}

void checkOptionsOfPictures(const CLI::App& command) {
    for (const CLI::Option* option : command.get_options())
        if (option->count() > 0 && option->get_group() == optionsOfScenes)
            throw usageError("{}: is of scenes; two pictures are compared as they are", option->get_name());
}

void checkBoundsOfPictures(const Options& options) {
    for (const auto& [metric, limit] : options.bounds)
        if (metric->ofScenesOnly)
            throw usageError("--fail-{} {}={}: is of scenes; pictures have {}", metric->largerIsBetter ? "below" : "above",
                             metric->name, limit, fmt::join(compareMetricNames(/* ofScenes= */ false), ", "));
    if (options.bounds.empty() && !options.junit.empty())
        throw usageError(
            "--junit: two pictures are held to nothing of themselves; give a bound by --fail-above or "
            "--fail-below");
}

}  // namespace raig
