// `raig render --aov` and `--view`: what is in the files, by OpenEXR's own reader, and what is refused before the work.
#include "image/image.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <ImfChannelList.h>
#include <ImfFrameBuffer.h>
#include <ImfHeader.h>
#include <ImfInputFile.h>

#include <algorithm>
#include <bit>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <map>

namespace raig {
namespace {

namespace fs = std::filesystem;
using Arguments = std::vector<std::string>;

const std::string spheres = std::string(RAIG_SOURCE_DIR) + "/assets/cornell_spheres.gltf";
const std::string everything = "depth,position,normal,uv,primitive,instance,material,albedo,samples,level,weight,cost";
constexpr uint32_t width = 80, height = 60;
constexpr size_t pixels = size_t{width} * height;

/// A folder of the test's own, gone when the test is.
class AovFiles : public testing::Test {
protected:
    AovFiles() {
        folder = fs::path(testing::TempDir()) /
                 (std::string("aov_") + testing::UnitTest::GetInstance()->current_test_info()->name());
        fs::remove_all(folder);
        fs::create_directories(folder);
    }
    ~AovFiles() override { fs::remove_all(folder); }

    ProgramResult render(const std::string& output, const Arguments& more, const std::string& scene = spheres) const {
        Arguments arguments = {"render", scene,   "-o", (folder / output).string(), "--size", "80x60", "--device",
                               "cpu",    "--spp", "2"};
        arguments.insert(arguments.end(), more.begin(), more.end());
        return runProgram(RAIG_PROGRAM, arguments);
    }
    std::vector<std::string> files() const {
        std::vector<std::string> names;
        for (const auto& entry : fs::directory_iterator(folder)) names.push_back(entry.path().filename());
        std::ranges::sort(names);
        return names;
    }

    fs::path folder;
};

/// All channels of an exr, each as words, with whether they are whole numbers.
struct Channels {
    explicit Channels(const fs::path& path, uint32_t wide = width, uint32_t high = height) : file(path.c_str(), 0) {
        Imf::FrameBuffer frame;
        for (auto it = file.header().channels().begin(); it != file.header().channels().end(); ++it) {
            std::vector<uint32_t>& words = of[it.name()];
            words.resize(size_t{wide} * high);
            isWhole[it.name()] = it.channel().type == Imf::UINT;
            frame.insert(it.name(), Imf::Slice(it.channel().type, reinterpret_cast<char*>(words.data()), 4, 4 * wide));
        }
        const Imath::Box2i window = file.header().dataWindow();
        EXPECT_EQ(window.max.x - window.min.x + 1, int(wide));
        EXPECT_EQ(window.max.y - window.min.y + 1, int(high));
        file.setFrameBuffer(frame);
        file.readPixels(window.min.y, window.max.y);
    }
    float number(const std::string& name, size_t i) const { return std::bit_cast<float>(of.at(name).at(i)); }

