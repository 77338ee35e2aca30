// Exposure and tone curves: light doubles with each stop, curves keep black and order, and files of light keep light.
#include "image/tone.hpp"
#include "base/random.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <algorithm>
#include <cmath>
#include <fstream>
#include <limits>

namespace raig {
namespace {

constexpr Tone curves[] = {Tone::none, Tone::reinhard, Tone::filmic, Tone::aces, Tone::neutral};

Image random(uint64_t seed, uint32_t side = 16) {
    Random numbers(seed);
    Image image(side, side);
    for (vec3& c : image.pixels)
        for (int k = 0; k < 3; ++k) c[k] = static_cast<float>(std::exp2(-8.0 + 12.0 * numbers.unit()));
    return image;
}

vec3 bentColour(const vec3& colour, Tone tone) {
    Image image(1, 1, colour);
    bend(image, tone);
    return image.pixels[0];
}

float grey(float light, Tone tone) {
    return bentColour(vec3(light), tone).x;
}

TEST(Exposure, DoublesTheLightWithEachStop) {
    const Image before = random(1);
    for (const int stops : {-7, -1, 0, 1, 5}) {
        Image image = before;
        expose(image, stops);
        for (size_t i = 0; i < image.pixels.size(); ++i)
            EXPECT_EQ(image.pixels[i], before.pixels[i] * std::ldexp(1.0f, stops)) << "not a bit is lost";
    }
    Image half = before;
    expose(half, 0.5);
    expose(half, 0.5);
    for (size_t i = 0; i < half.pixels.size(); ++i)
        EXPECT_NEAR(half.pixels[i].y, 2.0f * before.pixels[i].y, 1e-6f * before.pixels[i].y);
}

TEST(SuitableExposure, BringsTheMeanLogarithmToMiddleGrey) {
    EXPECT_NEAR(*suitableStops(Image(3, 2, vec3(0.18f))), 0.0, 1e-6);
    EXPECT_NEAR(*suitableStops(Image(3, 2, vec3(0.72f))), -2.0, 1e-6);
    Image two(2, 1);
    two.pixels = {vec3(0.09f), vec3(0.36f)};
    EXPECT_NEAR(*suitableStops(two), 0.0, 1e-6) << "a stop below and a stop above";
    Image image = random(2);
    const double stops = *suitableStops(image);
    expose(image, stops);
    EXPECT_NEAR(*suitableStops(image), 0.0, 1e-6);
}

TEST(SuitableExposure, IsOneStopLessForTwiceTheLightAtAnyScale) {
    const Image before = random(3);
    const double stops = *suitableStops(before);
    for (const int more : {-80, -1, 1, 9, 80}) {
        Image image = before;
        expose(image, more);
        EXPECT_NEAR(*suitableStops(image), stops - more, 1e-9);
    }
}

TEST(SuitableExposure, IgnoresWhatIsBlackOrNoNumberAndIsHardlyMovedByWhatIsNearlyBlack) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    Image image(4, 2, vec3(0.5f));
    const double stops = *suitableStops(image);
    for (size_t i = 0; i < 4; ++i) image.pixels[i] = vec3(0.0f);
    image.pixels[4] = vec3(nan);
    image.pixels[5] = vec3(infinite);
    EXPECT_NEAR(*suitableStops(image), stops, 1e-12);
    image.pixels[0] = vec3(1e-30f);
    EXPECT_LT(*suitableStops(image) - stops, 11.0 / 3.0) << "at most 10 stops and a little for one of three pixels";
    EXPECT_EQ(suitableStops(Image(3, 3)), std::nullopt);
}

TEST(ToneCurves, KeepBlackBlackAndNeverDarkenWhatIsBrighter) {
    for (const Tone tone : curves) {
        EXPECT_EQ(bentColour(vec3(0.0f), tone), vec3(0.0f)) << nameOf(tone);
        for (const vec3& colour : {vec3(1.0f), vec3(1.0f, 0.5f, 0.2f), vec3(0.0f, 0.1f, 1.0f), vec3(0.3f, 0.3f, 0.29f)}) {
            vec3 last(0.0f);
            for (double stops = -20.0; stops < 40.0; stops += 0.01) {
                const vec3 now = bentColour(static_cast<float>(std::exp2(stops)) * colour, tone);
                for (int k = 0; k < 3 && tone != Tone::neutral; ++k) ASSERT_GE(now[k], last[k]) << nameOf(tone) << stops;
                const auto brightest = [](const vec3& c) { return std::max({c.x, c.y, c.z}); };
                ASSERT_GE(brightest(now), brightest(last)) << nameOf(tone) << ' ' << stops;
                if (tone != Tone::none) {
                    ASSERT_LE(brightest(now), 1.0f);
                }
                last = now;
            }
        }
    }
}

TEST(ToneCurves, HaveTheValuesOfTheirSources) {
    EXPECT_EQ(grey(3.0f, Tone::none), 3.0f);
    EXPECT_FLOAT_EQ(grey(1.0f, Tone::reinhard), 0.5f);
    EXPECT_FLOAT_EQ(grey(3.0f, Tone::reinhard), 0.75f);
    EXPECT_FLOAT_EQ(grey(5.6f, Tone::filmic), 1.0f);
    // At 1 (2 with the bias), by hand: (2 (0.3 + 0.05) + 0.004) / (2 (0.3 + 0.5) + 0.06) - 1 / 15, over that of 11.2.
    const double atWhite = (11.2 * 1.73 + 0.004) / (11.2 * 2.18 + 0.06) - 1.0 / 15.0;
    EXPECT_NEAR(grey(1.0f, Tone::filmic), (0.704 / 1.66 - 1.0 / 15.0) / atWhite, 1e-6);
    EXPECT_NEAR(grey(1.0f, Tone::aces), 2.54 / 3.16, 1e-6);
    EXPECT_FLOAT_EQ(grey(0.5f, Tone::neutral), 0.46f);
    EXPECT_NEAR(grey(0.04f, Tone::neutral), 6.25 * 0.04 * 0.04, 1e-7);
    const float bright = grey(2.0f, Tone::neutral);
    EXPECT_NEAR(bright, 1.0 - 0.24 * 0.24 / (1.96 + 0.24 - 0.76), 1e-6);
    const vec3 red = bentColour(vec3(50.0f, 1.0f, 1.0f), Tone::neutral);
    EXPECT_GT(red.y, 0.7f) << "drawn to white";
}

TEST(ToneCurves, TakeEveryLight) {
    const float nan = std::numeric_limits<float>::quiet_NaN(), infinite = std::numeric_limits<float>::infinity();
    for (const Tone tone : curves) {
        EXPECT_EQ(findTone(nameOf(tone)), tone);
        if (tone == Tone::none) continue;
        EXPECT_EQ(bentColour(vec3(-1.0f), tone), vec3(0.0f));
        EXPECT_GT(grey(infinite, tone), 0.99f);
        EXPECT_LE(grey(infinite, tone), 1.0f);
        EXPECT_TRUE(std::isnan(bentColour(vec3(0.5f, nan, 0.5f), tone).y));
    }
    EXPECT_EQ(findTone("sepia"), std::nullopt);
    EXPECT_EQ(toneNames().size(), std::size(curves));
}

// ---- The command -------------------------------------------------------------------------------------------------------

class ToneCommand : public testing::Test {
protected:
    ProgramResult render(const std::string& file, std::vector<std::string> arguments) {
        const std::vector<std::string> all{"render",   scene,
                                           "-o",       pathOf(file),
                                           "--size",   "24x24",
                                           "--spp",    "1",
                                           "--device", "cpu"};
        arguments.insert(arguments.begin(), all.begin(), all.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }
    Image picture(const std::string& file, std::vector<std::string> arguments) {
        arguments.push_back("--quiet");
        const ProgramResult result = render(file, arguments);
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return readPicture(pathOf(file));
    }
    std::string pathOf(const std::string& name) { return (place / name).string(); }

    std::string scene = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";
    const Folder folder;
    const std::filesystem::path place = folder.write("made", "").parent_path();
};

TEST_F(ToneCommand, ExposesEveryFormatAndKeepsItsLightLinear) {
    for (const std::string ending : {".pfm", ".exr"}) {
        const Image plain = picture("plain" + ending, {}), bright = picture("bright" + ending, {"--exposure", "3"});
        for (size_t i = 0; i < plain.pixels.size(); ++i) EXPECT_EQ(bright.pixels[i], 8.0f * plain.pixels[i]);
    }
    Image light = picture("light.pfm", {});
    expose(light, -1.5);
    bend(light, Tone::aces);
    const Image shown = picture("shown.png", {"--exposure=-1.5", "--tonemap", "aces"});
    EXPECT_EQ(shown.pixels, decodePicture(encodePicture(light, PictureFormat::png), "memory").pixels);
}

TEST_F(ToneCommand, ExposesByItselfAndSaysHow) {
    const Image light = picture("light.pfm", {});
    const ProgramResult result = render("auto.pfm", {"--exposure", "auto", "--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const auto json = nlohmann::json::parse(result.output);
    EXPECT_NEAR(json["exposure"].get<double>(), *suitableStops(light), 1e-12);
    EXPECT_EQ(json["tonemap"], "none");
    EXPECT_NE(result.errors.find("exposure: "), std::string::npos) << result.errors;
    EXPECT_NEAR(*suitableStops(readPicture(pathOf("auto.pfm"))), 0.0, 1e-5);
}

TEST_F(ToneCommand, ShowsWhatWouldBeTooDarkOrTooBrightInPngsOnly) {
    const Image light = picture("light.pfm", {});
    for (const double factor : {1e-3, 1e3}) {
        auto file = nlohmann::json::parse(std::ifstream(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"));
        for (auto& material : file["materials"]) {
            if (!material.contains("extensions")) continue;
            auto& strength = material["extensions"]["KHR_materials_emissive_strength"]["emissiveStrength"];
            strength = factor * strength.get<double>();
        }
        scene = folder.write("scene.gltf", file.dump()).string();
        const ProgramResult seen = render("seen.png", {"--json"}), kept = render("kept.pfm", {"--json"}),
                            asked = render("asked.png", {"--json", "--exposure", "0"});
        const auto stopsOf = [](const ProgramResult& result) {
            EXPECT_EQ(result.exitCode, 0) << result.errors;
            return nlohmann::json::parse(result.output)["exposure"].get<double>();
        };
        EXPECT_NEAR(stopsOf(seen), *suitableStops(readPicture(pathOf("kept.pfm"))), 1e-12);
        EXPECT_NE(seen.errors.find("--exposure 0 shows light as it is"), std::string::npos) << seen.errors;
        EXPECT_EQ(stopsOf(kept), 0.0);
        EXPECT_EQ(stopsOf(asked), 0.0);
    }
}

TEST_F(ToneCommand, WarnsOfPicturesThatAreBlack) {
    auto file = nlohmann::json::parse(std::ifstream(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"));
    for (auto& material : file["materials"]) material["pbrMetallicRoughness"]["baseColorFactor"] = {0, 0, 0, 1};
    scene = folder.write("scene.gltf", file.dump()).string();
    const std::vector<std::string> awayFromTheLamp = {"--eye", "278,400,-100", "--at", "278,0,0", "--quiet"};
    for (std::vector<std::string> more : {std::vector<std::string>{}, {"--exposure", "auto"}}) {
        more.insert(more.end(), awayFromTheLamp.begin(), awayFromTheLamp.end());
        const ProgramResult black = render("black.png", more);
        EXPECT_EQ(black.exitCode, 0);
        EXPECT_NE(black.errors.find("black.png: the picture is black"), std::string::npos) << black.errors;
    }
    EXPECT_EQ(render("kept.pfm", awayFromTheLamp).errors, "") << "light as it is";
}

TEST_F(ToneCommand, RefusesCurvesWhereLightIsKeptAndWhatThereIsNot) {
    const auto expectRefused = [&](const std::string& file, const std::vector<std::string>& arguments,
                                   const std::string& mentions) {
        const ProgramResult result = render(file, arguments);
        EXPECT_EQ(result.exitCode, 2) << result.errors;
        EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors;
        EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
    };
    for (const char* const file : {"a.exr", "a.hdr", "a.pfm"})
        expectRefused(file, {"--tonemap", "reinhard"}, "keeps light as it is");
    expectRefused("a.png", {"--tonemap", "sepia"}, "none, reinhard, filmic, aces, neutral");
    for (const char* const stops : {"bright", "nan", "inf", "101", "-101", "1stop", "Auto"})
        expectRefused("a.png", {std::string("--exposure=") + stops}, "stops from -100 to 100 are wanted, or auto");
    EXPECT_EQ(picture("a.exr", {"--tonemap", "none"}).width, 24u);
}

}  // namespace
}  // namespace raig
