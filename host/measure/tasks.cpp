#include "measure/tasks.hpp"

#include "base/error.hpp"
#include "measure/precision.hpp"
#include "measure/spawn_policies.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

/// Of measure/precision.hpp.
class PrecisionTask : public Task {
public:
    explicit PrecisionTask(const TaskSettings& settings) : seed_(settings.seed) {}

    bool needsScene() const override { return false; }
    void check(const Json& settings) const override {
        checkSettings(settings, "precision", {"offset"}, {"method"});
        const std::string method = textOf(settings, "method", "");
        const auto methods = precisionMethods();
        if (std::find(methods.begin(), methods.end(), method) == methods.end())
            throw usageError("there is no method \"{}\"; there are {}", method, fmt::join(methods, ", "));
        if (!(std::abs(numberOf(settings, "offset", 0.0)) <= 1e15))
            throw usageError("the setting \"offset\" takes 1e15 at most");
    }
    Json run(const ChartScene*, const Json& settings) override {
        const PrecisionFindings found =
            measurePrecision(textOf(settings, "method", ""), numberOf(settings, "offset", 0.0), seed_);
        return {{"nanoseconds", found.nanoseconds},
                {"missed", 1e6 * double(found.missed) / double(found.rays)},
                {"checked", found.rays}};
    }
    const Json& measures() const override {
        static const Json all = {
            {"nanoseconds", "ns a triangle test, one thread"}, {"missed", "missed, per 10⁶ rays"}, {"checked", "rays"}};
        return all;
    }

private:
    uint32_t seed_;
};

/// Of measure/spawn_policies.hpp.
class SpawnTask : public Task {
public:
    explicit SpawnTask(const TaskSettings& settings) : seed_(settings.seed) {}

    bool needsScene() const override { return false; }
    void check(const Json& settings) const override {
        checkSettings(settings, "spawn", {"size", "place", "gap"}, {"policy"});
        policyOf(settings);
        const SpawnScale scale = scaleOf(settings);
        if (!(scale.size >= 1e-9 && scale.size <= 1e9 && scale.place >= 0.0 && scale.place <= 1e4 * scale.size))
            throw usageError("the setting \"size\" takes 1e-9 to 1e9, and no less than 1e-4 of \"place\"");
        if (!(scale.gap >= 0.0 && scale.gap <= 1.0)) throw usageError("the setting \"gap\" takes a number from 0 to 1");
    }
    Json run(const ChartScene*, const Json& settings) override {
        const SpawnFindings found = judgeSpawning(policyOf(settings), scaleOf(settings), rays, seed_);
        return {{"self_hits", 100.0 * double(found.selfHits) / double(found.rays)},
                {"leaks", 100.0 * double(found.leaks) / double(found.rays)},
                {"checked", found.rays}};
    }
    const Json& measures() const override {
        static const Json all = {
            {"self_hits", "self-hits, %"}, {"leaks", "leaks, %"}, {"checked", "rays"}, {"size", "size of the body"}};
        return all;
    }

private:
    static constexpr uint64_t rays = 20'000;

    static SpawnPolicy policyOf(const Json& settings) {
        const std::string wanted = textOf(settings, "policy", "error bounds");
        std::vector<std::string> names;
        for (const SpawnPolicy policy : spawnPolicies) {
            if (wanted == nameOf(policy)) return policy;
            names.emplace_back(nameOf(policy));
        }
        throw usageError("there is no policy \"{}\"; there are {}", wanted, fmt::join(names, ", "));
    }
    static SpawnScale scaleOf(const Json& settings) {
        return {numberOf(settings, "size", 1.0), numberOf(settings, "place", 0.0), numberOf(settings, "gap", 1e-3)};
    }

    uint32_t seed_;
};

template <class Kind>
std::unique_ptr<Task> make(const TaskSettings& settings) {
    return std::make_unique<Kind>(settings);
}

constexpr std::pair<const char*, std::unique_ptr<Task> (*)(const TaskSettings&)> tasks[] = {
    {"trace", makeTraceTask}, {"picture", makePictureTask}, {"precision", make<PrecisionTask>}, {"spawn", make<SpawnTask>}};

}  // namespace

std::unique_ptr<Task> makeTask(const std::string& name, const TaskSettings& settings) {
    std::vector<std::string> names;
    for (const auto& [known, makeIt] : tasks) {
        if (name == known) return makeIt(settings);
        names.emplace_back(known);
    }
    throw usageError("there is no task \"{}\"; there are {}", name, fmt::join(names, ", "));
}

void checkNames(const Sweep& sweep, const Json& measures) {
    Json settings = {{"scene", ""}, {"label", ""}};
    for (const Json& point : sweep.settings) settings.update(point);
    const auto need = [&](const std::string& name, const char* where, bool isSetting, bool isMeasure) {
        if (name.empty() || (isSetting && settings.contains(name)) || (isMeasure && measures.contains(name))) return;
        const Json& known = isMeasure ? measures : settings;
        std::vector<std::string> names;
        for (const auto& [one, value] : known.items()) names.push_back(one);
        throw usageError("\"{}\" in {} is no {}; there are {}", name, where,
                         !isMeasure   ? "setting of its points"
                         : !isSetting ? "measure of its task"
                                      : "setting of its points, nor a measure of its task",
                         fmt::join(names, ", "));
    };
    for (const Drawing& drawing : sweep.drawings) {
        for (const std::string& name : {drawing.x, drawing.y}) need(name, "draw", true, true);
        for (const std::string& name : {drawing.band, drawing.theory, drawing.contour, drawing.hollow})
            need(name, "draw", false, true);
        for (const std::string& name : drawing.by) need(name, "by", true, false);
        for (const std::string& name : drawing.panels) need(name, "panels", true, false);
    }
    for (const Law& law : sweep.laws) {
        for (const std::string& name : {law.measure, law.boundMeasure}) need(name, "holds", false, true);
        need(law.over, "slope_over", true, true);
        for (const auto& [name, value] : law.where.items()) need(name, "where", true, false);
    }
    for (const std::string& name : sweep.measures) need(name, "measure", false, true);
}

double numberOf(const Json& settings, const std::string& name, double otherwise) {
    if (!settings.contains(name)) return otherwise;
    if (!settings[name].is_number()) throw usageError("the setting \"{}\" takes a number", name);
    return settings[name].get<double>();
}

std::string textOf(const Json& settings, const std::string& name, const std::string& otherwise) {
    if (!settings.contains(name)) return otherwise;
    if (!settings[name].is_string()) throw usageError("the setting \"{}\" takes a text", name);
    return settings[name].get<std::string>();
}

void checkSettings(const Json& settings, const std::string& task, std::initializer_list<const char*> numbers,
                   std::initializer_list<const char*> texts) {
    const auto isAmong = [](const std::string& name, const auto& names) {
        return std::any_of(names.begin(), names.end(), [&](const char* one) { return name == one; });
    };
    for (const auto& [name, value] : settings.items()) {
        if (isAmong(name, numbers))
            numberOf(settings, name, 0.0);
        else if (name == "label" || isAmong(name, texts))
            textOf(settings, name, "");
        else
            throw usageError("the task {} has no setting \"{}\"; it has {}, {}, label", task, name, fmt::join(numbers, ", "),
                             fmt::join(texts, ", "));
    }
}

}  // namespace raig
