// Rays in families and the bounds of metrics: the first fault is named, whatever it is, and no bound is kept by accident.
#include "measure/compare_bounds.hpp"
#include "support/rendering.hpp"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <set>

namespace raig {
namespace {

constexpr double nan = std::numeric_limits<double>::quiet_NaN();
constexpr double infinite = std::numeric_limits<double>::infinity();

/// A tracer whose answers are tampered with. `spoil` gets the number of the call, from 0, and its hits.
class SpoiltTracer : public Tracer {
public:
    using Spoil = std::function<void(int call, std::span<Hit> hits)>;
    SpoiltTracer(const Structure& structure, Spoil how) : sound(makeCpuTracer(structure)), spoil(std::move(how)) {}

    TraceReport trace(std::span<const Ray> rays, std::span<Hit> hits, Query query) override {
        const TraceReport report = sound->trace(rays, hits, query);
        spoil(calls++, hits);
        return report;
    }
    TraceReport traceShadows(std::span<const Ray> rays, std::span<Hit> hits) override {
        return sound->traceShadows(rays, hits);
    }
    TraceReport traceCosts(std::span<const Ray> rays, std::span<Hit> hits, Query query, bool shadows,
                           std::span<uint32_t> costs) override {
        return sound->traceCosts(rays, hits, query, shadows, costs);
    }

private:
    std::unique_ptr<Tracer> sound;
    Spoil spoil;
    int calls = 0;
};

class CompareFamilies : public testing::Test {
protected:
    CompareFamilies() {
        FrameOptions frame;
        frame.width = frame.height = 24;
        rays = cameraRays(scene, frame);
    }
    std::vector<RayFamily> compare(const SpoiltTracer::Spoil& spoil, bool denormalsAreZero = false) {
        SpoiltTracer device(structure, spoil);
        const std::unique_ptr<Tracer> cpu = makeCpuTracer(structure);
        return compareFamilies(tree, rays, scene.cameras[0].eye, device, cpu.get(), denormalsAreZero);
    }

    Scene scene = importScene(RAIG_SOURCE_DIR "/assets/cornell_box.gltf");
    Geometry geometry = flatten(scene);
    Structure structure = structureType("bvh").build(primitivesOf(geometry), {});
    reference::Tree tree{geometry};
    std::vector<Ray> rays;
};

void miss(Hit& hit) { hit = {0.0f, 0.0f, 0.0f, NO_HIT}; }

TEST_F(CompareFamilies, SoundAnswersHaveNoFaultAndTheCpusBits) {
    const std::vector<RayFamily> families = compare([](int, std::span<Hit>) {});
    ASSERT_EQ(families.size(), 3u);
    for (size_t i = 1; i < families.size(); ++i) EXPECT_GE(families[i].level, families[i - 1].level);
    EXPECT_EQ(families.back().level, 1u);
    for (const RayFamily& family : families) {
        EXPECT_EQ(family.hits.faultCount(), 0u) << family.name;
        EXPECT_GT(family.hits.met, 300u) << family.name;
        ASSERT_TRUE(family.bits);
        EXPECT_EQ(family.bits->rays, family.hits.rays());
        EXPECT_EQ(family.bits->different, 0u);
    }
    EXPECT_FALSE(firstBitDifference(families));
}

TEST_F(CompareFamilies, TheFirstRayOfTheLowestLevelIsNamed) {
    const std::vector<RayFamily> deep = compare([](int call, std::span<Hit> hits) {
        if (call == 2) miss(hits[57]), miss(hits[99]);
    });
    const auto first = firstDifference(deep);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->family, "bounce");
    EXPECT_EQ(first->level, 1u);
    EXPECT_EQ(first->difference.ray, 57u);
    EXPECT_EQ(first->difference.kind, HitClass::missed);
    EXPECT_EQ(first->difference.device.primitive, NO_HIT);
    // The ray itself is told: asked again, the reference gives the same answer.
    const reference::Hit again = tree.closest(widen(first->difference.floats));
    EXPECT_EQ(again.primitive, first->difference.oracle.primitive);
    EXPECT_EQ(again.t, first->difference.oracle.t);

