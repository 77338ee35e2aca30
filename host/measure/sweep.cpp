#include "measure/sweep.hpp"

#include "base/error.hpp"

#include <algorithm>
#include <initializer_list>

namespace raig {

namespace {

constexpr size_t mostPoints = 10'000;

/// A value of the document, and where it stands.
class Node {
public:
    Node(const Json& json, std::string place, std::string pointer)
        : json_(json), place_(std::move(place)), pointer_(std::move(pointer)) {}

    template <class... Args>
    [[nodiscard]] Error error(fmt::format_string<Args...> format, Args&&... args) const {
        return inputError(place_ + "#" + pointer_, format, std::forward<Args>(args)...);
    }

    const Json& json() const { return json_; }
    Node at(const std::string& key) const { return {json_.at(key), place_, pointer_ + "/" + escaped(key)}; }
    Node at(size_t index) const { return {json_.at(index), place_, pointer_ + "/" + std::to_string(index)}; }
    bool has(const std::string& key) const { return json_.contains(key); }

    /// Refuses what is no object, keys that are not among those known, and the lack of one that is needed.
    void checkKeys(std::initializer_list<const char*> known, std::initializer_list<const char*> needed) const {
        if (!json_.is_object()) throw error("an object is wanted");
        for (const auto& [key, value] : json_.items())
            if (std::find(known.begin(), known.end(), key) == known.end())
                throw error("there is no key \"{}\"; there are {}", key, fmt::join(known, ", "));
        for (const char* key : needed)
            if (!has(key)) throw error("the key \"{}\" is missing", key);
    }

    std::string text() const {
        if (!json_.is_string()) throw error("a text is wanted");
        std::string text = json_.get<std::string>();
        checkPlain(text);
        return text;
    }
    /// Texts end up in terminals, pages and pictures.
    void checkPlain(const std::string& text) const {
        if (std::any_of(text.begin(), text.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }))
            throw error("a text without control characters is wanted");
    }
    double number() const {
        if (!json_.is_number()) throw error("a number is wanted");
        return json_.get<double>();
    }
    std::string textOr(const std::string& key, const std::string& otherwise) const {
        return has(key) ? at(key).text() : otherwise;
    }
    std::vector<std::string> texts() const {
        if (!json_.is_array()) throw error("an array of texts is wanted");
        std::vector<std::string> all;
        for (size_t i = 0; i < json_.size(); ++i) all.push_back(at(i).text());
        return all;
    }
    std::vector<std::string> textsOf(const std::string& key) const {
        return has(key) ? at(key).texts() : std::vector<std::string>{};
    }
    /// The entries of an array, or the value itself.
    std::vector<Node> entries() const {
        if (!json_.is_array()) return {*this};
        std::vector<Node> all;
        for (size_t i = 0; i < json_.size(); ++i) all.push_back(at(i));
        return all;
    }

private:
    /// As a part of a JSON pointer [RFC 6901].
    static std::string escaped(const std::string& key) {
        std::string text;
        for (const char c : key) text += c == '~' ? std::string("~0") : c == '/' ? std::string("~1") : std::string(1, c);
        return text;
    }

