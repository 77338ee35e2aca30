// Item buffers: whatever hints say, hits and pictures are those without, to the bit; and where nothing is hard, hints are
// right.
#include "rays/item_buffer.hpp"

#include "base/random.hpp"
#include "device/raster.hpp"
#include "measure/stress_pictures.hpp"
#include "rays/frame_data.hpp"
#include "rays/kernels.hpp"
#include "support/devices.hpp"
#include "support/groves.hpp"
#include "support/leaves.hpp"
#include "support/rendering.hpp"
#include "support/soups.hpp"
#include "support/tracing.hpp"
#include "support/variants.hpp"

#include <algorithm>
#include <cstring>
#include <map>

namespace raig {
namespace {

using namespace test;

using Hint = uvec2;
constexpr Hint noItem{shared::NO_ITEM, shared::NO_ITEM};
constexpr Hint noHint{shared::NO_HINT, shared::NO_HINT};

class Items : public OnEveryDevice {
protected:
    void SetUp() override {
        OnEveryDevice::SetUp();
        if (IsSkipped()) return;
        if (!info.features.graphics) GTEST_SKIP() << info.name << " cannot draw";
        device_ = std::make_unique<Device>(info, DeviceOptions{.graphics = true});
    }
    void TearDown() override {
        device_.reset();
        OnEveryDevice::TearDown();
    }

    /// The picture by rays, and the same with an item buffer, which must have its bits.
    Picture expectSamePicture(const Stage& stage, FrameOptions options, const std::string& what) {
        const auto tracer = makeDeviceTracer(*device_, stage.structure);
        DeviceFrame frame(*device_, stage.scene, stage.geometry, *tracer);
        const Picture want = frame.render(options);
        options.itemsOf = &stage.structure;
        const Picture got = frame.render(options);
        EXPECT_EQ(countDifferent(got, want), 0u) << what;
        EXPECT_EQ(bitsOf(got), bitsOf(want)) << what;
        EXPECT_EQ(got.statistics.hintedRays, options.part().pixels() * options.samples) << what;
        EXPECT_LE(got.statistics.fallbacks, got.statistics.hintedRays) << what;
        EXPECT_EQ(want.statistics.hintedRays, 0u);
        return got;
    }

    struct Traced {
        std::vector<Hit> hits;
        uint64_t failed = 0;
    };
    Traced trace(const Structure& structure, const std::vector<Ray>& rays, const std::vector<Hint>* hints) {
        const auto tracer = makeDeviceTracer(*device_, structure);
        Buffer rayBuffer(*device_, rays.size() * sizeof(Ray)), hitBuffer(*device_, rays.size() * sizeof(Hit));
        Buffer hintBuffer(*device_, rays.size() * shared::HINTS_A_RAY * sizeof(Hint));
        rayBuffer.uploadValues(std::span<const Ray>(rays));
        if (hints) hintBuffer.uploadValues(std::span<const Hint>(*hints));
        const TraceReport report = tracer->traceBuffers(rayBuffer, hitBuffer, static_cast<uint32_t>(rays.size()),
                                                        Query::closest, false, hints ? &hintBuffer : nullptr);
        return {hitBuffer.downloadValues<Hit>(), report.failedHints};
    }

