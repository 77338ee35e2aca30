// `raig compare` as a person or a script calls it: what is printed and written, and what it exits with.
#include "image/metrics.hpp"
#include "rays/npy.hpp"
#include "rays/types.hpp"
#include "support/devices.hpp"
#include "support/images.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <gtest/gtest.h>
#include <nlohmann/json.hpp>

#include <cstring>
#include <limits>

namespace raig {
namespace {

using Json = nlohmann::json;

const std::string box = RAIG_SOURCE_DIR "/assets/cornell_box.gltf";

ProgramResult compare(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), "compare");
    return runProgram(RAIG_PROGRAM, arguments);
}

/// A small picture of the box.
ProgramResult compareBox(std::vector<std::string> arguments) {
    arguments.insert(arguments.begin(), {box, "--size", "24x24", "--quiet"});
    return compare(arguments);
}

std::string textOf(const std::filesystem::path& file) {
    std::ifstream stream(file);
    return {std::istreambuf_iterator<char>(stream), {}};
}

size_t linesWith(const std::string& text, const std::string& part) {
    size_t count = 0;
    for (size_t at = text.find(part); at != text.npos; at = text.find(part, at + 1)) ++count;
    return count;
}

uint64_t raysIn(const Json& histogram) {
    uint64_t rays = 0;
    for (const Json& bucket : histogram) {
        EXPECT_LE(bucket.at("from"), bucket.at("to"));
        rays += bucket.at("rays").get<uint64_t>();
    }
    return rays;
}

class ComparePictureFiles : public testing::Test {
protected:
    std::string write(const std::string& name, const Image& image) {
        const std::filesystem::path path = folder.write(name, "");
        writePicture(path, image);
        return path.string();
    }
    Json compareAsJson(const std::string& a, const std::string& b) {
        const ProgramResult result = compare({a, b, "--json"});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return Json::parse(result.output);
    }
    std::string path(const std::string& name) { return (std::filesystem::path(folder.write(name, "")).string()); }

    const Folder folder;
};

// ---- Of a scene --------------------------------------------------------------------------------------------------------

TEST(CompareScene, PrintsOneDocumentWithTheKeysOfTheDesign) {
    for (const std::string device : {"auto", "cpu"}) {
        const ProgramResult result = compareBox({"--json", "--device", device});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const Json json = Json::parse(result.output);
        for (const char* const key : {"same", "tie", "missed", "phantom", "wrong"})
            EXPECT_TRUE(json.at("hits").contains(key)) << key;
        for (const char* const key : {"median", "p99", "max"}) EXPECT_TRUE(json.at("t_ulp").contains(key)) << key;
        for (const char* const key : {"rmse", "relmse", "psnr", "ssim", "flip_mean", "flip_p99", "flip_max", "max", "nan"})
            EXPECT_TRUE(json.at("pixels").contains(key)) << key;
        for (const char* const key : {"mean", "max"}) EXPECT_TRUE(json.at("discarded_weight").contains(key)) << key;
        EXPECT_TRUE(json.at("fell_short").empty());
        EXPECT_EQ(json.at("device") == "cpu", json.at("device_vs_cpu").is_null());
        for (const Json& bound : json.at("bounds")) EXPECT_TRUE(bound.at("kept").get<bool>()) << bound;

        uint64_t rays = 0;
        for (const char* const family : {"camera", "aimed", "bounce"}) {
            const Json& one = json.at("families").at(family);
            EXPECT_EQ(one.at("level"), family == std::string("bounce") ? 1 : 0);
            EXPECT_LE(raysIn(one.at("t_ulp_histogram")), one.at("hits").at("same"));
            rays += raysIn(one.at("t_ulp_histogram"));
        }
        EXPECT_GT(rays, 1000u);
        EXPECT_EQ(raysIn(json.at("t_ulp_histogram")), rays);
    }
}