    const Json& json_;
    std::string place_, pointer_;
};

bool isScalar(const Json& value) {
    return value.is_number() || value.is_string();
}

/// Every combination of the arrays' entries, the first key's changing slowest.
void expand(const Node& block, std::vector<Json>& points) {
    if (!block.json().is_object()) throw block.error("an object of settings is wanted");
    std::vector<Json> all = {Json::object()};
    for (const auto& [key, value] : block.json().items()) {
        std::vector<Json> longer;
        const std::vector<Node> choices = block.at(key).entries();
        if (choices.empty()) throw block.at(key).error("an array of settings must have a value");
        for (const Json& point : all)
            for (const Node& choice : choices) {
                if (!isScalar(choice.json())) throw choice.error("a number or a text is wanted");
                if (choice.json().is_string()) choice.text();  // checks it
                longer.push_back(point);
                longer.back()[key] = choice.json();
                if (longer.size() > mostPoints) throw block.error("more than {} points", mostPoints);
            }
        all = std::move(longer);
    }
    points.insert(points.end(), all.begin(), all.end());
    if (points.size() > mostPoints) throw block.error("more than {} points", mostPoints);
}

Drawing::Style styleOf(const Node& node) {
    const std::string name = node.textOr("style", "points");
    if (name == "points") return Drawing::Style::points;
    if (name == "lines") return Drawing::Style::lines;
    if (name == "heat") return Drawing::Style::heat;
    throw node.at("style").error("there is no style \"{}\"; there are points, lines and heat", name);
}

Drawing readDrawing(const Node& node) {
    node.checkKeys(
        {"title", "x", "y", "by", "panels", "style", "log", "pareto", "band", "theory", "contour", "hollow", "guide"},
        {"x", "y"});
    Drawing drawing;
    drawing.title = node.textOr("title", "");
    drawing.x = node.at("x").text();
    drawing.y = node.at("y").text();
    drawing.by = node.textsOf("by");
    drawing.panels = node.has("panels") ? node.textsOf("panels") : std::vector<std::string>{"scene"};
    drawing.style = styleOf(node);
    const std::string log = node.textOr("log", "");
    if (log.find_first_not_of("xy") != log.npos) throw node.at("log").error("x, y or xy is wanted");
    drawing.logX = log.find('x') != log.npos;
    drawing.logY = log.find('y') != log.npos;
    if (node.has("pareto") && !node.at("pareto").json().is_boolean())
        throw node.at("pareto").error("true or false is wanted");
    drawing.pareto = node.has("pareto") && node.json()["pareto"].get<bool>();
    drawing.band = node.textOr("band", "");
    drawing.theory = node.textOr("theory", "");
    drawing.contour = node.textOr("contour", "");
    drawing.hollow = node.textOr("hollow", "");
    drawing.guide = node.has("guide") ? node.at("guide").number() : 0.0;
    if (drawing.style == Drawing::Style::heat && drawing.by.empty())
        throw node.error("a heat map needs the setting of its second axis in \"by\"");
    return drawing;
}

void readBound(const Node& node, const std::string& key, Law& law) {
    if (node.at(key).json().is_string())
        law.boundMeasure = node.at(key).text();
    else
        law.bound = node.at(key).number();
}

Law readLaw(const Node& node) {
    node.checkKeys({"measure", "most", "equals", "within", "plus", "slope_over", "least", "greatest", "where", "because"},
                   {"measure", "because"});
    Law law;
    law.measure = node.at("measure").text();
    law.because = node.at("because").text();
    const int kinds = node.has("most") + node.has("equals") + node.has("slope_over");
    if (kinds != 1) throw node.error("one of \"most\", \"equals\" and \"slope_over\" is wanted");
    if (node.has("most")) {
        readBound(node, "most", law);
    } else if (node.has("equals")) {
        law.kind = Law::Kind::equals;
        readBound(node, "equals", law);
    } else {
        law.kind = Law::Kind::slope;
        law.over = node.at("slope_over").text();
        if (!node.has("least") || !node.has("greatest")) throw node.error("a slope needs \"least\" and \"greatest\"");
        law.least = node.at("least").number();
        law.greatest = node.at("greatest").number();
    }
    if (node.has("within")) law.within = node.at("within").number();
    if (node.has("plus")) law.plus = node.at("plus").number();
    if (!(law.within >= 0.0 && law.plus >= 0.0)) throw node.error("\"within\" and \"plus\" must be 0 or more");
    if (node.has("where")) {
        law.where = node.at("where").json();
        if (!law.where.is_object()) throw node.at("where").error("an object of settings is wanted");
        for (const auto& [key, value] : law.where.items())
            if (!isScalar(value)) throw node.at("where").at(key).error("a number or a text is wanted");
    }
    return law;
}

std::string readName(const Node& node) {
    const std::string name = node.text();
    const bool isPlain = !name.empty() && name.size() <= 60 && std::all_of(name.begin(), name.end(), [](char c) {
        return (c >= 'a' && c <= 'z') || (c >= '0' && c <= '9') || c == '-';
    });
    if (!isPlain) throw node.error("lower-case letters, digits and hyphens are wanted, 60 at most: files are named by it");
    return name;
}

Sweep readSweep(const Node& node) {
    node.checkKeys({"name", "title", "text", "task", "scenes", "settings", "measure", "draw", "holds", "missing"},
                   {"name", "title", "task", "settings", "draw"});
    Sweep sweep;
    sweep.name = readName(node.at("name"));
    sweep.title = node.at("title").text();
    sweep.text = node.textOr("text", "");
    sweep.task = node.at("task").text();
    sweep.scenes = node.has("scenes") ? node.textsOf("scenes") : std::vector<std::string>{"given"};
    for (const char* const list : {"scenes", "draw", "settings"})
        if (node.has(list) && node.at(list).json().is_array() && node.at(list).json().empty())
            throw node.at(list).error("it must not be empty");
    for (const Node& block : node.at("settings").entries()) expand(block, sweep.settings);
    sweep.measures = node.textsOf("measure");
    for (const Node& drawing : node.at("draw").entries()) sweep.drawings.push_back(readDrawing(drawing));
    if (node.has("holds"))
        for (const Node& law : node.at("holds").entries()) sweep.laws.push_back(readLaw(law));
    if (node.has("missing"))
        for (const Node& missing : node.at("missing").entries()) {
            missing.checkKeys({"what", "why"}, {"what", "why"});
            sweep.missing.push_back({missing.at("what").text(), missing.at("why").text()});
        }
    return sweep;
}

}  // namespace

std::vector<Sweep> readSweeps(const std::string& text, const std::string& place) {
    constexpr int deepest = 16;  // far more than a declaration needs: values are gone through by recursion
    const auto boundDepth = [&](int depth, Json::parse_event_t, const Json&) {
        if (depth > deepest) throw inputError(place, "is nested deeper than {} levels", deepest);
        return true;
    };
    Json json;
    try {
        json = Json::parse(text, boundDepth);
    } catch (const Json::parse_error& fault) {
        const size_t end = std::min<size_t>(fault.byte, text.size());
        const auto line = 1 + std::count(text.begin(), text.begin() + static_cast<std::ptrdiff_t>(end), '\n');
        throw inputError(fmt::format("{}:{}", place, line), "is no JSON from here on; see raig chart --help");
    } catch (const Json::exception& fault) {
        throw inputError(place, "has a number that is out of range ({})", fault.what());
    }
    const Node root(json, place, "");
    const bool isNamed = json.is_object() && json.contains("sweeps");
    if (isNamed) root.checkKeys({"sweeps"}, {});
    std::vector<Sweep> sweeps;
    for (const Node& node : isNamed ? root.at("sweeps").entries() : root.entries()) {
        sweeps.push_back(readSweep(node));
        const auto same = [&](const Sweep& other) { return other.name == sweeps.back().name; };
        if (std::count_if(sweeps.begin(), sweeps.end(), same) > 1)
            throw node.at("name").error("\"{}\" is the name of another sweep, too", sweeps.back().name);
    }
    if (sweeps.empty()) throw root.error("there is no sweep in it");
    return sweeps;
}

}  // namespace raig