    std::unique_ptr<Device> device_;
};
INSTANTIATE_TEST_SUITE_P(Devices, Items, testing::ValuesIn(devicesToTest()), testName);

/// Hints of every kind for rays that meet `hits`: right, wrong, that nothing is there; up to HINTS_A_RAY each, or none. And
/// of how many rays all fail.
std::vector<Hint> hintsOfAllKinds(const Structure& structure, const std::vector<Hit>& hits, uint64_t& failing) {
    std::map<uint32_t, uint32_t> referenceOf;
    for (uint32_t i = 0; i < structure.header.triangleCount; ++i) referenceOf[referencedId(structure, i)] = i;
    const uint32_t count = structure.header.triangleCount;
    Random random(11);
    std::vector<Hint> hints(hits.size() * shared::HINTS_A_RAY, noHint);
    failing = 0;
    for (size_t i = 0; i < hits.size(); ++i) {
        const uint32_t some = random.below(shared::HINTS_A_RAY + 1);
        bool named = some == 0;
        for (uint32_t k = 0; k < some; ++k) {
            const uint32_t kind = random.below(4);
            Hint& hint = hints[i * shared::HINTS_A_RAY + k];
            hint = noItem;
            if (kind > 0 && count > 0) hint = {random.below(count), 0};
            if (kind == 3 && hits[i].primitive != NO_HIT) hint = {referenceOf.at(hits[i].primitive), 0};
            named |= hits[i].primitive == (hint == noItem ? NO_HIT : referencedId(structure, hint.x));
        }
        failing += !named;
    }
    return hints;
}

// A hint may name anything: the walk that begins with what it names finds what a walk without finds, ties included.
TEST_P(Items, WhateverHintsSayHitsAreTheSame) {
    const std::vector<Soup> all = soups();
    for (size_t i = 0; i < all.size(); i += isLong() ? 1 : 4) {
        const Soup& soup = all[i];
        const std::vector<Ray> sent = rays(soup.triangles, 3, affordable(300));
        const std::vector<Variant> some = {{"bvh", {}}, {"kdtree", {}}, {"grid", {}}};
        for (const Variant& variant : isLong() || i == 0 ? walkVariants() : some) {
            const Structure structure = variant.build(soup.triangles);
            const Traced want = trace(structure, sent, nullptr);
            uint64_t failing = 0;
            const std::vector<Hint> hints = hintsOfAllKinds(structure, want.hits, failing);
            const Traced got = trace(structure, sent, &hints);
            expectSame(got.hits, want.hits, sent, soup.name + " " + nameOf(variant));
            EXPECT_EQ(got.failed, failing) << soup.name << ' ' << nameOf(variant);
            EXPECT_EQ(want.failed, 0u);
        }
    }
}

/// A room with a bit of all that shading knows, seen in perspective.
Scene furnished() {
    Scene scene = variedRoom();
    Material tinted;
    tinted.roughness = 0.0f;
    tinted.transmission = 1.0f;
    tinted.thin = false;
    Material polished = tinted;
    polished.transmission = 0.0f;
    polished.metallic = 1.0f;
    addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 10, true, tinted);
    addSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, 6, false, polished);
    addTrueSphere(scene, {0.2f, 0.6f, 1.5f}, 0.6f, polished);
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(4.0f)}};
    return scene;
}

FrameOptions sized(uint32_t width, uint32_t height, uint32_t samples) {
    FrameOptions options = square(width, samples, 4, 1.0f / 512.0f);
    options.height = height;
    return options;
}

TEST_P(Items, PicturesHaveTheBitsOfTracedOnesHoweverTheyAreMade) {
    Stage stage(furnished());
    expectSamePicture(stage, sized(61, 43, 1), "one sample");
    expectSamePicture(stage, sized(37, 29, 9), "nine samples");
    FrameOptions options = sized(61, 43, 3);
    options.tilePixels = 300;
    expectSamePicture(stage, options, "tiles of 300");
    options.crop = Crop{17, 9, 23, 31};
    expectSamePicture(stage, options, "a part");
    options = sized(40, 30, 4);
    options.countsCosts = true;
    expectSamePicture(stage, options, "with costs");
    options = sized(40, 30, 4);
    options.aperture = 0.3f;
    options.focus = 5.0f;
    expectSamePicture(stage, options, "through a lens");
    stage.scene.cameras[0].orthographic = true;
    stage.scene.cameras[0].xmag = stage.scene.cameras[0].ymag = 3.0f;
    expectSamePicture(stage, sized(40, 30, 4), "in parallel");
    Scene nothing;
    nothing.cameras = stage.scene.cameras;
    expectSamePicture(Stage(nothing), sized(8, 8, 1), "of nothing");
}

// The buffer shows surfaces that are cut out whole: rays meet them there, and go on without hints.
TEST_P(Items, PicturesOfWhatIsCutOutHaveTheBitsOfTracedOnes) {
    const Stage stage(leafyScene());
    const Picture picture = expectSamePicture(stage, sized(40, 30, 2), "leaves");
    EXPECT_LT(picture.statistics.fallbacks, picture.statistics.hintedRays / 4);
}