TEST(CompareScene, DevicesAndTheCpuAgreeInEveryBit) {
    for (const std::string& device : devicesToTest()) {
        if (!findDevice(device)) continue;
        const ProgramResult result = compareBox({"--json", "--device", device});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const Json bits = Json::parse(result.output).at("device_vs_cpu");
        EXPECT_GT(bits.at("rays").get<uint64_t>(), 1000u);
        if (!bits.at("ieee").get<bool>()) continue;  // its arithmetic is its own
        EXPECT_EQ(bits.at("different"), 0) << device << ": " << bits.at("first");
        EXPECT_TRUE(bits.at("first").is_null());
    }
}

// What is told of a ray is enough to trace it again.
TEST(CompareScene, TheRayThatIsNamedCanBeTracedAgain) {
    const Json first = Json::parse(compareBox({"--json"}).output).at("first_difference");
    ASSERT_TRUE(first.is_object()) << "rays at edges have ties";
    EXPECT_EQ(first.at("class"), "tie");
    EXPECT_EQ(first.at("family"), "aimed");
    EXPECT_EQ(first.at("level"), 0);
    const auto vectorOf = [&](const char* key) {
        const Json& v = first.at(key);
        return vec3(v.at(0).get<float>(), v.at(1).get<float>(), v.at(2).get<float>());
    };
    const Ray ray{vectorOf("origin"), first.at("t_min"), vectorOf("direction"), first.at("t_max")};

    // The table says the same ray in as many digits as a float needs.
    const ProgramResult table = compareBox({});
    const size_t at = table.output.find("the ray is [");
    ASSERT_NE(at, std::string::npos) << table.output;
    const Json numbers = Json::parse(table.output.substr(at + 11, table.output.find(']', at) - at - 10));
    ASSERT_EQ(numbers.size(), 8u);
    for (int i = 0; i < 3; ++i) {
        EXPECT_EQ(numbers[i].get<float>(), ray.origin[i]);
        EXPECT_EQ(numbers[4 + i].get<float>(), ray.direction[i]);
    }
    EXPECT_NE(table.output.find("first difference: aimed ray"), std::string::npos) << table.output;
    EXPECT_NE(table.output.find("(level 0), tie: bvh ("), std::string::npos) << table.output;

    const Folder folder;
    const auto* const floats = reinterpret_cast<const float*>(&ray);
    const std::vector<std::byte> bytes = encodeNpyFloats(std::span(floats, 8), 8);
    const std::string rays =
        folder.write("rays.npy", std::string_view(reinterpret_cast<const char*>(bytes.data()), bytes.size())).string();
    const std::string hits = folder.write("hits.npy", "").string();
    const ProgramResult traced = runProgram(RAIG_PROGRAM, {"trace", box, "--rays", rays, "--hits", hits, "--quiet"});
    ASSERT_EQ(traced.exitCode, 0) << traced.errors;
    const std::string file = textOf(hits);
    NpyHit hit;
    ASSERT_GT(file.size(), sizeof hit);
    std::memcpy(&hit, file.data() + file.size() - sizeof hit, sizeof hit);
    EXPECT_EQ(hit.t, first.at("device").at("t").get<float>());
    EXPECT_EQ(hit.u, first.at("device").at("u").get<float>());
    EXPECT_EQ(hit.v, first.at("device").at("v").get<float>());
}

