// What is seen first where surfaces are cut out or blended: the first that is there by half at least.
#include "device/specialize.hpp"
#include "rays/frame_data.hpp"
#include "rays/kernels.hpp"
#include "support/devices.hpp"
#include "support/first_seen.hpp"
#include "support/leaves.hpp"

#include <cmath>

namespace raig {
namespace {

using namespace test;

constexpr uint32_t wallPlace = 0, cardPlace = 1;  // instances, and their materials
constexpr float nothingAtAll = std::numeric_limits<float>::infinity();

/// Across x and y from -half to half at z, with texture coordinates 0 to 1 from the left and from the top.
void addPane(Scene& scene, float half, float z, const Material& material, float slope = 0.0f) {
    const float side = 2 * half;
    const uint32_t pane = addQuad(scene, {-half, -half, z + slope}, {side, 0, -2 * slope}, {0, side, 0}, material);
    scene.meshes[pane].uvs = {{0, 1}, {1, 1}, {1, 0}, {0, 0}};
}

/// A wall, seen from 4 before the origin.
Scene wall() {
    Scene scene;
    scene.images = {{2, 1, {255, 255, 255, 0, 255, 255, 255, 255}}, {1, 1, {255, 255, 255, 0}}};
    addPane(scene, 4.0f, -2.0f, matte(vec3(0.2f, 0.4f, 0.6f)));
    scene.cameras.push_back(lookAt({0, 0, 4}, {0, 0, 0}));
    return scene;
}

/// It, and before it a card, askew, whose left half the texture cuts out; `change` is made to its material.
template <class Change>
Scene wallBehindCard(const Change& change) {
    Scene scene = wall();
    Material card = cutOut(0.5f);
    change(card);
    addPane(scene, 1.0f, 0.0f, card, 0.5f);
    return scene;
}
Scene wallBehindCard() {
    return wallBehindCard([](Material&) {});
}

/// `count` panes of which nothing is there, close behind each other, before the wall's middle.
Scene wallBehindPanes(uint32_t count) {
    Scene scene = wall();
    Material pane = cutOut(0.5f);
    pane.baseColorTexture->image = 1;
    for (uint32_t i = 0; i < count; ++i) addPane(scene, 0.75f, 1.0f - 0.02f * static_cast<float>(i), pane);
    return scene;
}

/// The distance of floats about x.
double ulpOf(double x) {
    return std::ldexp(1.0, std::ilogb(x) - 23);
}

/// The instance that is seen in each pixel of a row, or NO_HIT.
std::vector<uint32_t> placesOf(const PrimaryHits& hits) {
    std::vector<uint32_t> places;
    for (const PrimaryHit& hit : hits.pixels) places.push_back(hit.instance);
    return places;
}

// Everything of a pixel, to the bit: where the card is cut out, what would be seen without it, and else what would be seen
// if all of it were there.
TEST(PrimaryCoverage, ShowsTheWallWhereTheCardIsCutOutAndTheCardWhereNot) {
    const FrameOptions options = square(40, 1);
    const PrimaryHits got = onCpu(Stage(wallBehindCard()), options), without = onCpu(Stage(wall()), options);
    const PrimaryHits whole = onCpu(Stage(wallBehindCard([](Material& m) { m.alphaVaries = false; })), options);
    size_t cards = 0, holes = 0;
    for (uint32_t i = 0; i < got.pixels.size(); ++i) {
        SCOPED_TRACE(i);
        const double a = std::tan(0.5 * double{Camera{}.yfov}) * ((i % 40 + 0.5) / 20.0 - 1.0);
        const double b = std::tan(0.5 * double{Camera{}.yfov}) * (1.0 - (i / 40 + 0.5) / 20.0);
        const double away = 4.0 / (1.0 - 0.5 * a);  // of the card's plane, z = -x / 2, along the camera's axis
        const bool onCard = std::abs(a * away) < 1.0 && std::abs(b * away) < 1.0, isCard = onCard && a > 0.0;
        ASSERT_TRUE(haveSameBits(got.pixels[i], isCard ? whole.pixels[i] : without.pixels[i]));
        ASSERT_EQ(got.pixels[i].instance, isCard ? cardPlace : wallPlace);
        ASSERT_EQ(got.pixels[i].material, isCard ? cardPlace : wallPlace);
        const double depth = (isCard ? away : 6.0) * std::sqrt(1.0 + a * a + b * b);
        ASSERT_NEAR(got.pixels[i].depth, depth, 8 * ulpOf(depth));
        ASSERT_NEAR(got.pixels[i].normal.z, isCard ? 2.0 / std::sqrt(5.0) : 1.0, 2 * ulpOf(1.0));
        ASSERT_NEAR(got.pixels[i].albedo.x, isCard ? 1.0 : 0.2, 2 * ulpOf(1.0));
        cards += isCard;
        holes += onCard && !isCard;
    }
    EXPECT_GT(cards, 200u);
    EXPECT_GT(holes, 200u);
}

TEST(PrimaryCoverage, ShowsWhatBlendsFromAHalfOn) {
    for (const float alpha : {0.0f, 0.3f, 0.499f, 0.5f, 0.7f, 1.0f}) {
        const Scene scene = wallBehindCard([&](Material& m) { m = covering(alpha); });
        const PrimaryHits hits = onCpu(Stage(scene), square(1, 1));
        EXPECT_EQ(placesOf(hits), std::vector<uint32_t>{alpha < 0.5f ? wallPlace : cardPlace}) << alpha;
    }
}

// A ball is passed twice: where it is entered, and where it is left.
TEST(PrimaryCoverage, IsThatOfSpheresToo) {
    for (const float alpha : {0.25f, 0.75f}) {
        Scene scene = wall();
        addTrueSphere(scene, {0.1f, 0.1f, 0.0f}, 1.0f, covering(alpha));
        const PrimaryHits hits = onCpu(Stage(scene), square(1, 1));
        EXPECT_EQ(placesOf(hits), std::vector<uint32_t>{alpha < 0.5f ? wallPlace : cardPlace}) << alpha;
    }
}

// The picture lets rays pass as many.
TEST(PrimaryCoverage, LooksThroughSixtyFourSurfacesAndNoMore) {
    for (const uint32_t panes : {63u, 64u, 65u, 70u}) {
        const PrimaryHits hits = onCpu(Stage(wallBehindPanes(panes)), square(8, 1));
        const PrimaryHit& middle = hits.pixels[4 * 8 + 4];
        const bool ends = panes > 64;
        EXPECT_EQ(middle.instance, ends ? NO_HIT : wallPlace) << panes;
        EXPECT_EQ(middle.primitive == NO_HIT, ends) << panes;
        EXPECT_EQ(middle.material, ends ? NO_HIT : wallPlace) << panes;
        EXPECT_EQ(middle.depth == nothingAtAll, ends) << panes;
        EXPECT_EQ(middle.albedo == vec3(0.0f) && middle.normal == vec3(0.0f) && middle.position == vec3(0.0f), ends);
        EXPECT_EQ(hits.pixels[0].instance, wallPlace) << "beside them";
    }
}

TEST(PrimaryCoverage, IsTheSameInPartsOfThePictureAndWithInstancesKept) {
    FrameOptions options = square(64, 1);
    const Stage stage(leafyScene());
    const PrimaryHits whole = onCpu(stage, options);
    EXPECT_TRUE(haveSameBits(onCpu(Stage::kept(leafyScene()), options), whole));
    options.crop = Crop{11, 7, 40, 29};
    const PrimaryHits part = onCpu(stage, options);
    ASSERT_EQ(part.pixels.size(), 40u * 29u);
    for (const PrimaryHit& hit : part.pixels) ASSERT_TRUE(haveSameBits(hit, whole.pixels[hit.pixel])) << hit.pixel;
}

// "No more than a scene needs": nothing counts rays, nor writes them, where none go on.
TEST(PrimaryCoverage, IsNoPartOfTheKernelOfScenesWithoutAlpha) {
    const auto bindings = [](const Scene& scene) {
        const Stage stage(scene);
        const Constants constants = {{0, 64}, {1, packFrame(stage.scene, stage.geometry).features}, {2, 1}};
        const std::vector<uint32_t> spirv = vk::specialize("aov", findKernel("aov_storage").value(), constants);
        return reflect("aov", spirv, {}).bindings;
    };
    constexpr uint32_t counter = 1;
    EXPECT_FALSE(bindings(wall()).contains(counter));
    EXPECT_TRUE(bindings(wallBehindCard()).contains(counter));
}

// ---- On devices --------------------------------------------------------------------------------------------------------

class PrimaryCoverageOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, PrimaryCoverageOnDevice, testing::ValuesIn(devicesToTest()), testName);

// 264 x 264 pixels are more than one tile.
TEST_P(PrimaryCoverageOnDevice, HasTheCpusBits) {
    Device device(info);
    for (const bool keeps : {false, true}) {
        const Stage stage = keeps ? Stage::kept(leafyScene()) : Stage(leafyScene());
        const FrameOptions options = square(keeps ? 48 : 264, 1);
        EXPECT_TRUE(haveSameBits(onDevice(device, stage, options), onCpu(stage, options)))
            << (keeps ? "kept" : "written out");
    }
    for (const Scene& scene : {wallBehindCard(), wallBehindPanes(64), wallBehindPanes(70)}) {
        const Stage stage(scene);
        EXPECT_TRUE(haveSameBits(onDevice(device, stage, square(40, 1)), onCpu(stage, square(40, 1))));
    }
}

}  // namespace
}  // namespace raig
