#include "measure/chart_points.hpp"

#include <algorithm>
#include <cmath>
#include <map>

namespace raig {

namespace {

bool isAbout(const Law& law, const ChartPoint& point) {
    for (const auto& [name, value] : law.where.items()) {
        const bool same = value.is_string() ? nameOf(point, name) == value.get<std::string>()
                                            : valueOf(point, name) == std::optional(value.get<double>());
        if (!same) return false;
    }
    return point.leftOut.empty() && point.measures.contains(law.measure);
}

std::string placeOf(const ChartPoint& point, const std::vector<std::string>& without = {}) {
    const std::string settings = describeSettings(point.settings, without);
    return settings.empty() ? "" : " at " + settings;
}

/// What is wrong with one point; empty if nothing is.
std::string faultOf(const Law& law, const ChartPoint& point) {
    const auto value = valueOf(point, law.measure);
    if (!value || !std::isfinite(*value)) return fmt::format("{} is not finite{}", law.measure, placeOf(point));
    const std::optional<double> bound = law.bound ? law.bound : valueOf(point, law.boundMeasure);
    if (!bound) return fmt::format("{} was not measured{}", law.boundMeasure, placeOf(point));
    const std::string name = law.bound ? "" : " (" + law.boundMeasure + ")";
    if (law.kind == Law::Kind::most && !(*value <= *bound + law.plus))
        return fmt::format("{} is {:.4g}{}; at most {:.4g}{} may be", law.measure, *value, placeOf(point), *bound, name);
    const double allowed = law.within * std::abs(*bound) + law.plus;
    if (law.kind == Law::Kind::equals && !(std::abs(*value - *bound) <= allowed))
        return fmt::format("{} is {:.6g}{}; {:.6g}{} to within {:.2g} is right", law.measure, *value, placeOf(point), *bound,
                           name, allowed);
    return "";
}

void addPointBreaches(const Sweep& sweep, const Law& law, const std::vector<ChartPoint>& points,
                      std::vector<Breach>& breaches) {
    for (const ChartPoint& point : points) {
        if (!isAbout(law, point)) continue;
        const std::string fault = faultOf(law, point);
        if (!fault.empty()) breaches.push_back({sweep.name, point.scene, fault + ": " + law.because});
    }
}

/// The slope of the line through (log x, log y) that has the least squares; nothing of fewer than three places.
std::optional<double> slopeOf(const std::map<double, double>& places) {
    if (places.size() < 3) return std::nullopt;
    double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0;
    const double n = double(places.size());
    for (const auto& [at, value] : places) {
        x += std::log(at) / n;
        y += std::log(value) / n;
    }
    for (const auto& [at, value] : places) {
        xx += (std::log(at) - x) * (std::log(at) - x);
        xy += (std::log(at) - x) * (std::log(value) - y);
    }
    return xy / xx;
}

void addSlopeBreaches(const Sweep& sweep, const Law& law, const std::vector<ChartPoint>& points,
                      std::vector<Breach>& breaches) {
    struct Series {
        const ChartPoint* first;
        std::map<double, double> places;
        bool isExact = true;  ///< it is 0 everywhere: no slope is needed
    };
    std::map<std::string, Series> all;
    for (const ChartPoint& point : points) {
        const auto x = valueOf(point, law.over), y = valueOf(point, law.measure);
        if (!isAbout(law, point) || !x || !y || !(*x > 0.0) || !(*y >= 0.0)) continue;
        const std::string label = nameOf(point, "label");
        Series& one = all[point.scene + '\n' + (label.empty() ? describeSettings(point.settings, {law.over}) : label)];
        one.first = &point;
        if (*y == 0.0) continue;  // has no logarithm
        one.isExact = false;
        one.places[*x] = *y;
    }
    for (const auto& [name, one] : all) {
        if (one.isExact) continue;
        const std::optional<double> slope = slopeOf(one.places);
        if (slope && *slope >= law.least && *slope <= law.greatest) continue;
        breaches.push_back(
            {sweep.name, one.first->scene,
             fmt::format("{}{}; {} to {} is right: {}",
                         slope ? fmt::format("the slope of {} over {} is {:.3f}", law.measure, law.over, *slope)
                               : fmt::format("{} has no slope over {}: too few points", law.measure, law.over),
                         placeOf(*one.first, {law.over}), law.least, law.greatest, law.because)});
    }
}

}  // namespace

std::vector<Breach> findBreaches(const Sweep& sweep, const std::vector<ChartPoint>& points) {
    std::vector<Breach> breaches;
    const bool isMeasured =
        std::any_of(points.begin(), points.end(), [](const auto& point) { return point.leftOut.empty(); });
    for (const Law& law : sweep.laws) {
        const auto isOfLaw = [&](const ChartPoint& point) { return isAbout(law, point); };
        if (isMeasured && std::none_of(points.begin(), points.end(), isOfLaw))
            breaches.push_back({sweep.name, "", fmt::format("no point tells of {}: {}", law.measure, law.because)});
        if (law.kind == Law::Kind::slope)
            addSlopeBreaches(sweep, law, points, breaches);
        else
            addPointBreaches(sweep, law, points, breaches);
    }
    return breaches;
}

}  // namespace raig