    Imf::InputFile file;
    std::map<std::string, std::vector<uint32_t>> of;
    std::map<std::string, bool> isWhole;
};

TEST_F(AovFiles, AreLayersOfTheOneExr) {
    ASSERT_EQ(render("out.exr", {"--aov", everything}).exitCode, 0);
    ASSERT_EQ(render("plain.exr", {}).exitCode, 0);
    EXPECT_EQ(files(), (std::vector<std::string>{"out.exr", "plain.exr"}));
    const Channels all(folder / "out.exr"), plain(folder / "plain.exr");
    const std::map<std::string, bool> want = {
        {"R", false},          {"G", false},          {"B", false},           {"depth.Z", false},    {"position.X", false},
        {"position.Y", false}, {"position.Z", false}, {"normal.X", false},    {"normal.Y", false},   {"normal.Z", false},
        {"uv.U", false},       {"uv.V", false},       {"primitive.ID", true}, {"instance.ID", true}, {"material.ID", true},
        {"albedo.R", false},   {"albedo.G", false},   {"albedo.B", false},    {"samples.N", true},   {"level.N", true},
        {"weight.Y", false},   {"cost.N", true}};
    EXPECT_EQ(all.isWhole, want);
    for (const char* name : {"R", "G", "B"}) EXPECT_EQ(all.of.at(name), plain.of.at(name)) << "the picture is the same";
    EXPECT_EQ(readPicture(folder / "out.exr").pixels, readPicture(folder / "plain.exr").pixels);

    size_t none = 0;
    for (size_t i = 0; i < pixels; ++i) {
        const bool isNone = all.of.at("primitive.ID")[i] == 0xffffffffu;
        none += isNone;
        EXPECT_EQ(std::isinf(all.number("depth.Z", i)), isNone);
        EXPECT_EQ(all.of.at("instance.ID")[i] == 0xffffffffu, isNone);
        EXPECT_EQ(all.of.at("material.ID")[i] == 0xffffffffu, isNone);
        const double squared = std::pow(all.number("normal.X", i), 2) + std::pow(all.number("normal.Y", i), 2) +
                               std::pow(all.number("normal.Z", i), 2);
        EXPECT_NEAR(squared, isNone ? 0.0 : 1.0, 1e-6);
        EXPECT_EQ(all.of.at("samples.N")[i], 2u);
        EXPECT_GT(all.of.at("cost.N")[i], 0u);
        EXPECT_LE(all.of.at("level.N")[i], 8u);
    }
    EXPECT_GT(none, 0u) << "the box does not fill a picture of 4 : 3";
    EXPECT_LT(none, pixels / 2);
}

TEST_F(AovFiles, OfAPartAreTheWholesAndNoLensNorExposureChangesThoseOfThePixelsCentre) {
    const Arguments view = {"--aov", everything, "--eye", "200,300,-700", "--at", "278,273,280", "--fov", "50"};
    const auto with = [&](Arguments more) {
        more.insert(more.end(), view.begin(), view.end());
        return more;
    };
    ASSERT_EQ(render("whole.exr", with({})).exitCode, 0);
    ASSERT_EQ(render("part.exr", with({"--crop", "13,7,41,30"})).exitCode, 0);
    ASSERT_EQ(render("lens.exr", with({"--aperture", "60", "--exposure", "3"})).exitCode, 0);
    const Channels all(folder / "whole.exr"), part(folder / "part.exr", 41, 30), lens(folder / "lens.exr");
    ASSERT_EQ(part.isWhole, all.isWhole);
    for (const auto& [name, words] : part.of)
        for (size_t i = 0; i < words.size(); ++i)
            ASSERT_EQ(words[i], all.of.at(name)[(7 + i / 41) * width + 13 + i % 41]) << name << ", pixel " << i;
    for (const char* name : {"depth.Z", "position.X", "normal.Y", "uv.U", "primitive.ID", "albedo.R"})
        EXPECT_EQ(lens.of.at(name), all.of.at(name)) << name;
    EXPECT_NE(lens.of.at("R"), all.of.at("R"));
    EXPECT_NE(all.of.at("depth.Z"), std::vector<uint32_t>(pixels, all.of.at("depth.Z")[0]));

    ASSERT_EQ(render("plain.png", {"--view", "depth"}).exitCode, 0);
    ASSERT_EQ(render("shown.png", {"--view", "depth", "--exposure", "3", "--tonemap", "aces"}).exitCode, 0);
    EXPECT_EQ(readPicture(folder / "shown.png").pixels, readPicture(folder / "plain.png").pixels);
}

TEST_F(AovFiles, LieBesideAPictureOfAnotherFormat) {
    ASSERT_EQ(render("out.exr", {"--aov", "depth,primitive,cost"}).exitCode, 0);
    ASSERT_EQ(render("out.png", {"--aov", "depth,primitive,cost,depth"}).exitCode, 0);
    ASSERT_EQ(render("plain.png", {}).exitCode, 0);
    EXPECT_EQ(files(), (std::vector<std::string>{"out.cost.exr", "out.depth.exr", "out.exr", "out.png", "out.primitive.exr",
                                                 "plain.png"}));
    const Channels all(folder / "out.exr");
    for (const std::string name : {"depth.Z", "primitive.ID", "cost.N"}) {
        const Channels one(folder / ("out." + name.substr(0, name.find('.')) + ".exr"));
        EXPECT_EQ(one.of.size(), 1u);
        EXPECT_EQ(one.of.at(name), all.of.at(name));
        EXPECT_EQ(one.isWhole.at(name), all.isWhole.at(name));
    }
    EXPECT_EQ(readPicture(folder / "out.png").pixels, readPicture(folder / "plain.png").pixels);
}

TEST_F(AovFiles, NumbersAreSeenInTheirOrderWithTheirEndsTold) {
    const ProgramResult result = render("depth.pfm", {"--view", "depth", "--aov", "depth", "--json"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    EXPECT_NE(result.errors.find("view: depth from "), std::string::npos) << result.errors;
    EXPECT_NE(result.output.find("\"view\""), std::string::npos) << result.output;
    const Image seen = readPicture(folder / "depth.pfm");
    const Channels depth(folder / "depth.depth.exr");
    std::vector<std::pair<float, float>> order;  // depth and lightness
    for (size_t i = 0; i < pixels * 2 / 3; ++i)  // above the legend
        if (std::isfinite(depth.number("depth.Z", i)))
            order.emplace_back(depth.number("depth.Z", i),
                               0.2126f * seen.pixels[i].x + 0.7152f * seen.pixels[i].y + 0.0722f * seen.pixels[i].z);
    std::ranges::sort(order);
    ASSERT_GT(order.size(), pixels / 4);
    for (size_t i = 1; i < order.size(); ++i) ASSERT_GE(order[i].second, order[i - 1].second - 1e-6f) << order[i].first;
}

TEST_F(AovFiles, NormalsAreSeenAsHalfOfThemAndAHalf) {
    ASSERT_EQ(render("normal.png", {"--view", "normal", "--aov", "normal"}).exitCode, 0);
    const Image seen = readPicture(folder / "normal.png");
    const Channels normal(folder / "normal.normal.exr");
    const char* const names[] = {"normal.X", "normal.Y", "normal.Z"};
    for (size_t i = 0; i < pixels; ++i)
        for (int k = 0; k < 3; ++k) {
            const double n = normal.number(names[k], i), linear = seen.pixels[i][k];
            const double code = linear <= 0.0031308 ? 12.92 * linear : 1.055 * std::pow(linear, 1 / 2.4) - 0.055;
            const bool isNone =
                normal.number("normal.X", i) == 0 && normal.number("normal.Y", i) == 0 && normal.number("normal.Z", i) == 0;
            ASSERT_NEAR(code, isNone ? 0.0 : 0.5 + 0.5 * n, 0.5001 / 255) << i;
        }
}

TEST_F(AovFiles, IdsAreSeenInOneColourEach) {
    ASSERT_EQ(render("id.pfm", {"--view", "material", "--aov", "material"}).exitCode, 0);
    const Image seen = readPicture(folder / "id.pfm");
    const Channels material(folder / "id.material.exr");
    std::map<uint32_t, std::vector<float>> colours;
    for (size_t i = 0; i < pixels; ++i) {
        const std::vector<float> colour = {seen.pixels[i].x, seen.pixels[i].y, seen.pixels[i].z};
        EXPECT_EQ(colours.try_emplace(material.of.at("material.ID")[i], colour).first->second, colour);
    }
    EXPECT_GT(colours.size(), 4u);
    for (const auto& a : colours) {
        for (const auto& b : colours) {
            if (a.first != b.first) {
                EXPECT_NE(a.second, b.second) << a.first << " and " << b.first;
            }
        }
    }
    EXPECT_EQ(colours.at(0xffffffffu), std::vector<float>(3, 0.0f));
}

// The mirror ball: with less than half of it there, what is behind it is told of.
TEST_F(AovFiles, AreOfWhatIsThereByHalf) {
    constexpr uint32_t ball = 4;  // its material
    std::ifstream file(spheres);
    nlohmann::json scene = nlohmann::json::parse(file);
    const auto aovsWith = [&](const std::string& name, float alpha) {
        scene["materials"][ball]["alphaMode"] = "BLEND";
        scene["materials"][ball]["pbrMetallicRoughness"]["baseColorFactor"][3] = alpha;
        const fs::path path = folder / (name + ".gltf");
        std::ofstream(path) << scene;
        EXPECT_EQ(render(name + ".exr", {"--aov", "depth,material"}, path).exitCode, 0);
        return Channels(folder / (name + ".exr"));
    };
    const Channels whole = aovsWith("whole", 1.0f), most = aovsWith("most", 0.7f), few = aovsWith("few", 0.3f);
    size_t seen = 0;
    for (size_t i = 0; i < pixels; ++i) {
        const bool isBall = whole.of.at("material.ID")[i] == ball;
        EXPECT_EQ(few.of.at("material.ID")[i] != whole.of.at("material.ID")[i], isBall) << i;
        EXPECT_EQ(few.number("depth.Z", i) > whole.number("depth.Z", i), isBall) << i;
        seen += isBall;
    }
    EXPECT_GT(seen, 100u);
    for (const char* name : {"depth.Z", "material.ID"}) EXPECT_EQ(most.of.at(name), whole.of.at(name)) << name;
}

/// One line of error, nothing written.
void expectRefused(const ProgramResult& result, int exitCode, const std::string& mentions) {
    EXPECT_EQ(result.exitCode, exitCode) << result.errors;
    EXPECT_TRUE(result.errors.starts_with("raig: error: ")) << result.errors;
    EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << result.errors;
    EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
}

TEST_F(AovFiles, NamesThatThereAreNotAreRefusedWithThoseThereAre) {
    for (const std::string wrong : {"deep", "depth,deep", "depth,", ",depth", "depth,,uv", "Depth", "depth uv"})
        expectRefused(render("out.exr", {"--aov", wrong}), 2, "depth, position, normal, uv, primitive");
    expectRefused(render("out.png", {"--view", "deep"}), 2, "samples, level, weight, cost");
    expectRefused(render("out.png", {"--view", "depth,uv"}), 2, "--view depth,uv");
    EXPECT_TRUE(files().empty());
}

TEST_F(AovFiles, ThatWouldReplaceAnotherOrCannotBeWrittenAreRefusedBeforeTheWork) {
    const std::string beside = folder / "out.depth.exr";
    expectRefused(render("out.png", {"--aov", "depth", "--save-structure", beside}), 2, "written twice");
    expectRefused(render("out.png", {"--aov", "depth", "--load-structure", beside}), 2, "read and replaced");
    EXPECT_TRUE(files().empty());
    fs::create_directory(beside);
    expectRefused(render("out.png", {"--aov", "depth"}), 3, "out.depth.exr");
    EXPECT_EQ(files(), std::vector<std::string>{"out.depth.exr"});
    EXPECT_EQ(render("out.png", {"--aov", "normal"}).exitCode, 0);
}

}  // namespace
}  // namespace raig
