/// What a comparison is held to: bounds of its metrics, by the names that these have in its JSON.
#pragma once

#include "measure/compare_scene.hpp"

#include <string>
#include <string_view>
#include <utility>
#include <vector>

namespace raig {

struct CompareMetric {
    std::string_view name;  ///< of numbers within others: joined by _, but for `hits` and `pixels`, which stay unsaid
    bool largerIsBetter = false;
    bool ofScenesOnly = false;  ///< two pictures have none
};

/// All there are, those of pictures first.
std::span<const CompareMetric> compareMetrics();

/// The names of those that pictures have, or of all.
std::vector<std::string_view> compareMetricNames(bool ofScenes);

/// Null if there is none of that name.
const CompareMetric* findCompareMetric(std::string_view name);

/// The most that a metric may be; of one where larger is better, the least.
struct Bound {
    const CompareMetric* metric;
    double limit;
};

/// What a scene is held to: `given`, and for metrics that have none there: no ray missed, phantom or wrong; offset_max 1; no
/// pixel that is not finite; rmse 1e-3; and `different` 0 where the device's arithmetic is IEEE.
std::vector<Bound> sceneBounds(std::span<const Bound> given, const SceneComparison& scene);

struct CheckedBound {
    Bound bound;
    double value;

    /// A NaN keeps no bound.
    bool isKept() const;
    /// "rmse at most 0.001"
    std::string text() const;
    /// "rmse is 0.25; allowed: at most 0.001"; empty if the bound is kept.
    std::string failure() const;
};

using MetricValues = std::vector<std::pair<std::string_view, double>>;

/// The metrics of pictures, by their names: NaN where no pixel was compared, as agreement about nothing is none.
MetricValues valuesOf(const PictureDifference& pictures);

/// In the order of `bounds`. Of no pixel, what is measured of pixels is NaN. Pictures: requires bounds that they have.
std::vector<CheckedBound> checkBounds(std::span<const Bound> bounds, const PictureDifference& pictures);
std::vector<CheckedBound> checkBounds(std::span<const Bound> bounds, const SceneComparison& scene);

}  // namespace raig
