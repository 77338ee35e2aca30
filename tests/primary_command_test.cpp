// `raig render --primary`: the same picture either way, what is told of it, and what is refused.
#include "image/image.hpp"
#include "support/devices.hpp"
#include "support/mesh_files.hpp"
#include "support/program.hpp"

#include <nlohmann/json.hpp>

#include <filesystem>

namespace raig {
namespace {

const std::string spheres = RAIG_SOURCE_DIR "/assets/cornell_spheres.gltf";

void expectRefused(std::vector<std::string> arguments, const std::string& mentions, int exitCode = 2,
                   const Variables& changes = {}) {
    const Folder folder;
    const std::vector<std::string> all{"render", spheres, "-o", (folder.write("a", "").parent_path() / "out.png").string()};
    arguments.insert(arguments.begin(), all.begin(), all.end());
    const ProgramResult result = runProgram(RAIG_PROGRAM, arguments, "", changes);
    EXPECT_EQ(result.exitCode, exitCode) << result.errors;
    EXPECT_NE(result.errors.find(mentions), std::string::npos) << result.errors;
    EXPECT_EQ(result.errors.find('\n'), result.errors.size() - 1) << "one line: " << result.errors;
}

TEST(PrimaryCommand, RefusesWhatCannotDraw) {
    expectRefused({"--primary", "guess"}, "--primary guess: ray or raster is wanted");
    expectRefused({"--primary", "raster", "--device", "cpu"}, "--device cpu has no graphics queue");
    expectRefused({"--primary", "raster"}, "no Vulkan device to draw on", 4,
                  {{"VK_DRIVER_FILES", "/nowhere"}, {"VK_ICD_FILENAMES", "/nowhere"}});
}

class PrimaryOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, PrimaryOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(PrimaryOnDevice, TheSamePictureIsMadeEitherWay) {
    if (!info.features.graphics) GTEST_SKIP() << info.name << " cannot draw";
    const Folder folder;
    const std::filesystem::path place = folder.write("a", "").parent_path();
    const auto render = [&](const std::string& primary) {
        const std::string file = (place / (primary + ".pfm")).string();
        const ProgramResult result =
            runProgram(RAIG_PROGRAM, {"render", spheres, "-o", file, "--size", "64x48", "--spp", "1", "--device", info.name,
                                      "--primary", primary, "--json", "--quiet"});
        EXPECT_EQ(result.exitCode, 0) << result.errors;
        return std::pair(readPicture(file).pixels, nlohmann::json::parse(result.output)["primary"]);
    };
    const auto [traced, byRay] = render("ray");
    const auto [drawn, byRaster] = render("raster");
    EXPECT_EQ(traced, drawn);
    EXPECT_EQ(byRay, nlohmann::json::parse(R"({"by": "ray"})"));
    EXPECT_EQ(byRaster["by"], "raster");
    EXPECT_EQ(byRaster["rays"], 64 * 48);
    EXPECT_LE(byRaster["fallbacks"].get<int>(), 64 * 48 / 50);
    EXPECT_GE(byRaster["triangles"].get<int>(), 14);
    EXPECT_GT(byRaster["draw_s"].get<double>(), 0.0);
}

// A furnished room, and four samples a pixel, which lie beside what was drawn.
TEST_P(PrimaryOnDevice, HintsAreSeldomWrongInARoom) {
    if (!info.features.graphics) GTEST_SKIP() << info.name << " cannot draw";
    const std::string room = RAIG_SOURCE_DIR "/../shared/scenes/rooms/white_room.glb";
    if (!std::filesystem::exists(room)) GTEST_SKIP() << room << " is not here";
    const Folder folder;
    const ProgramResult result = runProgram(
        RAIG_PROGRAM, {"render", room, "-o", folder.write("room.pfm", "").string(), "--size", "512x512", "--spp", "4",
                       "--max-depth", "0", "--device", info.name, "--primary", "raster", "--json", "--quiet"});
    ASSERT_EQ(result.exitCode, 0) << result.errors;
    const auto primary = nlohmann::json::parse(result.output)["primary"];
    EXPECT_EQ(primary["rays"], 4 * 512 * 512);
    EXPECT_LE(primary["fallbacks"].get<int>(), 4 * 512 * 512 / 50);
}

}  // namespace
}  // namespace raig
