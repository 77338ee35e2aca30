// The page of `raig chart`: what it says, and in what order.
#include "measure/chart_page_parts.hpp"
#include "support/chart_documents.hpp"

#include <gtest/gtest.h>

#include <cmath>

namespace raig {
namespace {

size_t countOf(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = 0; (at = text.find(part, at)) != std::string::npos; at += part.size()) ++count;
    return count;
}

TEST(ChartPage, NamesWhatFailsBeforeAnySpeed) {
    const std::string page = chartPage(test::chartDocument());
    const size_t speeds = page.find("id=\"pictures\"");
    ASSERT_NE(speeds, std::string::npos);
    for (const char* failure : {"4 measurements lie where theory says they cannot", "391 of 97,200 hits are missed",
                                "rmse falls with spp by a slope of -0.4000", "rmse is 0.2",
                                "3 of 97,200 pixels are not finite", "Möller–Trumbore", "area lights", "a finer integrator"})
        EXPECT_LT(page.find(failure), speeds) << failure;
    EXPECT_LT(page.find("accumulated DDA"), page.find("Möller–Trumbore")) << "the worst comes first";
    EXPECT_EQ(page.find("seconds on the device"), page.find("seconds on the device", speeds));
    EXPECT_NE(page.find("4 configurations left out: the structure needs 3.2 GiB"), std::string::npos);
}

TEST(ChartPage, SaysHowManyLawsHeld) {
    ChartDocument document = test::chartDocument();
    document.figures[2].breaches.clear();
    document.pictures.clear();
    const std::string page = chartPage(document);
    EXPECT_NE(page.find("4 laws of theory held"), std::string::npos);
    EXPECT_EQ(page.find("where theory says"), std::string::npos);
}

TEST(ChartPage, IsThereWithoutAnyData) {
    EXPECT_NE(chartPage({}).find("0 configurations measured"), std::string::npos);
    ChartDocument document = test::chartDocument();
    for (ChartFigure& figure : document.figures) {
        figure.breaches.clear();
        for (ChartPoint& point : figure.points) point.leftOut = "it takes too long";
    }
    const std::string page = chartPage(document);
    EXPECT_NE(page.find("120 left out"), std::string::npos);
    EXPECT_EQ(page.find(" held"), std::string::npos) << "nothing was measured, so nothing held";
    EXPECT_EQ(page.find("Held"), std::string::npos);
    EXPECT_EQ(page.find("Hit faults"), std::string::npos);
}

TEST(ChartPage, ShowsTheWorstOfAMethodOnAScene) {
    ChartDocument document = test::chartDocument();
    document.figures.resize(1);
    ChartFigure& figure = document.figures[0];
    figure.points.resize(4);
    const double missed[] = {2.0, 31.5, 7.25, 0.0};
    for (size_t i = 0; i < 4; ++i) {
        figure.points[i].settings["label"] = i < 3 ? "a method" : "another";
        figure.points[i].measures["missed"] = missed[i];
    }
    const std::string page = chartPage(document), part = page.substr(0, page.find("id=\"pictures\""));
    EXPECT_NE(part.find(">31.5</td>"), std::string::npos);
    EXPECT_EQ(part.find(">7.25</td>"), std::string::npos);
    EXPECT_NE(part.find("data-value=\"3\">3</td>"), std::string::npos) << "configurations";
    figure.points[0].settings.erase("label");
    figure.points[0].settings["accel"] = "grid";
    figure.points[0].scene.clear();
    EXPECT_NE(chartPage(document).find("<td class=\"what\">grid</td>"), std::string::npos) << "named by what tells it apart";
    EXPECT_NE(part.find("1 pair of a method and a scene without a fault"), std::string::npos);
}

TEST(ChartPage, EscapesWhatComesFromOutside) {
    const std::string page = chartPage(test::chartDocument());
    EXPECT_EQ(page.find("<img src=x"), std::string::npos);
    EXPECT_EQ(countOf(page, "</script>"), 2u);
    EXPECT_NE(page.find("&lt;/script&gt;&lt;img src=x"), std::string::npos);
    EXPECT_NE(page.find("year 19??, Mesa"), std::string::npos);
    EXPECT_NO_THROW(Json(page).dump()) << "it is UTF-8";
    EXPECT_EQ(page::fileLink("../a b\".svg", "x"), "<a href=\"./..%2Fa%20b%22.svg\">x</a>");
}

TEST(ChartPage, WritesNumbersForReading) {
    for (const auto& [value, text] : std::vector<std::pair<double, const char*>>{{0.0, "0"},
                                                                                 {-0.0, "0"},
                                                                                 {7.0, "7"},
                                                                                 {1234567.0, "1,234,567"},
                                                                                 {-1234.0, "−1,234"},
                                                                                 {0.123456, "0.1235"},
                                                                                 {9999.7, "10,000"},
                                                                                 {4859.9, "4,860"},
                                                                                 {999.97, "1,000"},
                                                                                 {999.9, "999.9"},
                                                                                 {123456.7, "123,457"},
                                                                                 {0.0001, "0.0001"},
                                                                                 {-1.2345e-5, "−1.234·10⁻⁵"},
                                                                                 {1e-300, "1·10⁻³⁰⁰"},
                                                                                 {9.9999e-5, "1·10⁻⁴"},
                                                                                 {2e20, "2·10²⁰"},
                                                                                 {NAN, "–"},
                                                                                 {INFINITY, "–"}})
        EXPECT_EQ(page::number(value), text) << value;
    EXPECT_EQ(page::value(Json()), "–");
}

TEST(ChartPage, RaisesPowers) {
    EXPECT_EQ(page::prose("10^6 & K^(N+1), 2^-5; x^y, 3^, ^(a^(b)"),
              "10<sup>6</sup> &amp; K<sup>N+1</sup>, 2<sup>-5</sup>; x^y, 3^, ^(a<sup>b</sup>");
    EXPECT_EQ(page::prose("^(<b>)"), "^(&lt;b&gt;)");
}

TEST(ChartPage, HoldsPicturesAsTheyAre) {
    EXPECT_EQ(page::dataUri("a/b", std::string_view("")), "data:a/b;base64,");
    EXPECT_EQ(page::dataUri("a/b", std::string_view("M")), "data:a/b;base64,TQ==");
    EXPECT_EQ(page::dataUri("a/b", std::string_view("Ma")), "data:a/b;base64,TWE=");
    EXPECT_EQ(page::dataUri("a/b", std::string_view("Man")), "data:a/b;base64,TWFu");
    EXPECT_EQ(page::dataUri("a/b", std::string_view("\xfb\xff\xbe")), "data:a/b;base64,+/++");
}

}  // namespace
}  // namespace raig