    const std::vector<RayFamily> both = compare([](int call, std::span<Hit> hits) {
        if (call == 2) miss(hits[3]);
        if (call == 0) miss(hits[301]), miss(hits[300]);
    });
    EXPECT_EQ(firstDifference(both)->family, "camera");
    EXPECT_EQ(firstDifference(both)->level, 0u);
    EXPECT_EQ(firstDifference(both)->difference.ray, 300u);
    EXPECT_EQ(firstBitDifference(both)->difference.ray, 300u);
    EXPECT_EQ(sumOf(both).count(HitClass::missed), 3u);
    EXPECT_EQ(sumOfBits(both)->different, 3u);
    EXPECT_EQ(sumOfBits(both)->otherIds, 3u);
    EXPECT_EQ(sumOfBits(both)->tUlpMax, 0u);
}

// A tie is named only where nothing is worse, even of a higher level.
TEST_F(CompareFamilies, FaultsGoBeforeTies) {
    const std::vector<RayFamily> sound = compare([](int, std::span<Hit>) {});
    ASSERT_GT(sumOf(sound).count(HitClass::tie), 0u) << "rays at edges have ties";
    EXPECT_EQ(firstDifference(sound)->difference.kind, HitClass::tie);
    const std::vector<RayFamily> faulty = compare([](int call, std::span<Hit> hits) {
        if (call == 2) miss(hits[57]);
    });
    EXPECT_EQ(firstDifference(faulty)->difference.kind, HitClass::missed);
}

// The reference forgives an ULP, the CPU's walk none.
TEST_F(CompareFamilies, OneBitThatDiffersFromTheCpusIsFound) {
    const std::vector<RayFamily> families = compare([](int call, std::span<Hit> hits) {
        if (call == 1) hits[40].t = std::nextafter(hits[40].t, 0.0f);
    });
    EXPECT_EQ(sumOf(families).faultCount(), 0u);
    EXPECT_EQ(sumOfBits(families)->different, 1u);
    EXPECT_EQ(sumOfBits(families)->otherIds, 0u);
    EXPECT_EQ(sumOfBits(families)->tUlpMax, 1u);
    const auto first = firstBitDifference(families);
    ASSERT_TRUE(first);
    EXPECT_EQ(first->family, "aimed");
    EXPECT_EQ(first->difference.ray, 40u);
    EXPECT_EQ(first->difference.device.t, std::nextafter(first->difference.cpu.t, 0.0f));
}

TEST_F(CompareFamilies, WithoutADeviceNothingIsComparedWithTheCpu) {
    const std::unique_ptr<Tracer> cpu = makeCpuTracer(structure);
    const std::vector<RayFamily> families =
        compareFamilies(tree, rays, scene.cameras[0].eye, *cpu, nullptr, /* denormalsAreZero= */ false);
    EXPECT_FALSE(sumOfBits(families));
    EXPECT_FALSE(families[0].bits);
}

TEST(CompareBits, EveryPartOfAHitCountsAndFlushedDenormalsAreForgivenWhereTheyAreFlushed) {
    const std::vector<Ray> ray(1);
    const Hit hit{1.0f, 0.25f, 1e-40f, 7};
    const auto differs = [&](const Hit& device, bool denormalsAreZero) {
        return compareBits(ray, std::vector{device}, std::vector{hit}, denormalsAreZero).different == 1;
    };
    EXPECT_FALSE(differs(hit, false));
    EXPECT_TRUE(differs({1.0f, 0.25f, 1e-40f, 8}, true));
    EXPECT_TRUE(differs({1.0000001f, 0.25f, 1e-40f, 7}, true));
    EXPECT_TRUE(differs({1.0f, 0.25000003f, 1e-40f, 7}, true));
    EXPECT_TRUE(differs({1.0f, -0.25f, 1e-40f, 7}, true));
    EXPECT_TRUE(differs({1.0f, 0.25f, 2e-38f, 7}, true));
    EXPECT_TRUE(differs({1.0f, 0.25f, 0.0f, 7}, false));
    EXPECT_FALSE(differs({1.0f, 0.25f, 0.0f, 7}, true));
    EXPECT_FALSE(differs({1.0f, 0.25f, -0.0f, 7}, true));
    EXPECT_TRUE(differs({static_cast<float>(nan), 0.25f, 0.0f, 7}, true));
}

TEST(UlpHistogram, BucketsDoubleAndLeaveNothingOut) {
    EXPECT_EQ(UlpHistogram::bucketOf(0), 0u);
    EXPECT_EQ(UlpHistogram::bucketOf(1), 1u);
    EXPECT_EQ(UlpHistogram::bucketOf(2), 2u);
    for (size_t i = 0; i < UlpHistogram::buckets; ++i) {
        EXPECT_EQ(UlpHistogram::bucketOf(UlpHistogram::lowest(i)), i);
        EXPECT_EQ(UlpHistogram::bucketOf(UlpHistogram::highest(i)), i);
        EXPECT_EQ(UlpHistogram::lowest(i), i == 0 ? 0 : UlpHistogram::highest(i - 1) + 1);
    }
    EXPECT_EQ(UlpHistogram::lowest(4), 5u);
    EXPECT_EQ(UlpHistogram::highest(4), 8u);
    const float most = std::numeric_limits<float>::max();
    EXPECT_LT(UlpHistogram::bucketOf(ulpsApart(-most, most)), UlpHistogram::buckets);
}

TEST_F(CompareFamilies, HistogramsCountEveryDistanceOnce) {
    const std::vector<RayFamily> families = compare([](int call, std::span<Hit> hits) {
        for (int i = 0; call == 0 && i < 100; ++i) hits[300].t = std::nextafter(hits[300].t, 1e9f);
    });
    uint64_t all = 0;
    for (const uint64_t count : sumOf(families).tUlps.counts) all += count;
    uint64_t measured = 0;
    for (const RayFamily& family : families) measured += family.hits.count(HitClass::same);
    EXPECT_LE(all, measured);
    EXPECT_GT(all, 1000u);
    EXPECT_EQ(families[0].hits.tUlps.counts[UlpHistogram::bucketOf(100)], 1u);
}

// ---- Bounds ------------------------------------------------------------------------------------------------------------

Bound boundOf(std::string_view name, double limit) {
    const CompareMetric* const metric = findCompareMetric(name);
    EXPECT_NE(metric, nullptr) << name;
    return {metric, limit};
}

TEST(CompareBounds, EveryMetricHasAValueOfItsOwn) {
    PictureDifference d;
    d.pixels = 10;
    d.nan = 1;
    d.max = 2.0, d.rmse = 3.0, d.relmse = 4.0, d.psnr = 5.0, d.ssim = 6.0;
    d.flipMean = 7.0, d.flipP99 = 8.0, d.flipMax = 9.0;
    SceneComparison scene;
    scene.pixels.outsideTies = d;
    scene.pixels.ties = 10;
    scene.all.counts = {11, 12, 13, 14, 15};
    scene.bits.emplace().different = 16;
    scene.all.tUlp = {17.0, 18.0, 19.0};
    scene.all.offset.max = 20.0;
    scene.discardedMean = 21.0, scene.discardedMax = 22.0;
    std::vector<Bound> bounds;
    for (const CompareMetric& metric : compareMetrics()) bounds.push_back({&metric, 0.0});
    ASSERT_EQ(bounds.size(), 22u);
    std::set<double> values;
    for (const CheckedBound& one : checkBounds(bounds, scene)) values.insert(one.value);
    EXPECT_EQ(values.size(), 22u) << "two metrics have the same value";
    EXPECT_EQ(*values.begin(), 1.0);
    EXPECT_EQ(*values.rbegin(), 22.0);
    EXPECT_EQ(checkBounds(std::vector{boundOf("flip_p99", 0.0)}, d)[0].value, 8.0);
    EXPECT_EQ(findCompareMetric("flip"), nullptr);
    EXPECT_EQ(compareMetricNames(/* ofScenes= */ false).size(), 9u);
}

TEST(CompareBounds, AreKeptUpToTheLimitAndNeverByANaN) {
    const auto kept = [](std::string_view name, double limit, double value) {
        return CheckedBound{boundOf(name, limit), value}.isKept();
    };
    EXPECT_TRUE(kept("rmse", 0.5, 0.5));
    EXPECT_FALSE(kept("rmse", 0.5, std::nextafter(0.5, 1.0)));
    EXPECT_FALSE(kept("rmse", 0.5, nan));
    EXPECT_FALSE(kept("rmse", 0.5, infinite));
    EXPECT_TRUE(kept("psnr", 40.0, infinite)) << "of equal pictures";
    EXPECT_TRUE(kept("psnr", 40.0, 40.0));
    EXPECT_FALSE(kept("psnr", 40.0, 39.9));
    EXPECT_FALSE(kept("ssim", 0.5, nan));
    EXPECT_EQ((CheckedBound{boundOf("rmse", 0.001), 0.25}.failure()), "rmse is 0.25; allowed: at most 0.001");
    EXPECT_EQ((CheckedBound{boundOf("missed", 0.0), 12345678.0}.failure()), "missed is 12345678; allowed: at most 0");
    EXPECT_EQ((CheckedBound{boundOf("psnr", 40.0), 9.5}.failure()), "psnr is 9.5; allowed: at least 40");
    EXPECT_EQ((CheckedBound{boundOf("ssim", 0.5), 0.5}.failure()), "");
    EXPECT_NE((CheckedBound{boundOf("ssim", 0.5), nan}.failure()), "");
}

// Pictures without a pixel in common agree about nothing: that is no agreement.
TEST(CompareBounds, AreNotKeptByNoPixels) {
    const PictureDifference none = comparePictures(Image(3, 3, vec3(NAN)), Image(3, 3, vec3(1.0f)));
    ASSERT_EQ(none.pixels, 0u);
    for (const std::string_view name : {"rmse", "relmse", "psnr", "ssim", "flip_mean", "flip_p99", "flip_max", "max"})
        EXPECT_FALSE(checkBounds(std::vector{boundOf(name, findCompareMetric(name)->largerIsBetter ? -1e9 : 1e9)}, none)[0]
                         .isKept())
            << name;
    EXPECT_EQ(checkBounds(std::vector{boundOf("nan", 8.0)}, none)[0].failure(), "nan is 9; allowed: at most 8");
}

TEST(CompareBounds, OfAMetricThatIsGivenReplaceTheScenesOwn) {
    SceneComparison scene;
    const auto limitsOf = [&](const std::vector<Bound>& given, std::string_view name) {
        std::vector<double> limits;
        for (const Bound& one : sceneBounds(given, scene))
            if (one.metric->name == name) limits.push_back(one.limit);
        return limits;
    };
    EXPECT_EQ(limitsOf({}, "rmse"), std::vector{1e-3});
    EXPECT_EQ(limitsOf({boundOf("rmse", 0.5)}, "rmse"), std::vector{0.5});
    EXPECT_EQ(limitsOf({boundOf("rmse", 0.5)}, "missed"), std::vector{0.0});
    EXPECT_EQ(limitsOf({boundOf("tie", 3.0), boundOf("tie", 2.0)}, "tie"), (std::vector{3.0, 2.0}));
    EXPECT_TRUE(limitsOf({}, "different").empty()) << "nothing was compared with the CPU";
    scene.bits.emplace();
    EXPECT_TRUE(limitsOf({}, "different").empty()) << "the device's arithmetic is its own";
    scene.isIeee = true;
    EXPECT_EQ(limitsOf({}, "different"), std::vector{0.0});
}

}  // namespace
}  // namespace raig