TEST(CompareScene, BoundsThatAreBrokenAreToldOneALine) {
    const Folder folder;
    const std::string junit = folder.write("a.xml", "").string();
    const ProgramResult result = compareBox({"--fail-above", "tie=0", "--fail-above", "t_ulp_p99=0.5", "--fail-above",
                                             "rmse=0.9", "--fail-below", "ssim=0.5", "--junit", junit, "--json"});
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_EQ(linesWith(result.errors, "fell short"), 2u) << result.errors;
    EXPECT_NE(result.errors.find("fell short: tie is "), std::string::npos) << result.errors;
    EXPECT_NE(result.errors.find("the ray is ["), std::string::npos) << "a tie, and no ray: " << result.errors;
    EXPECT_NE(result.errors.find("fell short: t_ulp_p99 is "), std::string::npos) << result.errors;
    const Json json = Json::parse(result.output);
    EXPECT_EQ(json.at("fell_short").size(), 2u);
    size_t kept = 0;
    for (const Json& bound : json.at("bounds")) kept += bound.at("kept").get<bool>();
    EXPECT_EQ(kept, json.at("bounds").size() - 2);
    const std::string xml = textOf(junit);
    EXPECT_EQ(linesWith(xml, "<testcase"), json.at("bounds").size()) << xml;
    EXPECT_EQ(linesWith(xml, "<failure"), 2u) << xml;
    for (const char* const name : {"missed at most 0", "phantom at most 0", "wrong at most 0", "nan at most 0",
                                   "rmse at most 0.9", "ssim at least 0.5"})
        EXPECT_NE(xml.find("classname=\"compare.cornell_box\" name=\"" + std::string(name) + "\" time=\"0.000\"/>"),
                  std::string::npos)
            << name << '\n' << xml;
    EXPECT_EQ(xml.find("rmse at most 0.001"), std::string::npos) << "a bound that is given replaces the scene's own";
}

TEST(CompareScene, WritesADifferencePicture) {
    const Folder folder;
    const std::string file = folder.write("difference.pfm", "").string();
    EXPECT_EQ(compareBox({"-o", file}).exitCode, 0);
    const Image map = readPicture(file);
    EXPECT_EQ(map.width, 24u);
    EXPECT_LT(map.at(12, 12).x, 0.01f) << "no difference is dark";
}

// ---- Of two pictures ---------------------------------------------------------------------------------------------------

// One picture in all formats: as exact as they are, whichever is the reference.
TEST_F(ComparePictureFiles, AnyFormatCanBeComparedWithAnyOther) {
    const Image image = test::noise(20, 14, 3);
    std::vector<std::string> files;
    for (const char* const name : {"a.exr", "a.pfm", "a.hdr", "a.png"}) files.push_back(write(name, image));
    for (size_t i = 0; i < files.size(); ++i)
        for (size_t k = 0; k < files.size(); ++k) {
            SCOPED_TRACE(files[i] + " and " + files[k]);
            const Json pixels = compareAsJson(files[i], files[k]).at("pixels");
            EXPECT_EQ(pixels.at("compared"), 280);
            EXPECT_EQ(pixels.at("nan"), 0);
            const double max = pixels.at("max");
            if (i == k || (i < 2 && k < 2))
                EXPECT_EQ(max, 0.0);
            else
                EXPECT_GT(max, 1e-4) << "bytes cannot hold noise";
            EXPECT_LT(max, 0.02);
            EXPECT_GT(pixels.at("ssim").get<double>(), 0.999);
        }
}

TEST_F(ComparePictureFiles, EqualPicturesDifferByNothingAndTheDocumentIsValid) {
    const std::string one = write("one.png", test::noise(1, 1, 4)), same = write("same.exr", Image(1, 1, vec3(0.5f)));
    const std::string other = write("other.exr", Image(1, 1, vec3(0.5f)));
    for (const auto& [a, b] : {std::pair(one, one), std::pair(same, other)}) {
        const ProgramResult result = compare({a, b, "--json", "--fail-below", "psnr=99", "--fail-above", "max=0"});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        const Json pixels = Json::parse(result.output).at("pixels");
        EXPECT_TRUE(pixels.at("psnr").is_null()) << "infinite, which JSON has not";
        for (const char* const key : {"rmse", "relmse", "flip_mean", "flip_p99", "flip_max", "max", "nan"})
            EXPECT_EQ(pixels.at(key), 0) << key;
        EXPECT_EQ(pixels.at("ssim"), 1.0);
        EXPECT_EQ(pixels.at("compared"), 1);
    }
    EXPECT_NE(compare({same, other}).output.find(" inf "), std::string::npos);
}

// Light is compared as it is, what is seen as a screen shows it: PNG holds no light above 1.
TEST_F(ComparePictureFiles, LightBeyondWhiteShowsInLightOnly) {
    const Json pixels =
        compareAsJson(write("a.png", Image(8, 8, vec3(5.0f))), write("b.exr", Image(8, 8, vec3(5.0f)))).at("pixels");
    EXPECT_EQ(pixels.at("max"), 4.0);
    EXPECT_EQ(pixels.at("rmse"), 4.0);
    EXPECT_TRUE(pixels.at("psnr").is_null());
    EXPECT_EQ(pixels.at("flip_max"), 0.0);
    EXPECT_EQ(pixels.at("ssim"), 1.0);
}

