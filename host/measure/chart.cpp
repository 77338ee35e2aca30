#include "measure/chart.hpp"

#include "base/error.hpp"
#include "base/files.hpp"
#include "measure/chart_panels.hpp"
#include "measure/chart_pictures.hpp"
#include "measure/chart_points.hpp"
#include "measure/gnuplot.hpp"
#include "measure/tasks.hpp"

#include <algorithm>
#include <map>
#include <set>

namespace raig {

namespace {

void write(const std::filesystem::path& file, const std::string& text) {
    writeFileAtomically(file, std::as_bytes(std::span(text)));
}

/// What is to be measured: a point of a figure.
struct Planned {
    size_t figure;
    std::string scene;  ///< empty: none is needed
    Json settings;
};

class Run {
public:
    Run(const ChartSettings& settings, ChartDocument& document, const ChartProgress& progress)
        : settings_(settings),
          document_(document),
          progress_(progress),
          scenes_(settings.scenes),
          store_(settings.folder / "points.jsonl", settings.identity) {}

    void all() {
        plan();
        runGnuplot("");  // that it is missing should be told before hours of work
        measure();
        finish();
    }

private:
    Task& taskOf(const std::string& name) {
        std::unique_ptr<Task>& task = tasks_[name];
        if (!task) task = makeTask(name, {settings_.device, settings_.seed});
        return *task;
    }

    /// Scene by scene, as one is in memory at a time; so figures are complete only at the end.
    void plan() {
        for (const Sweep& sweep : settings_.sweeps) {
            const size_t figure = document_.figures.size();
            document_.figures.push_back({sweep, {}, {}, {}});
            try {
                const Task& task = taskOf(sweep.task);
                for (const Json& point : sweep.settings) task.check(point);
                checkNames(sweep, task.measures());
                std::vector<std::string> names;
                for (const std::string& entry : sweep.scenes)
                    for (const std::string& name : task.needsScene() ? scenes_.namesOf(entry) : std::vector{std::string()})
                        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
                for (const std::string& name : names)
                    for (const Json& point : sweep.settings) planned_.push_back({figure, name, point});
            } catch (const Error& error) {
                if (error.exitCode != ExitCode::usage) throw;
                throw inputError("sweep " + sweep.name, "{}", error.what());
            }
        }
        std::vector<std::string> order = scenes_.namesOf("given");
        const auto rank = [&](const Planned& one) {
            const auto at = std::find(order.begin(), order.end(), one.scene);
            if (at == order.end()) order.push_back(one.scene);
            return static_cast<size_t>(std::find(order.begin(), order.end(), one.scene) - order.begin());
        };
        std::vector<std::pair<size_t, Planned>> ranked;
        for (Planned& one : planned_) ranked.emplace_back(rank(one), std::move(one));
        std::stable_sort(ranked.begin(), ranked.end(), [](const auto& a, const auto& b) { return a.first < b.first; });
        planned_.clear();
        for (auto& [place, one] : ranked) planned_.push_back(std::move(one));
    }

    const ChartScene& open(const std::string& scene) {
        if (scene != atHand_)
            for (auto& [name, task] : tasks_) task->forgetScene();
        atHand_ = scene;
        return scenes_.open(scene);
    }

    const std::string& hashOf(const std::string& scene) {
        const auto known = hashes_.find(scene);
        if (known != hashes_.end()) return known->second;
        return hashes_.emplace(scene, scene.empty() ? "" : open(scene).hash()).first->second;
    }

    void measure() {
        const std::vector<std::string> given =
            settings_.pictureSide > 0 ? scenes_.namesOf("given") : std::vector<std::string>{};
        double steps = double(planned_.size() + 4 * given.size()), step = 0.0;  // a picture takes as long as four points
        std::set<std::string> pictured;
        const auto picture = [&](const std::string& scene) {
            const bool isWanted = std::find(given.begin(), given.end(), scene) != given.end();
            if (!isWanted || !pictured.insert(scene).second) return;
            progress_(scene + ": pictures", step / steps);
            document_.pictures.push_back(picturesOf(open(scene), settings_.device, settings_.pictureSide, settings_.seed));
            step += 4.0;
        };
        for (const Planned& one : planned_) {
            ChartFigure& figure = document_.figures[one.figure];
            progress_(fmt::format("{}{}{}", one.scene, one.scene.empty() ? "" : ": ", figure.sweep.name), step / steps);
            if (std::optional<ChartPoint> known = knownPoint(figure.sweep.task, one)) {
                figure.points.push_back(std::move(*known));
                --steps;  // it took no time, and says nothing of how much is left
            } else {
                figure.points.push_back(measurePoint(figure.sweep.task, one));
                ++step;
            }
            if (one.scene != "") picture(one.scene);
        }
        for (const std::string& scene : given) picture(scene);
    }

