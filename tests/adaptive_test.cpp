// Samples where they are needed: the same bits however the work is cut, on every device; what each pixel has is what as many
// samples for all give it; thin things are found; and the error of a picture takes fewer rays.
#include "rays/adaptive.hpp"
#include "support/devices.hpp"
#include "support/rendering.hpp"

#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace raig {
namespace {

using namespace test;

/// Glass, a mirror, a texture, and soft shadows.
Scene softScene() {
    Scene scene = variedRoom();
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 8, true, tintedGlass());
    addSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, 6, false, metal(vec3(0.9f, 0.8f, 0.5f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    return scene;
}

FrameOptions adaptive(uint32_t width, uint32_t height, double tolerance, uint32_t most = 64) {
    FrameOptions options;
    options.width = width;
    options.height = height;
    options.samples = most;
    options.tolerance = tolerance;
    options.keepsLevels = true;
    return options;
}

/// All that a picture is, in words.
std::vector<uint32_t> allBitsOf(const Picture& picture) {
    std::vector<uint32_t> bits = bitsOf(picture);
    bits.insert(bits.end(), picture.samples.begin(), picture.samples.end());
    bits.insert(bits.end(), picture.levels.begin(), picture.levels.end());
    bits.insert(bits.end(), picture.costs.begin(), picture.costs.end());
    bits.push_back(static_cast<uint32_t>(picture.statistics.unsettled));
    return bits;
}

/// In linear light, over the pixels and their channels.
template <class Expected>
double rmse(const Picture& picture, const Expected& expected) {
    double sum = 0.0;
    for (size_t i = 0; i < picture.radiance.size(); ++i) {
        const dvec3 d = dvec3(picture.radiance[i]) - dvec3(expected[i]);
        sum += glm::dot(d, d) / 3.0;
    }
    return std::sqrt(sum / double(picture.radiance.size()));
}

uint64_t raysOf(const Picture& picture) {
    return picture.statistics.closestRays + picture.statistics.shadowRays;
}

TEST(PixelErrors, AreHalfTheDifferenceOfHalvesAveragedOverNeighbours) {
    PixelErrors errors(5, 5);
    for (size_t i = 0; i < 25; ++i) errors.learn(i, vec3(1.0f), 8, vec3(1.0f), 16);
    EXPECT_EQ(errors.meanSquare(12), 0.0);
    // A pixel whose halves have means 0 and 2: its mean is 1, and half their difference.
    errors.learn(12, vec3(0.0f), 8, vec3(1.0f), 16);
    EXPECT_NEAR(errors.meanSquare(12), 4.0 / 16.0, 1e-12);
    EXPECT_NEAR(errors.meanSquare(11), 2.0 / 16.0, 1e-12);
    EXPECT_NEAR(errors.meanSquare(6), 1.0 / 16.0, 1e-12);
    EXPECT_EQ(errors.meanSquare(10), 0.0);
    // In a corner there are four pixels.
    errors.learn(12, vec3(1.0f), 8, vec3(1.0f), 16);
    errors.learn(0, vec3(1.0f - 0.5f), 8, vec3(1.0f), 16);
    EXPECT_NEAR(errors.meanSquare(0), 0.25 * 4.0 / 9.0, 1e-12);
}

// Samples that do not double a pixel's change its mean by less.
TEST(PixelErrors, DoNotDependOnHowManySamplesTheLastOnesWere) {
    PixelErrors errors(1, 1);
    // Variance s^2 a sample: the mean of n and that of m more differ by s^2 (1/n + 1/m); the error of all is s^2 / (n + m).
    errors.learn(0, vec3(0.0f), 64, vec3(1.0f), 80);
    const double difference = std::pow(80.0 / 16.0, 2);  // squared, of the two means
    const double variance = difference / (1.0 / 64 + 1.0 / 16);
    EXPECT_NEAR(errors.meanSquare(0), variance / 80, 1e-6);
}

TEST(PixelErrors, KnowWhatSamplesMissBesideAContrast) {
    PixelErrors errors(3, 1);
    for (size_t i = 0; i < 3; ++i) errors.learn(i, vec3(i == 2 ? 3.0f : 1.0f), 8, vec3(i == 2 ? 3.0f : 1.0f), 16);
    EXPECT_EQ(errors.meanSquare(0), 0.0);
    EXPECT_NEAR(errors.meanSquare(1), 4.0 / (3.0 * 16 * 16 * 16), 1e-12);
    EXPECT_NEAR(errors.meanSquare(2), 4.0 / (3.0 * 16 * 16 * 16), 1e-12);
}

TEST(PixelErrors, OfWhatIsNotFiniteCountForNothing) {
    PixelErrors errors(3, 1);
    errors.learn(0, vec3(1.0f), 8, vec3(1.0f), 16);
    errors.learn(1, vec3(0.5f), 8, vec3(1.0f), 16);
    errors.learn(2, vec3(1.0f), 8, vec3(INFINITY, NAN, 3e38f), 16);
    EXPECT_NEAR(errors.meanSquare(1), 0.25 * 4.0 / 8.0, 1e-12);
    EXPECT_TRUE(std::isfinite(errors.meanSquare(2)));
}

TEST(AdaptiveFrame, GivesEachPixelWhatAsManySamplesForAllGiveIt) {
    const Stage stage(softScene());
    FrameOptions options = adaptive(37, 29, 0.02, 100);
    options.countsCosts = true;
    const Picture picture = stage.onCpu(options);
    ASSERT_EQ(picture.samples.size(), 37u * 29u);
    std::map<uint32_t, size_t> counts;
    for (const uint32_t samples : picture.samples) ++counts[samples];
    EXPECT_GE(counts.size(), 4u) << "or this shows nothing";
    for (const auto& [samples, count] : counts) {
        EXPECT_TRUE(samples == 8 || samples == 16 || samples == 32 || samples == 64 || samples == 100) << samples;
        FrameOptions uniform = options;
        uniform.tolerance = 0.0;
        uniform.samples = samples;
        const Picture all = stage.onCpu(uniform);
        EXPECT_TRUE(all.samples.empty());
        size_t different = 0;
        for (size_t i = 0; i < picture.samples.size(); ++i)
            different += picture.samples[i] == samples &&
                         (picture.radiance[i] != all.radiance[i] || picture.discarded[i] != all.discarded[i] ||
                          picture.levels[i] != all.levels[i] || picture.costs[i] != all.costs[i]);
        EXPECT_EQ(different, 0u) << "of " << count << " pixels with " << samples << " samples";
    }
}

TEST(AdaptiveFrame, HasTheSameBitsWhateverTilesAndThreads) {
    const Stage stage(softScene());
    FrameOptions options = adaptive(37, 29, 0.02);
    const std::vector<uint32_t> bits = allBitsOf(stage.onCpu(options));
    for (const uint32_t tile : {1u, 7u, 256u}) {
        options.tilePixels = tile;
        EXPECT_EQ(allBitsOf(stage.onCpu(options)), bits) << "tiles of " << tile;
    }
    tbb::task_arena(1).execute([&] { EXPECT_EQ(allBitsOf(stage.onCpu(options)), bits) << "one thread"; });
}

TEST(AdaptiveFrame, StopsAtTheFirstSamplesAndAtTheLast) {
    const Stage stage(softScene());
    const Picture lax = stage.onCpu(adaptive(19, 13, 1e9)), strict = stage.onCpu(adaptive(19, 13, 1e-30, 20));
    FrameOptions uniform = adaptive(19, 13, 0.0, 8);
    EXPECT_EQ(bitsOf(lax), bitsOf(stage.onCpu(uniform)));
    EXPECT_EQ(lax.statistics.unsettled, 0u);
    EXPECT_GT(strict.statistics.unsettled, 0u);
    EXPECT_EQ(*std::ranges::max_element(strict.samples), 20u);
    EXPECT_LE(strict.statistics.unsettled, uint64_t(std::ranges::count(strict.samples, 20u)));
    // The fewest there can be is no reason to fail.
    EXPECT_EQ(bitsOf(stage.onCpu(adaptive(19, 13, 1e-30, 8))), bitsOf(lax));
}

TEST(AdaptiveFrame, HasInPartsTheBitsOfTheWhole) {
    const Stage stage(softScene());
    FrameOptions options = adaptive(37, 29, 0.02, 1000);
    const Picture whole = stage.onCpu(options);
    uint64_t unsettled = 0;
    for (const Crop& crop : {Crop{0, 0, 20, 29}, Crop{20, 0, 17, 12}, Crop{20, 12, 17, 17}}) {
        options.crop = crop;
        const Picture part = stage.onCpu(options);
        ASSERT_EQ(part.width, crop.width);
        ASSERT_EQ(part.radiance.size(), crop.pixels());
        size_t different = 0;
        for (size_t i = 0; i < crop.pixels(); ++i) {
            const size_t at = (crop.y + i / crop.width) * 37 + crop.x + i % crop.width;
            different += part.radiance[i] != whole.radiance[at] || part.samples[i] != whole.samples[at] ||
                         part.levels[i] != whole.levels[at];
        }
        EXPECT_EQ(different, 0u) << crop.x << ' ' << crop.y;
        unsettled += part.statistics.unsettled;
    }
    EXPECT_EQ(unsettled, whole.statistics.unsettled);
}

// A picture of constant light needs no more than the first samples.
TEST(AdaptiveFrame, SpendsNothingWhereNothingIs) {
    Scene scene = whiteSky();
    const Picture picture = Stage(scene).onCpu(adaptive(16, 16, 1e-6, 1024));
    EXPECT_EQ(std::ranges::count(picture.samples, 8u), 256);
}

TEST(AdaptiveFrame, ReportsProgressThatGrowsToTheEnd) {
    const Stage stage(softScene());
    FrameOptions options = adaptive(24, 24, 0.02);
    options.tilePixels = 100;
    double last = 0.0, lastRays = 0.0;
    bool grows = true;
    const auto listen = [&](double fraction, double rays) {
        grows = grows && fraction >= last && fraction <= 1.0 && rays >= lastRays;
        last = fraction;
        lastRays = rays;
    };
    renderPicture(stage.scene, stage.geometry, *makeCpuTracer(stage.structure), options, listen);
    EXPECT_TRUE(grows);
    EXPECT_EQ(last, 1.0);
}

// A wire of a twentieth of a pixel: eight samples miss it in many pixels, whose neighbours tell of it. Where they miss it in
// three pixels on end nobody tells, and the middle one is left.
TEST(AdaptiveFrame, FindsThinThings) {
    Scene scene;
    scene.cameras.push_back(lookAt({0, 0, 4}, {0, 0, 0}));
    scene.ambient = vec3(1.0f);
    addQuad(scene, {-2, -1.1f, 0}, {4, 2.2f, 0}, {-0.0012f, 0.0024f, 0}, matte(vec3(1.0f)));
    const Stage stage(scene);
    constexpr uint32_t side = 64;
    FrameOptions few = square(side, 8), many = square(side, 1024);
    const Picture sparse = stage.onCpu(few), truth = stage.onCpu(many);
    const Picture found = stage.onCpu(adaptive(side, side, 0.002, 1024));
    size_t sparseMisses = 0, misses = 0;
    for (size_t i = 0; i < truth.radiance.size(); ++i) {
        const bool isThere = truth.radiance[i].x > 0.02f;
        sparseMisses += isThere && sparse.radiance[i].x == 0.0f;
        misses += isThere && found.radiance[i].x == 0.0f;
    }
    EXPECT_GT(sparseMisses, 20u) << "or this shows nothing";
    EXPECT_LE(misses, sparseMisses / 3) << "of " << sparseMisses;
    // A line is in half of the weights of the pixels that errors are averaged over.
    EXPECT_LT(rmse(found, truth.radiance), 0.002 * std::sqrt(2.0));
    EXPECT_GT(rmse(sparse, truth.radiance), 0.01);
    EXPECT_LT(raysOf(found), uint64_t{side} * side * 64);
}

// Half the rays, or less: Whitted's point. The lamp of this box is 42 times as bright as white.
TEST(AdaptiveFrame, HasTheErrorOf64SamplesForHalfTheRaysInTheCornellBox) {
    const Stage stage(importScene(RAIG_SOURCE_DIR "/assets/cornell_box.gltf"));
    constexpr uint32_t side = 40;
    FrameOptions options = square(side, 64);
    const Picture uniform = stage.onCpu(options);
    options.seed = 1;
    options.samples = 1024;
    const std::vector<vec3> truth = stage.onCpu(options).radiance;
    const double tolerance = 0.06;
    const Picture picture = stage.onCpu(adaptive(side, side, tolerance, 1024));
    EXPECT_LE(rmse(picture, truth), rmse(uniform, truth));
    EXPECT_LE(raysOf(picture), raysOf(uniform) / 2);
    EXPECT_LE(rmse(picture, truth), tolerance) << "the tolerance is the error of each pixel";
    RecordProperty("rmse_uniform", std::to_string(rmse(uniform, truth)));
    RecordProperty("rmse_adaptive", std::to_string(rmse(picture, truth)));
    RecordProperty("rays_uniform", std::to_string(raysOf(uniform)));
    RecordProperty("rays_adaptive", std::to_string(raysOf(picture)));
}

FrameOptions within(double seconds, FrameOptions options) {
    using Clock = std::chrono::steady_clock;
    options.deadline = Clock::now() + std::chrono::duration_cast<Clock::duration>(std::chrono::duration<double>(seconds));
    return options;
}

// How many samples that gives is the machine's; what they give is not.
TEST(TimedFrame, IsThatOfTheSamplesThatWentIntoTheTime) {
    const Stage stage(softScene());
    for (const double tolerance : {0.0, 0.01}) {
        FrameOptions options = adaptive(12, 10, tolerance, 65536);
        options.countsCosts = true;
        Picture timed;
        for (double seconds = 0.25; timed.statistics.samples < firstSamples && seconds < 100.0; seconds *= 4.0)
            timed = stage.onCpu(within(seconds, options));  // again where the machine is busy
        ASSERT_GE(timed.statistics.samples, firstSamples);
        EXPECT_LT(timed.statistics.samples, 65536u) << "or this shows nothing";
        options.samples = timed.statistics.samples;
        const Picture again = stage.onCpu(options);
        EXPECT_EQ(again.statistics.samples, timed.statistics.samples);
        EXPECT_EQ(timed.radiance, again.radiance);
        EXPECT_EQ(timed.discarded, again.discarded);
        EXPECT_EQ(timed.samples, again.samples);
        EXPECT_EQ(timed.levels, again.levels);
        EXPECT_EQ(timed.costs, again.costs);
        EXPECT_EQ(timed.statistics.unsettled, again.statistics.unsettled);
    }
}

TEST(TimedFrame, IsWholeHoweverLittleTimeThereIs) {
    const Stage stage(softScene());
    FrameOptions options = adaptive(24, 20, 0.0, 1);
    const Picture centres = stage.onCpu(options);
    options.samples = 64;
    for (const double tolerance : {0.0, 0.01}) {
        options.tolerance = tolerance;
        const Picture picture = stage.onCpu(within(0.0, options));
        EXPECT_EQ(picture.statistics.samples, 1u);
        EXPECT_EQ(picture.radiance, centres.radiance) << "through the pixels' centres";
    }
}

TEST(TimedFrame, EndsBySamplesWhereThereIsTime) {
    const Stage stage(softScene());
    for (const double tolerance : {0.0, 0.01})
        for (const uint32_t samples : {8u, 21u, 64u}) {
            const FrameOptions options = adaptive(12, 10, tolerance, samples);
            const Picture want = stage.onCpu(options), picture = stage.onCpu(within(1000.0, options));
            EXPECT_EQ(picture.statistics.samples, want.statistics.samples);
            EXPECT_EQ(picture.radiance, want.radiance) << samples;
            EXPECT_EQ(picture.samples, want.samples);
        }
}

class AdaptiveOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, AdaptiveOnDevice, testing::ValuesIn(devicesToTest()), testName);

TEST_P(AdaptiveOnDevice, EqualsTheCpusToTheBitWhateverTheTiles) {
    const Stage stage(softScene());
    Device device(info);
    const std::unique_ptr<DeviceTracer> tracer = makeDeviceTracer(device, stage.structure);
    DeviceFrame frame(device, stage.scene, stage.geometry, *tracer);
    // Pictures by one frame, with and without passes that take pixels up again.
    FrameOptions options = adaptive(45, 31, 0.03, 40), uniform = adaptive(45, 31, 0.0, 3);
    EXPECT_EQ(allBitsOf(frame.render(uniform)), allBitsOf(stage.onCpu(uniform)));
    const std::vector<uint32_t> bits = allBitsOf(stage.onCpu(options));
    for (const uint32_t tile : {0u, 300u}) {
        options.tilePixels = tile;
        EXPECT_EQ(allBitsOf(frame.render(options)), bits) << "tiles of " << tile;
    }
    EXPECT_EQ(allBitsOf(frame.render(uniform)), allBitsOf(stage.onCpu(uniform)));
    uniform.samples = 20;
    EXPECT_EQ(frame.render(within(1000.0, uniform)).radiance, stage.onCpu(uniform).radiance);
}

}  // namespace
}  // namespace raig
