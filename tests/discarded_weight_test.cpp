// The discarded weight, times the brightest radiance, bounds what NIVELL_MAX and MIN_CONTRIB left out: pixel by pixel, on
// scenes that reflect and refract.
#include "reference/picture.hpp"
#include "reference/world.hpp"
#include "support/effort.hpp"
#include "support/leaves.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace raig {
namespace {

using namespace test;

const std::filesystem::path shared = std::filesystem::path(RAIG_SOURCE_DIR) / "../shared/scenes";

struct Subject {
    const char* name;
    std::filesystem::path file;  ///< none: leafyScene(), whose blends and highlights count, too
};

const std::vector<Subject> subjects = {
    {"CornellSpheres", std::filesystem::path(RAIG_SOURCE_DIR) / "assets/cornell_spheres.gltf"},
    {"Glassware", shared / "glass/glassware.glb"},
    {"BeerGlass", shared / "glass/beerGlass/beerGlass.obj"},
    {"Sedan", shared / "obj/concept-sedan-02/concept-sedan-02.obj"},
    {"WhiteRoom", shared / "rooms/white_room.glb"},
    {"Leaves", {}}};

constexpr uint32_t depths[] = {0, 1, 2, 4, 8, 16};
constexpr float contributions[] = {0.25f, 0.0625f, 1.0f / 64, 1.0f / 255, 1.0f / 512, 1.0f / 4096};

/// Deeper and finer than any of those, so that what it follows holds all that they follow.
constexpr uint32_t deepest = 32;
constexpr float finest = 1.0f / 16384;

double largestDifference(const vec3& a, const vec3& b) {
    const dvec3 difference = glm::abs(dvec3(a) - dvec3(b));
    return std::max({difference.x, difference.y, difference.z});
}

/// The brightest radiance that arrives along any ray of the picture's, mirrored or refracted, by the reference.
double brightestOf(const Stage& stage, const FrameOptions& options) {
    const reference::World world(stage.scene, stage.geometry);
    reference::PictureOptions same;
    same.width = options.width;
    same.height = options.height;
    same.samples = options.samples;
    same.bounds = {options.maxDepth, options.minContribution, options.seed};
    same.roundings = 0;
    const reference::Picture picture = reference::render(world, same);
    return *std::ranges::max_element(picture.brightest);
}

class DiscardedWeight : public testing::TestWithParam<Subject> {
protected:
    void SetUp() override {
        const std::filesystem::path& file = GetParam().file;
        if (!file.empty() && !std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
    }
};

TEST_P(DiscardedWeight, BoundsTheErrorOfEveryPixel) {
    const uint32_t side = isLong() ? 64 : 20;
    const Stage stage(GetParam().file.empty() ? leafyScene() : importScene(GetParam().file));
    const FrameOptions all = square(side, 1, deepest, finest);
    const Picture whole = stage.onCpu(all);
    const double brightest = brightestOf(stage, all);
    size_t wrong = 0, cut = 0;
    double closest = 0.0;
    for (const uint32_t depth : depths)
        for (const float contribution : contributions) {
            const Picture picture = stage.onCpu(square(side, 1, depth, contribution));
            for (size_t i = 0; i < picture.radiance.size(); ++i) {
                const double error = largestDifference(picture.radiance[i], whole.radiance[i]);
                const double bound = picture.discarded[i] * brightest;
                const double rounding = 1e-5 * (1.0 + glm::length(dvec3(whole.radiance[i])));
                wrong += !(error <= bound + rounding);
                cut += picture.discarded[i] > whole.discarded[i];
                if (error > 10.0 * rounding) closest = std::max(closest, error / bound);
            }
        }
    EXPECT_EQ(wrong, 0u) << "pixels whose error exceeds the bound";
    EXPECT_GT(cut, 100u) << "else there was nothing to see";
    EXPECT_GT(closest, 0.0) << "else no error was made";
    RecordProperty("closest", std::to_string(closest));
    std::printf("%s: %zu cut pixels, an error comes up to %.3f of its bound; brightest %.3g\n", GetParam().name, cut,
                closest, brightest);
}

INSTANTIATE_TEST_SUITE_P(, DiscardedWeight, testing::ValuesIn(subjects), [](const auto& info) { return info.param.name; });

// Hall and Greenberg found that few rays go deep where they are followed only while they matter: that a depth of 15 is
// allowed costs little more than one of 4 does.
TEST(AdaptiveDepth, GlasswareNeedsFewLevelsHoweverManyAreAllowed) {
    const std::filesystem::path file = shared / "glass/glassware.glb";
    if (!std::filesystem::exists(file)) GTEST_SKIP() << "no " << file;
    const Stage stage(importScene(file));
    std::vector<double> means, rays;
    for (const uint32_t depth : {2u, 4u, 8u, 16u, 32u}) {
        FrameOptions options = square(isLong() ? 256 : affordable(48), 1, depth, 1.0f / 512);
        options.keepsLevels = true;
        const Picture picture = stage.onCpu(options);
        double sum = 0.0, discarded = 0.0;
        for (const uint32_t level : picture.levels) sum += level;
        for (const float weight : picture.discarded) discarded += weight;
        const auto pixels = double(picture.levels.size());
        means.push_back(sum / pixels);
        rays.push_back(double(picture.statistics.closestRays) / pixels);
        std::printf("NIVELL_MAX %2u: mean depth %.3f, deepest %u, %.2f rays a pixel, mean discarded weight %.2e\n", depth,
                    means.back(), picture.statistics.deepest, rays.back(), discarded / pixels);
    }
    EXPECT_TRUE(std::ranges::is_sorted(means));
    EXPECT_TRUE(std::ranges::is_sorted(rays));
    EXPECT_LT(means[4], 2.0 * means[2]) << "from 8 to 32 levels";
    EXPECT_LT(rays[4], 2.0 * rays[2]);
}

}  // namespace
}  // namespace raig
