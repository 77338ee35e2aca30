// The page of `raig chart` in a browser: all of it is seen, on wide and narrow screens, in light and dark, with scripts and
// without; it asks for nothing; sliders and tables work.
#include "support/browser.hpp"
#include "support/chart_documents.hpp"

#include <fmt/format.h>
#include <gtest/gtest.h>

#include <unistd.h>

#include <algorithm>
#include <array>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <memory>
#include <tuple>

namespace raig {
namespace {

namespace fs = std::filesystem;

/// In chromium, with a page written to a file.
class InBrowser : public testing::Test {
protected:
    void SetUp() override {
        if (!Browser::program()) GTEST_SKIP() << "no chromium here, which Debian's package of that name installs";
        fs::create_directories(folder);
        browser = std::make_unique<Browser>();
    }
    void TearDown() override {
        if (browser) {
            EXPECT_EQ(complaints(), "");
            EXPECT_EQ(fmt::format("{}", fmt::join(browser->requests(), "\n")), "") << "is what it asked for";
        }
        browser.reset();
        std::error_code ignored;
        fs::remove_all(folder, ignored);
    }

    void write(const std::string& page) const { std::ofstream(file, std::ios::binary) << page; }
    void show(const BrowserView& view = {}) {
        static const std::string page = chartPage(test::chartDocument());
        write(page);
        browser->open(file, view);
    }
    std::string complaints() const { return fmt::format("{}", fmt::join(browser->complaints(), "\n")); }
    nlohmann::json value(const std::string& expression) { return browser->evaluate(expression); }

    /// Leaves a picture of the page in the folder that RAIG_SCREENSHOTS names, if it does, for someone to look at.
    void keep(const std::string& name) {
        if (const char* pictures = std::getenv("RAIG_SCREENSHOTS"))
            browser->screenshot(fs::path(pictures) / ("chart_" + name + ".png"));
    }

    /// Where an element is, once it is in view: x, y, width, height.
    std::array<double, 4> place(const std::string& selector) {
        return value("(() => { const e = document.querySelector('" + selector +
                     "'); e.scrollIntoView({ block: 'center', behavior: 'instant' }); const r = e.getBoundingClientRect();"
                     "return [r.x, r.y, r.width, r.height]; })()");
    }
    void click(const std::string& selector) {
        const auto [x, y, width, height] = place(selector);
        browser->click(x + width / 2, y + height / 2);
    }
    /// The texts of a column of a figure's table, from the top.
    std::vector<std::string> column(const std::string& figure, int number) {
        return value("[...document.querySelectorAll('#fig-" + figure + " tbody tr')].map(r => r.cells[" +
                     std::to_string(number) + "].textContent)");
    }

