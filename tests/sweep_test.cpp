// Charts as declarations: what is read from JSON, and what is refused.
#include "measure/sweep.hpp"

#include "base/error.hpp"
#include "measure/tasks.hpp"

#include <gtest/gtest.h>

namespace raig {
namespace {

constexpr const char* least = R"({"name": "a", "title": "A", "task": "trace", "settings": {"accel": "bvh"},
                                  "draw": {"x": "arity", "y": "milliseconds"}})";

/// The one sweep, with more keys, or others.
std::string with(const std::string& key, const std::string& value) {
    Json json = Json::parse(least);
    json[key] = Json::parse(value);
    return json.dump();
}

std::string complaintOf(const std::string& text) {
    try {
        readSweeps(text, "f.json");
    } catch (const Error& error) {
        EXPECT_EQ(error.exitCode, ExitCode::badInput);
        return error.what();
    }
    return "none";
}

TEST(Sweep, HoldsScalarsAndVariesArrays) {
    const std::vector<Sweep> sweeps = readSweeps(
        with("settings", R"([{"accel": "grid", "levels": [1, 2], "grid-density": [0.5, 4]}, {"accel": "bvh"}])"), "");
    ASSERT_EQ(sweeps.size(), 1u);
    std::vector<std::string> points;
    for (const Json& point : sweeps[0].settings) points.push_back(point.dump());
    EXPECT_EQ(points, (std::vector<std::string>{R"({"accel":"grid","levels":1,"grid-density":0.5})",
                                                R"({"accel":"grid","levels":1,"grid-density":4})",
                                                R"({"accel":"grid","levels":2,"grid-density":0.5})",
                                                R"({"accel":"grid","levels":2,"grid-density":4})", R"({"accel":"bvh"})"}));
}

TEST(Sweep, IsOneOrSeveral) {
    EXPECT_EQ(readSweeps(least, "").size(), 1u);
    Json second = Json::parse(least);
    second["name"] = "b";
    const Json both = Json::array({Json::parse(least), second});
    EXPECT_EQ(readSweeps(both.dump(), "").size(), 2u);
    EXPECT_EQ(readSweeps(Json{{"sweeps", both}}.dump(), "").size(), 2u);
}

TEST(Sweep, HasLawsAndDrawings) {
    const Sweep sweep = readSweeps(with("holds", R"([{"measure": "a", "most": "b", "plus": 1, "because": "x"},
        {"measure": "c", "equals": 2, "within": 0.5, "because": "y", "where": {"accel": "bvh"}},
        {"measure": "d", "slope_over": "spp", "least": -1, "greatest": 1, "because": "z"}])"),
                                   "")[0];
    ASSERT_EQ(sweep.laws.size(), 3u);
    EXPECT_EQ(sweep.laws[0].boundMeasure, "b");
    EXPECT_FALSE(sweep.laws[0].bound);
    EXPECT_EQ(sweep.laws[1].kind, Law::Kind::equals);
    EXPECT_EQ(sweep.laws[1].bound, 2.0);
    EXPECT_EQ(sweep.laws[2].over, "spp");
    EXPECT_EQ(sweep.drawings.at(0).panels, std::vector<std::string>{"scene"});
}

TEST(Sweep, IsRefusedWithItsPlace) {
    const std::pair<std::string, const char*> cases[] = {
        {"{\n\"name\": \"a\",\n}", "f.json:3: is no JSON"},
        {"[]", "there is no sweep"},
        {"7", "an object is wanted"},
        {"{}", "\"name\" is missing"},
        {with("colour", "1"), "f.json#: there is no key \"colour\""},
        {with("name", "\"../a\""), "f.json#/name: lower-case letters"},
        {with("settings", R"({"accel": []})"), "f.json#/settings/accel: an array of settings must have a value"},
        {with("settings", R"({"accel": {"a": 1}})"), "f.json#/settings/accel: a number or a text"},
        {with("settings", R"({"accel": [true]})"), "f.json#/settings/accel/0: a number or a text"},
        {with("draw", R"([{"x": "a", "y": "b", "style": "bars"}])"), "f.json#/draw/0/style: there is no style \"bars\""},
        {with("draw", R"({"x": "a", "y": "b", "log": "z"})"), "f.json#/draw/log: x, y or xy"},
        {with("draw", R"({"x": "a", "y": "b", "style": "heat"})"), "second axis"},
        {with("holds", R"({"measure": "a", "because": "b"})"), "f.json#/holds: one of"},
        {with("holds", R"({"measure": "a", "most": 1, "equals": 1, "because": "b"})"), "one of"},
        {with("holds", R"({"measure": "a", "most": 1})"), "\"because\" is missing"},
        {"[" + std::string(least) + "," + least + "]", "f.json#/1/name: \"a\" is the name of another sweep"},
        {std::string(100'000, '['), "nested deeper than"},
        {R"({"name": 1e999})", "a number that is out of range"},
        {with("a/b~c", "1"), "there is no key"},
        {R"({"sweeps": [{"name": 3}]})", "f.json#/sweeps/0"},
        {with("title", R"("a\u001b[31m")"), "f.json#/title: a text without control characters"},
        {with("settings", R"({"label": "a\u0007"})"), "f.json#/settings/label: a text without control characters"},
        {with("scenes", "[]"), "f.json#/scenes: it must not be empty"},
        {with("draw", "[]"), "f.json#/draw: it must not be empty"},
    };
    for (const auto& [text, complaint] : cases)
        EXPECT_NE(complaintOf(text).find(complaint), std::string::npos)
            << complaintOf(text) << " for " << text.substr(0, 200);
}

// Six settings of ten values each are a million points.
TEST(Sweep, HasABoundedNumberOfPoints) {
    std::string settings = "{";
    for (char name = 'a'; name < 'g'; ++name)
        settings += std::string(name == 'a' ? "" : ",") + "\"" + name + "\": [0,1,2,3,4,5,6,7,8,9]";
    EXPECT_NE(complaintOf(with("settings", settings + "}")).find("more than 10000 points"), std::string::npos);
}

TEST(Sweep, IsWhatRaigDrawsOfItself) {
    const std::vector<Sweep> sweeps = readSweeps(std::string(builtInSweeps()), "figures.json");
    EXPECT_GE(sweeps.size(), 10u);
    for (const Sweep& sweep : sweeps) {
        EXPECT_FALSE(sweep.text.empty()) << sweep.name;
        EXPECT_FALSE(sweep.laws.empty()) << sweep.name;
        EXPECT_FALSE(sweep.measures.empty()) << sweep.name;
    }
}

// A figure that names what there is not would keep all others from being drawn.
TEST(OwnFigures, NameOnlyWhatTheirTasksKnow) {
    const std::vector<Sweep> sweeps = readSweeps(std::string(builtInSweeps()), "figures.json");
    EXPECT_GT(sweeps.size(), 10u);
    for (const Sweep& sweep : sweeps) {
        const std::unique_ptr<Task> task = makeTask(sweep.task, {});
        for (const Json& point : sweep.settings) EXPECT_NO_THROW(task->check(point)) << sweep.name;
        try {
            checkNames(sweep, task->measures());
        } catch (const Error& error) {
            ADD_FAILURE() << sweep.name << ": " << error.what();
        }
    }
}

}  // namespace
}  // namespace raig