TEST_P(Items, PicturesOfInstancesHaveTheBitsOfTracedOnes) {
    const std::vector<Grove> all = groves();
    for (size_t i = 0; i < all.size(); i += isLong() ? 1 : 3) {
        const Grove& grove = all[i];
        Scene scene = grove.scene;
        if (scene.cameras.empty()) scene.cameras.push_back(lookAt({0, 2, 9}, {0, 0, 0}));
        for (const char* accel : {"bvh", "grid"})
            expectSamePicture(Stage::kept(scene, accel), sized(32, 24, 1), grove.name + " " + accel);
    }
}

/// The items of a picture's rows, by an item buffer of its own.
std::vector<Hint> itemsOf(Device& device, const Stage& stage, const FrameOptions& options, uint32_t first, uint32_t end,
                          shared::ItemWindow& window) {
    const auto tracer = makeDeviceTracer(device, stage.structure);
    ItemBuffer items(device, stage.structure, *tracer);
    shared::FrameParams frame{};
    setView(stage.scene, options, frame);
    items.begin(frame);
    items.show(frame, first, end);
    const std::vector<uint32_t> words = items.items().downloadValues<uint32_t>();
    std::memcpy(&window, words.data(), sizeof(window));
    std::vector<Hint> result;
    const size_t count = size_t{frame.partWidth} * window.rows * window.scale * window.scale;
    for (size_t i = 0; i < count; ++i) result.push_back({words[4 + 2 * i], words[5 + 2 * i]});
    return result;
}

/// How many of `hits`, of a picture's pixels, no item names that is at most `reach` pixels aside.
uint64_t unnamedWithin(int reach, const Structure& structure, const std::vector<Hint>& items, const std::vector<Hit>& hits,
                       int width, int height) {
    uint64_t unnamed = 0;
    for (int y = 0; y < height; ++y)
        for (int x = 0; x < width; ++x) {
            bool named = false;
            for (int v = std::max(0, y - reach); v <= std::min(height - 1, y + reach); ++v)
                for (int u = std::max(0, x - reach); u <= std::min(width - 1, x + reach); ++u) {
                    const Hint& item = items[v * width + u];
                    named |= hits[y * width + x].primitive == (item == noItem ? NO_HIT : referencedId(structure, item.x));
                }
            unnamed += !named;
        }
    return unnamed;
}

// At one sample a pixel its own item is what the raster says of the pixel's centre, and nearly always right; the three
// nearest to it are asked, too.
TEST_P(Items, AreWhatRaysMeetAndEachThatIsNotIsCounted) {
    Scene scene = furnished();
    for (const bool parallel : {false, true}) {
        scene.cameras[0].orthographic = parallel;
        scene.cameras[0].xmag = scene.cameras[0].ymag = 3.0f;
        const Stage stage(scene);
        FrameOptions options = sized(160, 120, 1);
        shared::ItemWindow window;
        const std::vector<Hint> items = itemsOf(*device_, stage, options, 0, 120, window);
        ASSERT_EQ(items.size(), 160u * 120u);
        const std::vector<Hit> hits = traceOnCpu(stage.structure, cameraRays(stage.scene, options));
        EXPECT_GT(std::ranges::count_if(items, [](const Hint& item) { return item != noItem; }), 160 * 120 / 2);
        const uint64_t others = unnamedWithin(0, stage.structure, items, hits, 160, 120);
        EXPECT_LE(others, items.size() / 50);
        const uint64_t fallbacks = expectSamePicture(stage, options, "of a room").statistics.fallbacks;
        EXPECT_LE(fallbacks, others);
        EXPECT_GE(fallbacks, unnamedWithin(1, stage.structure, items, hits, 160, 120));
        options.samples = 4;
        const Picture four = expectSamePicture(stage, options, "of four samples");
        EXPECT_LE(four.statistics.fallbacks, four.statistics.hintedRays / 50) << "samples lie between items";
    }
}

