#include "measure/compare_bounds.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raig {

namespace {

constexpr CompareMetric metrics[] = {
    {.name = "rmse"},
    {.name = "relmse"},
    {.name = "psnr", .largerIsBetter = true},
    {.name = "ssim", .largerIsBetter = true},
    {.name = "flip_mean"},
    {.name = "flip_p99"},
    {.name = "flip_max"},
    {.name = "max"},
    {.name = "nan"},
    {.name = "same", .largerIsBetter = true, .ofScenesOnly = true},
    {.name = "tie", .ofScenesOnly = true},
    {.name = "missed", .ofScenesOnly = true},
    {.name = "phantom", .ofScenesOnly = true},
    {.name = "wrong", .ofScenesOnly = true},
    {.name = "different", .ofScenesOnly = true},
    {.name = "t_ulp_median", .ofScenesOnly = true},
    {.name = "t_ulp_p99", .ofScenesOnly = true},
    {.name = "t_ulp_max", .ofScenesOnly = true},
    {.name = "offset_max", .ofScenesOnly = true},
    {.name = "ties", .ofScenesOnly = true},
    {.name = "discarded_weight_mean", .ofScenesOnly = true},
    {.name = "discarded_weight_max", .ofScenesOnly = true},
};

MetricValues valuesOf(const SceneComparison& scene) {
    MetricValues values = valuesOf(scene.pixels.outsideTies);
    for (size_t i = 0; i < hitClassNames.size(); ++i)
        values.emplace_back(hitClassNames[i], static_cast<double>(scene.all.counts[i]));
    const Spread& t = scene.all.tUlp;
    values.insert(values.end(), {{"different", scene.bits ? static_cast<double>(scene.bits->different) : 0.0},
                                 {"t_ulp_median", t.median},
                                 {"t_ulp_p99", t.p99},
                                 {"t_ulp_max", t.max},
                                 {"offset_max", scene.all.offset.max},
                                 {"ties", static_cast<double>(scene.pixels.ties)},
                                 {"discarded_weight_mean", scene.discardedMean},
                                 {"discarded_weight_max", scene.discardedMax}});
    return values;
}

std::vector<CheckedBound> check(std::span<const Bound> bounds, const MetricValues& values) {
    std::vector<CheckedBound> checked;
    for (const Bound& bound : bounds) {
        const auto value =
            std::find_if(values.begin(), values.end(), [&](const auto& one) { return one.first == bound.metric->name; });
        RAIG_CHECK(value != values.end());
        checked.push_back({bound, value->second});
    }
    return checked;
}

/// Counts in full, all else in six digits.
std::string textOf(double value) {
    const bool isCount = value == std::floor(value) && std::abs(value) < 1e15;
    return isCount ? fmt::format("{:.0f}", value) : fmt::format("{:.6g}", value);
}

std::string limitText(const Bound& bound) {
    return fmt::format("{} {}", bound.metric->largerIsBetter ? "at least" : "at most", textOf(bound.limit));
}

}  // namespace

MetricValues valuesOf(const PictureDifference& d) {
    const auto of = [&](double value) { return d.pixels > 0 ? value : std::numeric_limits<double>::quiet_NaN(); };
    return {{"rmse", of(d.rmse)},
            {"relmse", of(d.relmse)},
            {"psnr", of(d.psnr)},
            {"ssim", of(d.ssim)},
            {"flip_mean", of(d.flipMean)},
            {"flip_p99", of(d.flipP99)},
            {"flip_max", of(d.flipMax)},
            {"max", of(d.max)},
            {"nan", static_cast<double>(d.nan)}};
}

std::span<const CompareMetric> compareMetrics() {
    return metrics;
}

std::vector<std::string_view> compareMetricNames(bool ofScenes) {
    std::vector<std::string_view> names;
    for (const CompareMetric& metric : metrics)
        if (ofScenes || !metric.ofScenesOnly) names.push_back(metric.name);
    return names;
}

const CompareMetric* findCompareMetric(std::string_view name) {
    const auto* const found =
        std::find_if(std::begin(metrics), std::end(metrics), [&](const CompareMetric& one) { return one.name == name; });
    return found == std::end(metrics) ? nullptr : found;
}

std::vector<Bound> sceneBounds(std::span<const Bound> given, const SceneComparison& scene) {
    std::vector<Bound> bounds;
    const auto byDefault = [&](std::string_view name, double limit) {
        const bool isGiven =
            std::any_of(given.begin(), given.end(), [&](const Bound& one) { return one.metric->name == name; });
        if (!isGiven) bounds.push_back({findCompareMetric(name), limit});
    };
    byDefault("missed", 0.0);
    byDefault("phantom", 0.0);
    byDefault("wrong", 0.0);
    byDefault("offset_max", 1.0);
    if (scene.bits && scene.isIeee) byDefault("different", 0.0);
    byDefault("nan", 0.0);
    byDefault("rmse", 1e-3);
    bounds.insert(bounds.end(), given.begin(), given.end());
    return bounds;
}

bool CheckedBound::isKept() const {
    return bound.metric->largerIsBetter ? value >= bound.limit : value <= bound.limit;
}

std::string CheckedBound::text() const {
    return fmt::format("{} {}", bound.metric->name, limitText(bound));
}

std::string CheckedBound::failure() const {
    if (isKept()) return "";
    if (std::isnan(value)) return fmt::format("{} cannot be told; allowed: {}", bound.metric->name, limitText(bound));
    return fmt::format("{} is {}; allowed: {}", bound.metric->name, textOf(value), limitText(bound));
}

std::vector<CheckedBound> checkBounds(std::span<const Bound> bounds, const PictureDifference& pictures) {
    return check(bounds, valuesOf(pictures));
}

std::vector<CheckedBound> checkBounds(std::span<const Bound> bounds, const SceneComparison& scene) {
    return check(bounds, valuesOf(scene));
}

}  // namespace raig
