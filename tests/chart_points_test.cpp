// Points of charts: kept on disk as they are measured, and held against theory.
#include "measure/chart_points.hpp"

#include "base/error.hpp"
#include "support/gltf_asset.hpp"

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

namespace raig {
namespace {

ChartPoint point(const std::string& scene, const char* settings, const char* measures) {
    return {scene, Json::parse(settings), Json::parse(measures), ""};
}

std::string textOf(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

TEST(PointStore, KnowsWhatAnEarlierRunMeasured) {
    const test::TemporaryFolder folder;
    const auto file = folder.path / "points.jsonl";
    {
        PointStore store(file, "me");
        store.add("trace", "h1", point("s", R"({"a": 1, "b": "x"})", R"({"ms": 2.5, "n": null})"));
        ChartPoint leftOut = point("s", R"({"a": 2})", "{}");
        leftOut.leftOut = "too large";
        store.add("trace", "h1", leftOut);
    }
    const PointStore again(file, "me");
    const auto known = again.find("trace", "h1", Json::parse(R"({"a": 1, "b": "x"})"));
    ASSERT_TRUE(known);
    EXPECT_EQ(known->measures.dump(), R"({"ms":2.5,"n":null})");
    EXPECT_EQ(again.find("trace", "h1", Json::parse(R"({"a": 2})"))->leftOut, "too large");
    EXPECT_FALSE(again.find("picture", "h1", known->settings)) << "another task";
    EXPECT_FALSE(again.find("trace", "h2", known->settings)) << "another scene of that name";
    EXPECT_FALSE(PointStore(file, "another").find("trace", "h1", known->settings)) << "another program, device or seed";
}

// A run that is killed leaves half a line: what is whole counts, and what is added later is whole again.
TEST(PointStore, StandsLinesThatAreCutOffOrDamaged) {
    const test::TemporaryFolder folder;
    const auto file = folder.path / "points.jsonl";
    { PointStore(file, "me").add("trace", "h", point("s", R"({"a": 1})", R"({"ms": 1})")); }
    const std::string whole = textOf(file);
    for (size_t length = 0; length <= whole.size(); ++length) {
        std::ofstream(file, std::ios::trunc) << "\n[]\n{\"identity\": 3}\n\xff\xfe\n" << whole.substr(0, length);
        {
            PointStore store(file, "me");
            EXPECT_EQ(store.find("trace", "h", Json::parse(R"({"a": 1})")).has_value(), length + 1 >= whole.size())
                << length;
            store.add("trace", "h", point("s", R"({"a": 2})", R"({"ms": 2})"));
        }
        EXPECT_TRUE(PointStore(file, "me").find("trace", "h", Json::parse(R"({"a": 2})"))) << length;
    }
    std::ofstream(file, std::ios::trunc) << R"({"identity":"me","task":"trace","scene":"s","hash":"h","settings":{"a":1},)"
                                         << R"("measures":{"ms":"fast"},"left_out":""})" << '\n';
    EXPECT_FALSE(PointStore(file, "me").find("trace", "h", Json::parse(R"({"a": 1})"))) << "a measure that is no number";
}

TEST(PointStore, SaysThatItCannotBeWritten) {
    const test::TemporaryFolder folder;
    EXPECT_THROW(PointStore(folder.path / "none" / "points.jsonl", "me"), Error);
    std::filesystem::create_symlink("/dev/zero", folder.path / "points.jsonl");
    EXPECT_THROW(PointStore(folder.path / "points.jsonl", "me"), Error);
}

Sweep withLaw(const char* law) {
    const std::string text = std::string(R"({"name": "a", "title": "A", "task": "trace", "settings": {},
        "draw": {"x": "x", "y": "y"}, "holds": )") +
                             law + "}";
    return readSweeps(text, "")[0];
}

TEST(Laws, FindWhatExceedsABound) {
    const Sweep sweep = withLaw(R"({"measure": "error", "most": "bound", "plus": 0.5, "because": "theory"})");
    const std::vector<ChartPoint> points = {point("s", R"({"a": 1})", R"({"error": 1.5, "bound": 1})"),
                                            point("s", R"({"a": 2})", R"({"error": 1.6, "bound": 1})"),
                                            point("t", R"({"a": 3})", R"({"error": null, "bound": 1})"),
                                            point("t", R"({"a": 4})", R"({"error": 1})"),
                                            point("t", R"({"a": 5})", R"({"other": 1})")};
    const std::vector<Breach> breaches = findBreaches(sweep, points);
    ASSERT_EQ(breaches.size(), 3u);
    EXPECT_EQ(breaches[0].scene, "s");
    EXPECT_NE(breaches[0].text.find("error is 1.6 at a 2"), std::string::npos) << breaches[0].text;
    EXPECT_NE(breaches[0].text.find("theory"), std::string::npos);
    EXPECT_NE(breaches[1].text.find("not finite"), std::string::npos);
    EXPECT_NE(breaches[2].text.find("bound was not measured"), std::string::npos);
}

TEST(Laws, AreAboutThePointsTheyName) {
    const Sweep sweep = withLaw(R"({"measure": "e", "most": 0, "where": {"accel": "bvh", "n": 2}, "because": "x"})");
    EXPECT_EQ(findBreaches(sweep, {point("s", R"({"accel": "bvh", "n": 2})", R"({"e": 1})"),
                                   point("s", R"({"accel": "bvh", "n": 3})", R"({"e": 1})"),
                                   point("s", R"({"accel": "grid", "n": 2})", R"({"e": 1})"),
                                   point("s", R"({"n": 2})", R"({"e": 1})")})
                  .size(),
              1u);
}

// A law that nothing is held to must not look like one that holds.
TEST(Laws, NeedAPointTheyAreAbout) {
    const Sweep sweep = withLaw(R"({"measure": "e", "most": 0, "because": "x"})");
    EXPECT_EQ(findBreaches(sweep, {point("s", "{}", R"({"other": 1})")}).size(), 1u);
    EXPECT_TRUE(findBreaches(sweep, {}).empty()) << "nothing was measured";
}

TEST(Laws, FindWhatDiffersFromTheory) {
    const Sweep sweep = withLaw(R"({"measure": "e", "equals": "theory", "within": 0.1, "because": "x"})");
    EXPECT_TRUE(findBreaches(sweep, {point("s", "{}", R"({"e": 1.09, "theory": 1})")}).empty());
    EXPECT_EQ(findBreaches(sweep, {point("s", "{}", R"({"e": 1.11, "theory": 1})")}).size(), 1u);
    EXPECT_EQ(findBreaches(sweep, {point("s", "{}", R"({"e": 0.89, "theory": 1})")}).size(), 1u);
}

std::vector<ChartPoint> seriesOf(const std::string& label, double slope) {
    std::vector<ChartPoint> points;
    for (const double n : {1.0, 4.0, 16.0, 64.0})
        points.push_back({"s", {{"label", label}, {"n", n}}, {{"rmse", 3.0 * std::pow(n, slope)}}, ""});
    return points;
}

TEST(Laws, FitASlopeToEachSeries) {
    const Sweep sweep =
        withLaw(R"({"measure": "rmse", "slope_over": "n", "least": -0.6, "greatest": -0.4, "because": "x"})");
    std::vector<ChartPoint> points = seriesOf("right", -0.5);
    EXPECT_TRUE(findBreaches(sweep, points).empty());
    for (const ChartPoint& one : seriesOf("flat", -0.3)) points.push_back(one);
    const std::vector<Breach> breaches = findBreaches(sweep, points);
    ASSERT_EQ(breaches.size(), 1u);
    EXPECT_NE(breaches[0].text.find("slope of rmse over n is -0.300 at label flat"), std::string::npos) << breaches[0].text;
    points = seriesOf("short", -0.5);
    points.resize(2);
    EXPECT_NE(findBreaches(sweep, points).at(0).text.find("too few points"), std::string::npos);
    points = seriesOf("exact", -0.5);
    for (ChartPoint& one : points) one.measures["rmse"] = 0.0;
    EXPECT_TRUE(findBreaches(sweep, points).empty()) << "what is exact needs no slope";
    points = seriesOf("flat but for one", -0.3);
    points[2].measures["rmse"] = 0.0;
    EXPECT_EQ(findBreaches(sweep, points).size(), 1u) << "one 0 excuses nothing";
}

const Sweep& builtIn(const std::string& name) {
    static const std::vector<Sweep> sweeps = readSweeps(std::string(builtInSweeps()), "figures.json");
    return *std::find_if(sweeps.begin(), sweeps.end(), [&](const Sweep& sweep) { return sweep.name == name; });
}

/// Points of raig's own figure, with the same measures each.
std::vector<ChartPoint> pointsOf(const std::string& name, const Json& measures) {
    std::vector<ChartPoint> points;
    for (const Json& settings : builtIn(name).settings) points.push_back({"s", settings, measures, ""});
    return points;
}

// Each figure with points as theory has them, then with one that lies outside its band.
TEST(Laws, OfRaigsOwnFiguresFindWhatLiesOutside) {
    std::vector<ChartPoint> points = pointsOf("node-bits", {{"differing", 0}});
    EXPECT_TRUE(findBreaches(builtIn("node-bits"), points).empty());
    points.back().measures["differing"] = 1;
    EXPECT_EQ(findBreaches(builtIn("node-bits"), points).size(), 1u) << "quantised nodes must have error 0";

    points = pointsOf("contribution", {{"mean_error", 0.1}, {"bound_mean", 0.2}, {"beyond_bound", 0}});
    EXPECT_TRUE(findBreaches(builtIn("contribution"), points).empty());
    points[3].measures["mean_error"] = 0.21;
    points[5].measures["beyond_bound"] = 1;
    EXPECT_EQ(findBreaches(builtIn("contribution"), points).size(), 2u) << "the discarded weight is a bound";

    const auto withSlope = [](double slope) {
        std::vector<ChartPoint> all = pointsOf("samples", Json::object());
        for (ChartPoint& one : all) {
            const double samples = one.settings["spp"].get<double>() * one.settings.value("pictures", 1.0);
            one.measures = {{"samples", samples}, {"rmse", std::pow(samples, slope)}};
        }
        return all;
    };
    EXPECT_TRUE(findBreaches(builtIn("samples"), withSlope(-0.5)).empty());
    EXPECT_EQ(findBreaches(builtIn("samples"), withSlope(-0.3)).size(), 2u) << "noise falls with the square root";
    EXPECT_EQ(findBreaches(builtIn("samples"), withSlope(-0.7)).size(), 1u) << "of independent samples it falls no faster";

    points = pointsOf("mirrors", Json::object());
    for (ChartPoint& one : points) {
        const double theory = std::pow(0.5, one.settings["max-depth"].get<double>() + 1.0);
        one.measures = {{"relative_error", theory}, {"theory", theory}, {"nan", 0}};
    }
    EXPECT_TRUE(findBreaches(builtIn("mirrors"), points).empty());
    points[2].measures["relative_error"] = 1.001 * points[2].measures["theory"].get<double>();
    EXPECT_EQ(findBreaches(builtIn("mirrors"), points).size(), 1u);
}

}  // namespace
}  // namespace raig