    const fs::path folder = fs::path(testing::TempDir()) / ("chart_browser_test." + std::to_string(::getpid()));
    const fs::path file = folder / "index #1?.html";
    std::unique_ptr<Browser> browser;
};

TEST_F(InBrowser, ShowsEveryFigureAtAnyWidthAndAsksForNothing) {
    for (const auto& [width, isDark, hasScript] : {std::tuple(1280, false, true),
                                                   {1280, true, true},
                                                   {390, false, true},
                                                   {390, true, true},
                                                   {390, false, false},
                                                   {1280, false, false},
                                                   {820, false, true}}) {
        SCOPED_TRACE(fmt::format("{} pixels, {}, script {}", width, isDark ? "dark" : "light", hasScript ? "on" : "off"));
        show({width, 900, isDark, hasScript});
        EXPECT_EQ(value("innerWidth"), width);
        EXPECT_LE(value("document.documentElement.scrollWidth"), width) << "the page must not scroll sideways";
        const nlohmann::json images = value(
            "[...document.querySelectorAll('.panels img')].map(i => { const r = i.getBoundingClientRect();"
            "return { natural: i.naturalWidth, left: r.left, right: r.right, width: r.width, height: r.height,"
            "alt: i.alt.length, ratio: r.width / r.height }; })");
        ASSERT_EQ(images.size(), 5u);
        for (const nlohmann::json& image : images) {
            EXPECT_GT(image["natural"], 0);
            EXPECT_GT(image["width"], 300.0);
            EXPECT_GE(image["left"], 0.0);
            EXPECT_LE(image["right"], width);
            EXPECT_NEAR(image["ratio"], 600.0 / 440.0, 0.02);
            EXPECT_GT(image["alt"], 10);
        }
        const size_t columns = value(
            "new Set([...document.querySelectorAll('#fig-methods .panels img')].map(i => Math.round("
            "i.getBoundingClientRect().left))).size");
        EXPECT_EQ(columns, width >= 1280 ? 2u : 1u);
        EXPECT_TRUE(browser->complaints().empty());
        EXPECT_TRUE(browser->requests().empty());
        keep(fmt::format("{}_{}{}", width, isDark ? "dark" : "light", hasScript ? "" : "_no_script"));
    }
}

TEST_F(InBrowser, ShowsFiguresForDarkSurroundingsInTheDark) {
    const std::string drawing = "(i => atob(i.currentSrc.split(',')[1]).match(/id=\"(\\w+)\"/)[1])";
    for (const bool isDark : {false, true})
        for (const bool hasScript : {false, true}) {
            show({1280, 900, isDark, hasScript});
            const std::vector<std::string> ids = value("[...document.querySelectorAll('.panels img')].map" + drawing);
            EXPECT_EQ(ids, std::vector<std::string>(5, isDark ? "dark" : "light"));
        }
}

TEST_F(InBrowser, MovesTheSliderByMouseAndKeys) {
    for (const int width : {390, 1280}) {
        show({.width = width, .height = 900});
        const auto cut = [&](int picture) {
            return 100.0 - value(fmt::format("parseFloat(getComputedStyle(document.querySelector('#pictures-{} .device'))"
                                             ".clipPath.match(/^inset\\(0px ([\\d.]+)% 0px 0px\\)$/)[1])",
                                             picture))
                               .get<double>();
        };
        EXPECT_EQ(cut(0), 50.0);
        const auto [x, y, wide, high] = place("#pictures-0 .reference img");
        for (const double part : {0.2, 0.0, 1.0, 0.65}) {
            browser->drag(x + wide / 2, y + high / 2, x + part * wide, y + high / 3);
            EXPECT_NEAR(cut(0), 100.0 * part, 1.0) << "the border is where the mouse is";
        }
        const auto [left, top, across, down] = place("#pictures-0 .handle");
        EXPECT_NEAR(left + across / 2, x + cut(0) / 100.0 * wide, 1.0);
        EXPECT_EQ(down, high);
        const double dragged = cut(0);
        browser->press("ArrowLeft");
        EXPECT_LT(cut(0), dragged);
        browser->press("ArrowRight");
        browser->press("ArrowRight");
        EXPECT_GT(cut(0), dragged);
        EXPECT_EQ(cut(1), 50.0) << "each picture has a slider of its own";
    }
}

TEST_F(InBrowser, ShowsTheDifferenceWhenItIsPicked) {
    show();
    const auto shown = [&] {
        return value(
            "[...document.querySelectorAll('#pictures-0 .stage > *')].filter(e => e.checkVisibility()).map(e => "
            "e.className)");
    };
    const nlohmann::json slider = {"device", "reference", "cut", "handle"}, difference = {"difference"};
    EXPECT_EQ(shown(), slider);
    click("#pictures-0 label:has([value=difference])");
    EXPECT_EQ(shown(), difference);
    keep("difference");
    browser->press("ArrowLeft");
    EXPECT_EQ(shown(), slider) << "keys pick, too";
}

TEST_F(InBrowser, SortsTablesBothWays) {
    show();
    click("#fig-methods summary");
    const std::vector<std::string> scenes = column("methods", 0), labels = column("methods", 1),
                                   times = column("methods", 2), wrong = column("methods", 5);
    ASSERT_EQ(labels.size(), 24u);
    EXPECT_EQ(value("document.querySelectorAll('#fig-methods [aria-sort]').length"), 0);
    const auto sorted = [&](int number) {
        click(fmt::format("#fig-methods th:nth-child({}) button", number + 1));
        return value(fmt::format("document.querySelector('#fig-methods th:nth-child({})').ariaSort", number + 1))
            .get<std::string>();
    };

    EXPECT_EQ(sorted(2), "ascending");
    std::vector<std::string> slowest{"520", "520", "261.5", "261.5", "175.3"};
    std::vector<std::string> found = column("methods", 2);
    EXPECT_EQ(found.front(), "46.08") << "by number, not by text";
    EXPECT_TRUE(std::equal(slowest.begin(), slowest.end(), found.rbegin()));
    EXPECT_EQ(sorted(2), "descending");
    found = column("methods", 2);
    EXPECT_TRUE(std::equal(slowest.begin(), slowest.end(), found.begin()));
    found = column("methods", 0);
    EXPECT_EQ(found[0], scenes.front()) << "equals keep their order";
    EXPECT_EQ(found[1], scenes.back());

    EXPECT_EQ(sorted(1), "ascending");
    EXPECT_EQ(value("document.querySelectorAll('#fig-methods [aria-sort]').length"), 1);
    found = column("methods", 1);
    EXPECT_EQ(found.front(), "accumulated DDA");
    EXPECT_LT(std::find(found.begin(), found.end(), "BVH 8"), std::find(found.begin(), found.end(), "Möller–Trumbore"));
    for (const char* order : {"ascending", "descending"}) {
        EXPECT_EQ(sorted(5), order);
        found = column("methods", 5);
        EXPECT_EQ(found[23], "–") << "what was not measured is last";
        EXPECT_EQ(found[22], "–");
        EXPECT_EQ(found[0], "0");
    }
    keep("sorted");
    browser->press("Enter");
    EXPECT_EQ(value("document.querySelector('#fig-methods th:nth-child(6)').ariaSort"), "ascending") << "keys sort, too";
}

TEST_F(InBrowser, ShowsAllWithoutScript) {
    for (const int width : {390, 1280}) {
        show({.width = width, .height = 900, .hasScript = false});
        EXPECT_EQ(value("document.documentElement.className"), "") << "no script has run";
        const nlohmann::json pictures = value(
            "[...document.querySelectorAll('#pictures-0 figure')].map(f => { const r = f.querySelector('img')"
            ".getBoundingClientRect(); return [f.className, r.left, r.top, r.width, getComputedStyle(f).clipPath]; })");
        ASSERT_EQ(pictures.size(), 3u);
        for (size_t i = 0; i < 3; ++i) {
            EXPECT_EQ(pictures[i][0], std::vector<const char*>({"device", "reference", "difference"})[i]);
            EXPECT_GT(pictures[i][3], 300.0);
            EXPECT_EQ(pictures[i][4], "none");
        }
        const size_t along = width == 1280 ? 1 : 2, across = 3 - along;
        EXPECT_GT(pictures[1][along], pictures[0][along]) << "beside each other, or, where it is narrow, below";
        EXPECT_EQ(pictures[1][across], pictures[0][across]);
        EXPECT_EQ(
            value("[...document.querySelectorAll('.cut, .picker, th button')].filter(e => e.checkVisibility()).length"), 0);
        click("#fig-methods summary");
        EXPECT_EQ(column("methods", 1).size(), 24u);
        keep(fmt::format("{}_table", width));
        EXPECT_TRUE(value("document.querySelector('#fig-methods table').checkVisibility()"));
        EXPECT_LE(value("document.documentElement.scrollWidth"), width) << "tables scroll in boxes of their own";
    }
}

TEST_F(InBrowser, ShowsNamesWithMarkupAsText) {
    show();
    EXPECT_EQ(value("document.querySelector('#pictures-1 h3').textContent"), test::hostileName);
    EXPECT_EQ(value("document.querySelectorAll('script').length"), 2);
    EXPECT_EQ(value("document.querySelectorAll('img:not([src^=\"data:image/\"])').length"), 0);
    EXPECT_EQ(value("document.querySelector('#pictures-1 .device img').alt"),
              std::string(test::hostileName) + ", by the device");
}

// What the tests above rely on: that the browser tells of trouble.
TEST_F(InBrowser, IsSeenToComplainAndToAsk) {
    write("<!DOCTYPE html><img src=\"none.png\"><script>console.error('printed'); throw new Error('thrown');</script>");
    browser->open(file, {});
    EXPECT_NE(complaints().find("printed"), std::string::npos) << complaints();
    EXPECT_NE(complaints().find("thrown"), std::string::npos) << complaints();
    ASSERT_EQ(browser->requests().size(), 1u);
    EXPECT_TRUE(browser->requests()[0].ends_with("/none.png"));
    show();
}

// The page's own policy: even markup that got into it could load nothing.
TEST_F(InBrowser, MayLoadNothing) {
    show();
    EXPECT_EQ(
        value(
            "new Promise(done => { const i = new Image(); i.onerror = i.onload = e => done(e.type); i.src = 'none.png'; })"),
        "error");
    EXPECT_NE(complaints().find("Content Security Policy"), std::string::npos) << complaints();
    show();
}

}  // namespace
}  // namespace raig
