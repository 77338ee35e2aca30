#include "measure/chart_points.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstring>

namespace raig {

namespace {

std::string keyOf(const std::string& task, const std::string& sceneHash, const Json& settings) {
    return Json::array({task, sceneHash, settings}).dump();
}

/// Nothing if the line is no point of this identity.
std::optional<std::pair<std::string, ChartPoint>> readLine(const std::string& line, const std::string& identity) {
    const Json json = Json::parse(line, nullptr, /* allow_exceptions= */ false);
    if (!json.is_object() || json.value("identity", Json()) != Json(identity)) return std::nullopt;
    const auto text = [&](const char* key) {
        return json.contains(key) && json[key].is_string() ? json[key].get<std::string>() : std::string();
    };
    const auto object = [&](const char* key) { return json.contains(key) && json[key].is_object() ? json[key] : Json(); };
    ChartPoint point{text("scene"), object("settings"), object("measures"), text("left_out")};
    if (!point.settings.is_object() || !point.measures.is_object()) return std::nullopt;
    for (const auto& [name, value] : point.measures.items())
        if (!value.is_number() && !value.is_null()) return std::nullopt;
    return std::pair(keyOf(text("task"), text("hash"), point.settings), point);
}

}  // namespace

PointStore::PointStore(const std::filesystem::path& file, std::string identity)
    : file_(file), identity_(std::move(identity)) {
    constexpr uint64_t mostBytes = uint64_t{256} << 20;
    std::error_code none;
    const auto status = std::filesystem::symlink_status(file, none);
    if (std::filesystem::exists(status) && !std::filesystem::is_regular_file(status))
        throw inputError(file.string(), "is no regular file; name another folder, or remove it");
    if (std::filesystem::exists(status) && std::filesystem::file_size(file) > mostBytes)
        throw inputError(file.string(), "has more than {} MiB; remove it, or measure --fresh", mostBytes >> 20);
    bool endsLine = true;
    {
        std::ifstream in(file);
        std::string line;
        while (std::getline(in, line)) {
            endsLine = !in.eof();
            if (const auto known = readLine(line, identity_)) points_.insert_or_assign(known->first, known->second);
        }
    }
    out_.open(file, std::ios::app);
    if (!endsLine) out_ << '\n';  // a run was interrupted within a line
    if (!out_.flush()) throw inputError(file.string(), "cannot be written: {}", std::strerror(errno));
}

std::optional<ChartPoint> PointStore::find(const std::string& task, const std::string& sceneHash,
                                           const Json& settings) const {
    const auto known = points_.find(keyOf(task, sceneHash, settings));
    return known == points_.end() ? std::nullopt : std::optional(known->second);
}

void PointStore::add(const std::string& task, const std::string& sceneHash, const ChartPoint& point) {
    const Json line = {{"identity", identity_},      {"task", task},
                       {"scene", point.scene},       {"hash", sceneHash},
                       {"settings", point.settings}, {"measures", point.measures},
                       {"left_out", point.leftOut}};
    out_ << line.dump(-1, ' ', false, Json::error_handler_t::replace) << '\n';
    if (!out_.flush()) throw inputError(file_.string(), "cannot be written: {}", std::strerror(errno));
    points_.insert_or_assign(keyOf(task, sceneHash, point.settings), point);
}

std::optional<double> valueOf(const ChartPoint& point, const std::string& name) {
    for (const Json* of : {&point.settings, &point.measures})
        if (of->contains(name) && (*of)[name].is_number()) return (*of)[name].get<double>();
    return std::nullopt;
}

std::string nameOf(const ChartPoint& point, const std::string& name) {
    if (name == "scene") return point.scene;
    if (const auto value = valueOf(point, name)) return fmt::format("{:.9g}", *value);
    return point.settings.contains(name) ? point.settings[name].get<std::string>() : "";
}

std::string describeSettings(const Json& settings, const std::vector<std::string>& without) {
    std::string text;
    for (const auto& [name, value] : settings.items()) {
        if (std::find(without.begin(), without.end(), name) != without.end()) continue;
        const std::string shown = value.is_string() ? value.get<std::string>() : fmt::format("{:.9g}", value.get<double>());
        text += fmt::format("{}{} {}", text.empty() ? "" : ", ", name, shown);
    }
    return text;
}

}  // namespace raig