    std::optional<ChartPoint> knownPoint(const std::string& taskName, const Planned& one) {
        std::optional<ChartPoint> known = store_.find(taskName, hashOf(one.scene), one.settings);
        if (known) known->scene = one.scene;
        return known;
    }

    ChartPoint measurePoint(const std::string& taskName, const Planned& one) {
        ChartPoint point{one.scene, one.settings, Json::object(), ""};
        try {
            const ChartScene* scene = one.scene.empty() ? nullptr : &open(one.scene);
            point.measures = taskOf(taskName).run(scene, one.settings);
        } catch (const Error& error) {
            if (error.exitCode != ExitCode::limit) throw;
            point.leftOut = error.what();
        }
        for (auto& [name, value] : point.measures.items())
            if (value.is_number_float() && !std::isfinite(value.get<double>())) value = nullptr;
        store_.add(taskName, hashOf(one.scene), point);
        return point;
    }

    void finish() {
        std::vector<Panel> all;
        std::vector<size_t> counts;
        size_t number = 0;
        for (ChartFigure& figure : document_.figures) {
            figure.breaches = findBreaches(figure.sweep, figure.points);
            const std::vector<Panel> panels =
                panelsOf(figure, taskOf(figure.sweep.task).measures(), fmt::format("{:02}", ++number));
            all.insert(all.end(), panels.begin(), panels.end());
            counts.push_back(panels.size());
            write(settings_.folder / (figure.sweep.name + ".csv"), toCsv(figure));
            write(settings_.folder / (figure.sweep.name + ".json"),
                  toJson(figure).dump(1, ' ', false, Json::error_handler_t::replace) + "\n");
        }
        progress_("drawing", 1.0);
        const std::vector<ChartPanel> drawn = drawPanels(all, settings_.folder);
        size_t next = 0;
        for (size_t i = 0; i < counts.size(); ++i)
            for (size_t k = 0; k < counts[i]; ++k) document_.figures[i].panels.push_back(drawn[next++]);
    }

    const ChartSettings& settings_;
    ChartDocument& document_;
    const ChartProgress& progress_;
    ChartScenes scenes_;
    std::string atHand_;  ///< the scene that tasks may keep something of
    PointStore store_;
    std::map<std::string, std::unique_ptr<Task>> tasks_;
    std::vector<Planned> planned_;
    std::map<std::string, std::string> hashes_;
};

/// As RFC 4180 has it.
std::string csvField(const std::string& text) {
    if (text.find_first_of(",\"\r\n") == text.npos) return text;
    std::string quoted = "\"";
    for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
    return quoted + "\"";
}

void addNames(std::vector<std::string>& names, const Json& object) {
    for (const auto& [name, value] : object.items())
        if (std::find(names.begin(), names.end(), name) == names.end()) names.push_back(name);
}

}  // namespace

void runChart(const ChartSettings& settings, ChartDocument& document, const ChartProgress& progress) {
    Run(settings, document, progress).all();
}

std::string toCsv(const ChartFigure& figure) {
    std::vector<std::string> settings, measures;
    for (const ChartPoint& point : figure.points) {
        addNames(settings, point.settings);
        addNames(measures, point.measures);
    }
    std::string text = "scene";
    for (const auto* names : {&settings, &measures})
        for (const std::string& name : *names) text += "," + csvField(name);
    text += ",left_out\n";
    const auto field = [](const Json& object, const std::string& name) {
        if (!object.contains(name) || object[name].is_null()) return std::string();
        return object[name].is_string() ? csvField(object[name].get<std::string>()) : object[name].dump();
    };
    for (const ChartPoint& point : figure.points) {
        text += csvField(point.scene);
        for (const std::string& name : settings) text += "," + field(point.settings, name);
        for (const std::string& name : measures) text += "," + field(point.measures, name);
        text += "," + csvField(point.leftOut) + "\n";
    }
    return text;
}

Json toJson(const ChartFigure& figure) {
    Json json = {{"name", figure.sweep.name}, {"title", figure.sweep.title}, {"text", figure.sweep.text},
                 {"points", Json::array()},   {"breaches", Json::array()},   {"missing", Json::array()}};
    for (const ChartPoint& point : figure.points)
        json["points"].push_back({{"scene", point.scene},
                                  {"settings", point.settings},
                                  {"measures", point.measures},
                                  {"left_out", point.leftOut.empty() ? Json(nullptr) : Json(point.leftOut)}});
    for (const Breach& breach : figure.breaches)
        json["breaches"].push_back({{"scene", breach.scene}, {"what", breach.text}});
    for (const Missing& missing : figure.sweep.missing)
        json["missing"].push_back({{"what", missing.what}, {"why", missing.why}});
    return json;
}

}  // namespace raig