TEST_F(ComparePictureFiles, PixelsThatAreNotFiniteAreCountedAndLeftOut) {
    Image image = test::noise(16, 16, 5);
    const std::string clean = write("clean.exr", image);
    image.at(3, 4).y = std::numeric_limits<float>::quiet_NaN();
    image.at(5, 6).x = std::numeric_limits<float>::infinity();
    const std::string dirty = write("dirty.exr", image);
    const Json pixels = compareAsJson(dirty, clean).at("pixels");
    EXPECT_EQ(pixels.at("nan"), 2);
    EXPECT_EQ(pixels.at("compared"), 254);
    EXPECT_EQ(pixels.at("max"), 0.0);
    const ProgramResult bounded = compare({dirty, clean, "--fail-above", "nan=1", "--fail-above", "rmse=0"});
    EXPECT_EQ(bounded.exitCode, 1);
    EXPECT_EQ(bounded.errors, "raig: warning: fell short: nan is 2; allowed: at most 1\n");

    const std::string nothing = write("nothing.exr", Image(16, 16, vec3(std::numeric_limits<float>::quiet_NaN())));
    const ProgramResult none = compare({nothing, clean, "--json", "--fail-above", "rmse=10"});
    EXPECT_EQ(none.exitCode, 1) << "agreement about nothing is none";
    EXPECT_TRUE(Json::parse(none.output).at("pixels").at("rmse").is_null());
}

TEST_F(ComparePictureFiles, DifferencesAreShownBrightWhereTheyAre) {
    Image image(32, 32, vec3(0.25f));
    const std::string a = write("a.exr", image);
    image.at(8, 20) = vec3(1.0f, 0.0f, 1.0f);
    const std::string b = write("b.pfm", image);
    const std::string file = path("difference.png");
    EXPECT_EQ(compare({a, b, "-o", file}).exitCode, 0);
    const Image map = readPicture(file);
    const auto light = [&](uint32_t x, uint32_t y) { return map.at(x, y).x + map.at(x, y).y + map.at(x, y).z; };
    EXPECT_GT(light(8, 20), 0.3f);
    EXPECT_LT(light(30, 2), 0.01f);
    for (uint32_t y = 0; y < 32; ++y)
        for (uint32_t x = 0; x < 32; ++x) EXPECT_LE(light(x, y), light(8, 20));
}

TEST_F(ComparePictureFiles, TheDistanceOfTheEyeChangesFlipAlone) {
    const std::string a = write("a.exr", test::noise(30, 20, 6)), b = write("b.exr", test::noise(30, 20, 7));
    const Json near = Json::parse(compare({a, b, "--json", "--ppd", "20"}).output);
    const Json usual = compareAsJson(a, b);
    EXPECT_EQ(near.at("pixels_per_degree"), 20.0);
    EXPECT_NEAR(usual.at("pixels_per_degree").get<double>(), 67.02, 0.01);
    EXPECT_GT(near.at("pixels").at("flip_mean").get<double>(), 1.05 * usual.at("pixels").at("flip_mean").get<double>());
    EXPECT_EQ(near.at("pixels").at("ssim"), usual.at("pixels").at("ssim"));
    EXPECT_NEAR(near.at("pixels").at("flip_mean").get<double>(),
                comparePictures(readPicture(a), readPicture(b), {}, 20.0).flipMean, 1e-12);
}

