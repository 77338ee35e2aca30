// Figures: which dots belong to which panel, what is drawn of them, and that gnuplot draws it.
#include "measure/chart_panels.hpp"

#include "base/error.hpp"
#include "measure/gnuplot.hpp"
#include "support/gltf_asset.hpp"

#include <gtest/gtest.h>

#include <fstream>

namespace raig {
namespace {

ChartFigure figureWith(const std::string& draw, std::vector<ChartPoint> points) {
    const std::string text = R"({"name": "fig", "title": "A", "task": "trace", "settings": {}, "draw": )" + draw + "}";
    return {readSweeps(text, "")[0], std::move(points), {}, {}};
}

ChartPoint dot(const std::string& scene, const std::string& accel, Json measures) {
    return {scene, {{"accel", accel}}, std::move(measures), ""};
}

const Json labels = {{"ms", "time, ms"}, {"faults", "faults"}};

TEST(Panels, AreOneAScene) {
    const ChartFigure figure =
        figureWith(R"({"x": "ms", "y": "faults", "by": ["accel"]})",
                   {dot("one", "bvh", {{"ms", 1}, {"faults", 0}}), dot("two", "bvh", {{"ms", 2}, {"faults", 1}}),
                    dot("one", "grid", {{"ms", 3}, {"faults", 2}}), dot("two", "grid", {{"ms", nullptr}, {"faults", 2}})});
    const std::vector<Panel> panels = panelsOf(figure, labels, "01");
    ASSERT_EQ(panels.size(), 2u);
    EXPECT_EQ(panels[0].title, "one");
    EXPECT_EQ(panels[0].stem, "01-fig-one");
    EXPECT_EQ(panels[0].xLabel, "time, ms");
    ASSERT_EQ(panels[0].series.size(), 2u);
    EXPECT_EQ(panels[0].series[1].label, "grid");
    EXPECT_EQ(panels[0].dots(), 2u);
    EXPECT_EQ(panels[1].dots(), 1u) << "what has no place on an axis that varies is no dot";
}

TEST(Panels, HaveFilesOfTheirOwn) {
    const ChartFigure figure =
        figureWith(R"({"x": "ms", "y": "faults"})",
                   {dot("a b", "x", {{"ms", 1}, {"faults", 1}}), dot("a/../b", "x", {{"ms", 1}, {"faults", 1}}),
                    dot("\xc3\xa9", "x", {{"ms", 1}, {"faults", 1}})});
    std::set<std::string> stems;
    for (const Panel& panel : panelsOf(figure, labels, "01")) {
        EXPECT_EQ(panel.stem.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789-_"), std::string::npos) << panel.stem;
        EXPECT_TRUE(stems.insert(panel.stem).second) << panel.stem;
    }
    EXPECT_EQ(stems.size(), 3u);
}

TEST(Panels, DrawAMethodThatFailsSomewhereHollowEverywhere) {
    const ChartFigure figure =
        figureWith(R"({"x": "ms", "y": "faults", "by": ["accel"], "hollow": "faults"})",
                   {dot("one", "leaky", {{"ms", 1}, {"faults", 0}}), dot("two", "leaky", {{"ms", 2}, {"faults", 1}}),
                    dot("one", "sound", {{"ms", 1}, {"faults", 0}}), dot("two", "sound", {{"ms", 2}, {"faults", 0}})});
    for (const Panel& panel : panelsOf(figure, labels, "01"))
        for (const Series& series : panel.series)
            for (const Dot& one : series.dots) EXPECT_EQ(one.hollow, series.label == "leaky");
}

TEST(Panels, MarkTheFrontOfWhatNothingBeats) {
    const ChartFigure figure =
        figureWith(R"({"x": "ms", "y": "faults", "by": ["accel"]})",
                   {dot("s", "a", {{"ms", 1}, {"faults", 9}}), dot("s", "b", {{"ms", 2}, {"faults", 9}}),
                    dot("s", "c", {{"ms", 3}, {"faults", 0}}), dot("s", "d", {{"ms", 4}, {"faults", 0}}),
                    dot("s", "e", {{"ms", 1}, {"faults", 12}})});
    const std::vector<Dot> front = paretoFront(panelsOf(figure, labels, "01")[0]);
    ASSERT_EQ(front.size(), 2u);
    EXPECT_EQ(front[0].x, 1.0);
    EXPECT_EQ(front[0].y, 9.0);
    EXPECT_EQ(front[1].x, 3.0);
}

TEST(Panels, DrawWhatHasNoXAsALevel) {
    const ChartFigure figure =
        figureWith(R"({"x": "n", "y": "ms", "by": ["accel"], "style": "lines"})",
                   {{"s", {{"accel", "grid"}, {"n", 1}}, {{"ms", 5}}, ""}, dot("s", "bvh", {{"ms", 3}})});
    const Panel panel = panelsOf(figure, labels, "01").at(0);
    ASSERT_EQ(panel.series.size(), 2u);
    EXPECT_EQ(panel.series[1].levels, std::vector<double>{3.0});
}

/// All styles, on axes of all kinds, with zeros, names that need quoting, and a single dot.
std::vector<ChartFigure> hardFigures() {
    std::vector<ChartPoint> points;
    for (const double n : {0.0, 1.0, 2.0, 4.0, 1e6})
        for (const char* const accel : {"bvh", "it's \"odd\" $a {b} \\n", "<b>&amp;"})
            points.push_back({"s",
                              {{"accel", accel}, {"n", n}},
                              {{"ms", 3.0 * n}, {"faults", n == 1.0 ? 1e-9 : n}, {"bound", 10.0 * n}},
                              ""});
    const std::vector<ChartPoint> one = {{"s", {{"accel", "bvh"}, {"n", 3}}, {{"ms", 0}, {"faults", 0}, {"bound", 0}}, ""}};
    std::vector<ChartFigure> figures;
    for (const char* const log : {"", "x", "y", "xy"})
        for (const char* const style : {"points", "lines", "heat"})
            for (const auto& some : {points, one}) {
                Json draw = {{"title", "T"}, {"x", "n"},        {"y", "faults"},  {"by", {"accel"}}, {"style", style},
                             {"log", log},   {"band", "bound"}, {"theory", "ms"}, {"pareto", true},  {"guide", -0.5}};
                if (std::string(style) == "heat") draw["by"] = {"n"}, draw["contour"] = "ms";
                figures.push_back(figureWith(draw.dump(), some));
            }
    return figures;
}

TEST(Panels, AreDrawnAsSvgForLightAndDarkAndAsPng) {
    const test::TemporaryFolder folder;
    size_t number = 0;
    for (const ChartFigure& figure : hardFigures()) {
        const std::vector<Panel> panels = panelsOf(figure, labels, std::to_string(number++));
        ASSERT_EQ(panels.size(), 1u);
        const ChartPanel drawn = drawPanels(panels, folder.path).at(0);
        for (const std::string& svg : {drawn.light, drawn.dark}) {
            EXPECT_NE(svg.find("<svg"), std::string::npos) << drawn.stem;
            EXPECT_NE(svg.find("</svg>"), std::string::npos) << drawn.stem;
            EXPECT_EQ(svg.find("<b>"), std::string::npos) << "markup of names is escaped";
        }
        EXPECT_NE(drawn.light, drawn.dark);
        EXPECT_GT(std::filesystem::file_size(folder.path / (drawn.stem + ".png")), 5000u) << drawn.stem;
        EXPECT_NE(drawn.description.find("faults over n"), std::string::npos) << drawn.description;
    }
}

TEST(Gnuplot, SaysWhatIsWrong) {
    try {
        runGnuplot("plot nonsense(\n");
        FAIL() << "a script that is none";
    } catch (const Error& error) {
        EXPECT_NE(std::string(error.what()).find("gnuplot: could not draw a figure: "), std::string::npos) << error.what();
    }
}

}  // namespace
}  // namespace raig
