#include "app/stress_json.hpp"

#include "measure/junit.hpp"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

using Json = nlohmann::ordered_json;

const char* whatOf(const StressDocument& document, uint32_t number) {
    const auto found = std::find_if(document.cases.begin(), document.cases.end(),
                                    [&](const hard::Case& one) { return one.number == number; });
    return found == document.cases.end() ? "" : found->what;
}

double perMillion(uint64_t count, uint64_t rays) {
    return rays == 0 ? 0.0 : 1e6 * double(count) / double(rays);
}

Json toJson(const StressDocument& document, const StressResult& r) {
    Json json = {
        {"case", r.number},   {"what", whatOf(document, r.number)}, {"structure", r.structure}, {"options", r.options},
        {"device", r.device}, {"device_number", r.deviceNumber},    {"rays", r.rays},           {"hits", r.hits},
        {"open", r.open},     {"forbidden", r.forbidden()},         {"counts", r.isOfPixels ? "pixels" : "rays"}};
    for (size_t fault = 1; fault < stressFaults; ++fault) json[stressFaultNames[fault]] = r.counts[fault];
    json["control"] = false;
    json["seed"] = document.seed;
    json["seconds"] = r.seconds;
    for (size_t fault = 1; fault < stressFaults; ++fault)
        json["per_million"][stressFaultNames[fault]] = perMillion(r.counts[fault], r.rays);
    json["examples"] = Json::array();
    for (const StressExample& example : r.examples)
        json["examples"].push_back({{"ray", example.ray},
                                    {"scene", example.scene},
                                    {"fault", stressFaultNames[static_cast<size_t>(example.fault)]},
                                    {"what", example.what},
                                    {"replay", document.replayOf(r, example.ray)}});
    return json;
}

Json toJson(const StressDocument& document, const ControlResult& r) {
    const ControlFindings& found = r.findings;
    const Json expected = r.control.hasRate() ? Json{{"low", r.control.low}, {"high", r.control.high}} : Json(nullptr);
    const bool isShare = !found.measured;
    return {{"case", r.control.number},
            {"what", whatOf(document, r.control.number)},
            {"structure", r.control.method},
            {"options", ""},
            {"device", "cpu"},
            {"rays", found.rays},
            {"missed", found.missed},
            {"phantom", found.phantom},
            {"wrong", found.wrong},
            {"hung", found.hung},
            {"error", 0},
            {"control", true},
            {"seed", document.seed},
            {"per_million",
             {{"missed", perMillion(found.missed, found.rays)},
              {"phantom", perMillion(found.phantom, found.rays)},
              {"wrong", perMillion(found.wrong, found.rays)},
              {"hung", perMillion(found.hung, found.rays)}}},
            {"percent", isShare ? Json(found.percent()) : Json(nullptr)},
            {"expected_percent", isShare ? expected : Json(nullptr)},
            {"rate", found.rate()},
            {"expected_rate", expected},
            {"unit", r.control.unit},
            {"fails_as_it_should", r.fails}};
}

/// Numbers that JSON has none for are strings.
Json toJson(float value) {
    if (std::isfinite(value)) return value;
    return std::isnan(value) ? "nan" : value < 0.0f ? "-inf" : "inf";
}

Json toJson(const vec3& v) {
    return {toJson(v.x), toJson(v.y), toJson(v.z)};
}

Json toJson(const Hit& hit) {
    if (hit.primitive == NO_HIT) return nullptr;
    return {{"primitive", hit.primitive}, {"t", toJson(hit.t)}, {"u", toJson(hit.u)}, {"v", toJson(hit.v)}};
}

Json toJson(const StressReplay& replay) {
    Json json = {{"scene", replay.scene},
                 {"triangles", replay.triangles},
                 {"origin", toJson(replay.ray.origin)},
                 {"direction", toJson(replay.ray.direction)},
                 {"t_min", toJson(replay.ray.tMin)},
                 {"t_max", toJson(replay.ray.tMax)},
                 {"exact", toJson(replay.exact)},
                 {"open", replay.open},
                 {"answers", Json::array()}};
    for (const StressReplay::Answer& answer : replay.answers) {
        Json faults = Json::array();
        for (const StressFault fault : answer.faults) faults.push_back(stressFaultNames[static_cast<size_t>(fault)]);
        json["answers"].push_back({{"structure", answer.structure},
                                   {"options", answer.options},
                                   {"device", answer.device},
                                   {"closest", toJson(answer.closest)},
                                   {"any", toJson(answer.any)},
                                   {"faults", faults},
                                   {"thrown", answer.thrown}});
    }
    return json;
}

}  // namespace

Json toJson(const StressDocument& document, const std::vector<Json>& arithmetic, const std::optional<StressReplay>& replay) {
    Json json = {{"version", document.version},
                 {"commit", document.commit},
                 {"machine", {{"processor", document.processor}, {"threads", document.threads}}},
                 {"command", document.command},
                 {"seed", document.seed},
                 {"seconds", document.seconds},
                 {"devices", Json::array()},
                 {"results", Json::array()},
                 {"not_run", Json::array()},
                 {"forbidden", document.forbidden()},
                 {"broken_controls", document.brokenControls()}};
    for (size_t i = 0; i < document.devices.size(); ++i) {
        const StressDevice& device = document.devices[i];
        json["devices"].push_back({{"name", device.name},
                                   {"argument", device.argument},
                                   {"driver", device.driver},
                                   {"arithmetic", arithmetic.at(i)},
                                   {"stopped", device.stopped ? Json(device.stopped->what()) : Json(nullptr)}});
    }
    for (const StressResult& result : document.results) json["results"].push_back(toJson(document, result));
    for (const ControlResult& result : document.controls) json["results"].push_back(toJson(document, result));
    for (const hard::NotRun& one : document.notRun)
        json["not_run"].push_back({{"case", one.number}, {"what", one.what}, {"why", one.why}});
    if (replay) json["ray"] = toJson(*replay);
    return json;
}

std::string toJUnit(const StressDocument& document) {
    std::vector<JUnitCase> tests;
    for (const StressResult& r : document.results)
        tests.push_back({fmt::format("stress.{}", r.device), fmt::format("case {}, {}", r.number, r.name()), r.seconds,
                         describeFailure(document, r)});
    for (const StressDevice& device : document.devices)
        if (device.stopped)
            tests.push_back({fmt::format("stress.{}", device.name), "all is run", 0.0, device.stopped->what()});
    for (const ControlResult& r : document.controls)
        tests.push_back({"stress.controls", fmt::format("case {}, {} fails", r.control.number, r.control.method), 0.0,
                         describeFailure(r)});
    return junitXml("raig stress", tests);
}

}  // namespace raig