TEST_F(ComparePictureFiles, BoundsTellFailuresInJUnit) {
    const std::string a = write("a.exr", Image(9, 9, vec3(0.25f))), b = write("b.exr", Image(9, 9, vec3(0.75f)));
    const std::string junit = path("pictures.xml");
    const ProgramResult result = compare({a, b, "--fail-above=rmse=0.25", "--fail-above=max=0.5", "--fail-below=psnr=30",
                                          "--fail-below", "ssim=0.1", "--junit", junit});
    EXPECT_EQ(result.exitCode, 1);
    EXPECT_NE(result.errors.find("fell short: rmse is 0.5; allowed: at most 0.25\n"), std::string::npos) << result.errors;
    EXPECT_EQ(linesWith(result.errors, "fell short: "), 2u) << result.errors;
    const std::string xml = textOf(junit);
    EXPECT_NE(xml.find("<testsuites tests=\"4\" failures=\"2\""), std::string::npos) << xml;
    EXPECT_NE(xml.find("classname=\"compare.a\" name=\"max at most 0.5\" time=\"0.000\"/>"), std::string::npos) << xml;
    EXPECT_NE(xml.find("<failure message=\"rmse is 0.5; allowed: at most 0.25\">"), std::string::npos) << xml;
}

// ---- Wrong usage -------------------------------------------------------------------------------------------------------

void expectError(const std::vector<std::string>& arguments, int exitCode, const std::string& mentions) {
    const ProgramResult result = compare(arguments);
    EXPECT_EQ(result.exitCode, exitCode) << result.errors;
    EXPECT_EQ(result.output, "");
    EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors << " does not mention " << mentions;
    EXPECT_EQ(linesWith(result.errors, "\n"), 1u) << result.errors;
}

TEST(CompareUsage, BoundsMustBeOfAMetricThatThereIs) {
    for (const char* const text : {"flip=0.1", "RMSE=1", "=1", "rmse:1", "rmse =1"})
        expectError({box, "--fail-above", text}, 2, "METRIC one of rmse, relmse, psnr, ssim");
    expectError({box, "--fail-above", "rmse"}, 2, "a number is wanted after rmse=");
    expectError({box, "--fail-above", ""}, 2, "--fail-above");
    for (const std::string value : {"", "x", "nan", "inf", "1e999", "0.1 ", "+1", "1/4"})
        expectError({box, "--fail-above", "rmse=" + value}, 2, "a number is wanted after rmse=");
    expectError({"a.png", "b.png", "--fail-above", "psnr=40"}, 2, "write --fail-below psnr=40");
    expectError({"a.png", "b.png", "--fail-below", "rmse=0.1"}, 2, "write --fail-above rmse=0.1");
    expectError({"a.png", "b.png", "--fail-above", "missed=0"}, 2, "pictures have rmse, relmse");
    expectError({"a.png", "b.png", "--fail-below", "same=9"}, 2, "--fail-below same");
    expectError({"a.png", "b.png", "--junit", "a.xml"}, 2, "give a bound");
    for (const char* const value : {"0", "-1", "1001", "nan", "x"}) expectError({box, "--ppd", value}, 2, "--ppd");
    expectError({box, "--junit", "no/such/folder/a.xml"}, 3, "no/such/folder");
    expectError({"a.png", "b.png", "--fail-above", "max=0", "--junit", "./b.png"}, 2, "would be read and replaced");
}

// Who says how a scene is rendered expects that it matters.
TEST_F(ComparePictureFiles, TakeNoOptionsOfScenes) {
    const std::string a = write("a.png", Image(3, 4));
    for (const std::vector<std::string>& of : {std::vector<std::string>{"--spp", "4"}, {"--camera", "0"}, {"--accel", "bvh"},
                                               {"--time-at", "1"}, {"--integrator", "path"}, {"--size", "3x4"}})
        expectError({a, a, of[0], of[1]}, 2, of[0] + ": is of scenes");
    EXPECT_EQ(compare({a, a, "--device", "cpu", "--threads", "1", "--quiet"}).exitCode, 0);
}

TEST_F(ComparePictureFiles, OfDifferentSizesAreRefused) {
    const std::string a = write("a.png", Image(3, 4)), b = write("b.exr", Image(4, 3));
    expectError({a, b}, 3, "only pictures of one size");
    expectError({a, folder.write("c.png", "no picture").string()}, 3, "c.png");
}

}  // namespace
}  // namespace raig