// Pictures wider than what a device can draw into, and of more rows than are drawn at once.
TEST_P(Items, OfLargePicturesAreDrawnPartByPart) {
    Scene scene = furnished();
    scene.cameras[0].yfov = 0.002f;  // of a picture that is 800 times as wide as it is high
    const Stage stage(scene);
    const FrameOptions options = sized(65536, 160, 1);
    for (const uint32_t row : {0u, 72u, 152u}) {
        FrameOptions rows = options;
        rows.crop = Crop{0, row, options.width, 8};
        const std::vector<Ray> rays = cameraRays(stage.scene, rows);
        shared::ItemWindow window;
        const std::vector<Hint> items = itemsOf(*device_, stage, options, row, row + 8, window);
        EXPECT_EQ(window.firstRow, row);
        EXPECT_EQ(window.rows, std::min(64u, 160 - row));
        std::vector<Ray> sent;
        std::vector<uint32_t> named;
        for (size_t i = 0; i < rays.size(); i += 97) {
            sent.push_back(rays[i]);
            named.push_back(items[i] == noItem ? NO_HIT : referencedId(stage.structure, items[i].x));
        }
        const std::vector<Hit> hits = traceOnCpu(stage.structure, sent);
        size_t others = 0, seen = 0;
        for (size_t i = 0; i < hits.size(); ++i) {
            others += named[i] != hits[i].primitive;
            seen += hits[i].primitive != NO_HIT;
        }
        EXPECT_GT(seen, hits.size() / 10);
        EXPECT_LE(others, hits.size() / 20);
    }
}

// Words are written and copied as they are: numbers beyond 2^24 and beyond 2^31, that floats do not tell apart.
TEST_P(Items, HoldNumbersThatFloatsDoNotTellApart) {
    const Stage stage(furnished());
    const auto tracer = makeDeviceTracer(*device_, stage.structure);
    const auto find = [&](const char* name) {
        return findKernel(std::string(name) + (device_->loadsTexel() ? "_texel" : "_storage")).value();
    };
    const BigArray& references = tracer->references();
    Raster raster(*device_, "items", find("item_corner"), find("item_word"),
                  {{0, false}, {1, true}, {2, 1}, {3, 31}, {4, references.chunkCount()}, {5, references.chunkShift()}}, 64,
                  48);
    Buffer list(*device_, 16);
    raster.bind(0, tracer->nodes());
    raster.bind(1, references);
    raster.bind(2, list);
    shared::FrameParams frame{};
    setView(stage.scene, sized(64, 48, 1), frame);
    const StructureHeader& header = stage.structure.header;
    const shared::ItemView view =
        ItemProjection(frame, {header.lo, header.hi}, header.unit, {0, 0, 64, 48}, 1, 0.01).view(0);
    Buffer words(*device_, 64 * 48 * 8);
    std::vector<Hint> want;
    for (const uint32_t base : {0u, (1u << 24) + 1, (1u << 31) + 1, 0xffff0001u}) {
        // Named from `base` on, and read from where they are: addresses go around.
        const Draw all{.triangles = header.triangleCount, .instances = 1, .words = {base, 0u - 3 * base, 0, 0}};
        raster.draw(64, 48, true, std::as_bytes(std::span(&view, 1)), std::span(&all, 1));
        raster.copy(64, 48, words, 0, 64);
        const std::vector<Hint> got = words.downloadValues<Hint>();
        if (base == 0) want = got;
        for (size_t i = 0; i < got.size(); ++i)
            ASSERT_EQ(got[i].x, want[i] == noItem ? shared::NO_ITEM : want[i].x + base) << base << ' ' << i;
    }
    EXPECT_GT(std::ranges::count_if(want, [](const Hint& hint) { return hint != noItem; }), 64 * 48 / 2);
}

// Case 57: where rasters are known to be wrong.
TEST_P(Items, AreNoMoreThanHintsInTheHardCase) {
    PictureSettings settings{.cases = hard::itemCases(), .draw = {}, .device = info.name, .isDevice = true, .draws = true,
                             .subjects = {}};
    for (const char* accel : {"brute", "bvh"}) settings.subjects.push_back(pictureSubjectOf({accel, {}}, device_.get()));
    const StressReport report = stressPictures(settings, [](const std::string&, double) {});
    ASSERT_EQ(report.results.size(), 2u);
    for (const StressResult& result : report.results) {
        EXPECT_EQ(result.forbidden(), 0u) << result.structure << ": "
                                          << (result.examples.empty() ? "" : result.examples[0].what);
        EXPECT_GE(result.rays, 10u * 2 * 24 * 18);
    }
}

}  // namespace
}  // namespace raig
