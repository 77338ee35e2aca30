// `raig chart` as a person or a script calls it: what is written, resumed, refused, and what it exits with.
#include "support/gltf_asset.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <fstream>
#include <iterator>

namespace raig {
namespace {

using Json = nlohmann::ordered_json;

constexpr const char* spheres = RAIG_SOURCE_DIR "/assets/cornell_spheres.gltf";

std::string textOf(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

size_t linesOf(const std::filesystem::path& file) {
    const std::string text = textOf(file);
    return static_cast<size_t>(std::count(text.begin(), text.end(), '\n'));
}

/// A folder with a small sweep in it, and the chart of that.
class ChartCommand : public testing::Test {
protected:
    void declare(const Json& sweep) { std::ofstream(sweepFile()) << sweep.dump(); }
    std::filesystem::path sweepFile() const { return folder_.path / "sweep.json"; }
    std::filesystem::path out() const { return folder_.path / "out"; }
    std::filesystem::path points() const { return out() / "points.jsonl"; }

    ProgramResult run(std::vector<std::string> more = {}) const {
        std::vector<std::string> arguments = {
            "chart", spheres, "--device", "cpu", "--sweep", sweepFile().string(), "--figure", "small", "-o", out().string()};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }

    /// Two structures, and that they have the same hits.
    static Json small() {
        return Json::parse(R"({"name": "small", "title": "Small", "task": "trace",
            "settings": {"accel": ["bvh", "octree"], "max-leaf": [2, 8]},
            "measure": ["milliseconds", "differing"],
            "draw": {"x": "max-leaf", "y": "milliseconds", "by": ["accel"], "style": "lines"},
            "holds": {"measure": "differing", "most": 0, "because": "hits must not change"}})");
    }

private:
    test::TemporaryFolder folder_;
};

TEST_F(ChartCommand, WritesFiguresTheirDataAndAPage) {
    declare(small());
    const ProgramResult result = run({"--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const Json json = Json::parse(result.output);
    for (const char* const key : {"machine", "device", "driver", "arithmetic", "commit", "seed", "flags", "command"})
        EXPECT_TRUE(json.contains(key)) << key;
    ASSERT_EQ(json["figures"].size(), 1u);
    ASSERT_EQ(json["figures"][0]["points"].size(), 4u);
    EXPECT_EQ(json["figures"][0]["points"][3]["settings"], Json::parse(R"({"accel": "octree", "max-leaf": 8})"));
    for (const Json& point : json["figures"][0]["points"]) {
        EXPECT_GT(point["measures"]["milliseconds"].get<double>(), 0.0);
        EXPECT_EQ(point["measures"]["differing"], 0);
    }
    EXPECT_TRUE(json["breaches"].empty());
    EXPECT_EQ(json["pictures"][0]["numbers"]["missed"], 0);
    for (const char* const name : {"index.html", "chart.json", "small.csv", "small.json", "01-small-cornell_spheres.svg",
                                   "01-small-cornell_spheres.png", "sweeps.json"})
        EXPECT_GT(std::filesystem::file_size(out() / name), 100u) << name;
    const std::string csv = textOf(out() / "small.csv");
    EXPECT_TRUE(csv.starts_with("scene,accel,max-leaf,")) << csv;
    EXPECT_EQ(std::count(csv.begin(), csv.end(), '\n'), 5);
    EXPECT_NE(textOf(out() / "index.html").find("Small"), std::string::npos);
}

TEST_F(ChartCommand, GoesOnWhereItWas) {
    declare(small());
    ASSERT_EQ(run().exitCode, 0);
    ASSERT_EQ(linesOf(points()), 4u);
    const std::string first = textOf(points());
    EXPECT_EQ(run().exitCode, 0);
    EXPECT_EQ(textOf(points()), first) << "nothing is measured again";
    std::ofstream(points(), std::ios::trunc) << first.substr(0, first.find('\n') + 40);  // killed within the second line
    EXPECT_EQ(run().exitCode, 0);
    EXPECT_EQ(linesOf(points()), 5u) << "three points anew, and what was left of a line";
    EXPECT_EQ(textOf(points()).substr(0, first.find('\n')), first.substr(0, first.find('\n')));
    EXPECT_EQ(run({"--seed", "1"}).exitCode, 0);
    EXPECT_EQ(linesOf(points()), 9u) << "of another seed, all";
    EXPECT_EQ(run({"--fresh"}).exitCode, 0);
    EXPECT_EQ(linesOf(points()), 4u);
}

// As if a structure had other hits: by a point that an earlier run is made to have measured.
TEST_F(ChartCommand, SaysWhatLiesOutsideOfItsBandAndExitsWith1) {
    declare(small());
    ASSERT_EQ(run().exitCode, 0);
    std::string text = textOf(points());
    const std::string sound = "\"differing\":0";
    text.replace(text.rfind(sound), sound.size(), "\"differing\":7");
    std::ofstream(points(), std::ios::trunc) << text;
    const ProgramResult result = run({"--json"});
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_NE(result.errors.find("fell short: small, cornell_spheres: differing is 7 at accel octree, max-leaf 8"),
              std::string::npos)
        << result.errors;
    const Json json = Json::parse(result.output);
    ASSERT_EQ(json["breaches"].size(), 1u);
    EXPECT_NE(textOf(out() / "index.html").find("differing is 7"), std::string::npos);
}

// The discarded weight bounds the error of what was left out; a bound that asks for too much is not kept.
TEST_F(ChartCommand, HoldsPicturesToTheirDiscardedWeight) {
    Json sweep = Json::parse(R"({"name": "small", "title": "Small", "task": "picture", "scenes": ["mirroring"],
        "settings": {"min-contribution": [0.5, 0.1], "side": 48},
        "draw": {"x": "min-contribution", "y": "mean_error", "band": "bound_mean", "log": "xy", "style": "lines"},
        "holds": [{"measure": "mean_error", "most": "bound_mean", "because": "bound"},
                  {"measure": "beyond_bound", "most": 0, "because": "bound"}]})");
    declare(sweep);
    const ProgramResult sound = run({"--json"});
    EXPECT_EQ(sound.exitCode, 0) << sound.errors;
    const Json measures = Json::parse(sound.output)["figures"][0]["points"][0]["measures"];
    EXPECT_GT(measures["mean_error"].get<double>(), 0.0);
    EXPECT_GT(measures["bound_mean"].get<double>(), measures["mean_error"].get<double>());
    EXPECT_GT(measures["mean_depth"].get<double>(), 0.0);
    sweep["holds"] = Json::parse(R"({"measure": "mean_error", "most": 0.00001, "because": "too much to ask"})");
    declare(sweep);
    EXPECT_EQ(run().exitCode, 1);
}

TEST_F(ChartCommand, RefusesWhatDoesNotExistBeforeItMeasures) {
    const auto refused = [&](const char* key, const Json& value, const std::string& complaint) {
        Json sweep = small();
        sweep[key] = value;
        declare(sweep);
        const ProgramResult result = run();
        EXPECT_EQ(result.exitCode, 3) << key;
        EXPECT_NE(result.errors.find(complaint), std::string::npos) << result.errors;
        EXPECT_EQ(std::count(result.errors.begin(), result.errors.end(), '\n'), 1) << result.errors;
        EXPECT_FALSE(std::filesystem::exists(out() / "index.html"));
    };
    refused("task", "dance", "there is no task \"dance\"; there are trace");
    refused("scenes", {"nowhere"}, "there is no scene \"nowhere\"");
    refused("settings", {{"accel", "tree"}}, "tree");
    refused("settings", {{"colour", 1}}, "has no setting \"colour\"");
    refused("settings", {{"accel", "grid"}, {"arity", 2}}, "--arity");
    refused("settings", {{"accel", 3}}, "takes a text");
    refused("settings", {{"accel", "bvh"}, {"arity", 3}}, "takes one of 2, 4, 8");
    refused("settings", {{"accel", "bvh"}, {"max-leaf", -1}}, "takes a whole number from 1 to 255");
    refused("settings", {{"accel", "grid"}, {"grid-density", 1e9}}, "takes a number from 0.001 to 1000");
    refused("measure", {"millisecond"}, "\"millisecond\" in measure is no measure of its task");
    refused("draw", {{"x", "max-leafs"}, {"y", "milliseconds"}}, "\"max-leafs\" in draw is no setting");
    refused("holds", {{"measure", "difering"}, {"most", 0}, {"because", "x"}}, "\"difering\" in holds is no measure");
    refused("holds", {{"measure", "differing"}, {"most", 0}, {"because", "x"}, {"where", {{"acel", "bvh"}}}},
            "\"acel\" in where is no setting");
    refused("name", "sweeps", "give it one of its own");
    std::ofstream(sweepFile()) << "{";
    EXPECT_EQ(run().exitCode, 3);
    declare(small());
    EXPECT_EQ(run({"--figure", "none"}).exitCode, 2);
}

// In the folder of the chart, under the name of its data.
TEST_F(ChartCommand, DoesNotReplaceADeclarationThatItReads) {
    std::filesystem::create_directories(out());
    const std::filesystem::path file = out() / "small.json";
    std::ofstream(file) << small().dump();
    const ProgramResult result = runProgram(RAIG_PROGRAM, {"chart", spheres, "--device", "cpu", "--sweep", file.string(),
                                                           "--figure", "small", "-o", out().string()});
    EXPECT_EQ(result.exitCode, 2) << result.errors;
    EXPECT_EQ(textOf(file), small().dump());
}

}  // namespace
}  // namespace raig
