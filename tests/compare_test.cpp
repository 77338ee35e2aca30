// The comparison must see what is planted, and nothing else.
#include "measure/compare.hpp"
#include "measure/compare_rays.hpp"

#include <gtest/gtest.h>

#include <random>

namespace raig {
namespace {

using reference::noTriangle;

/// A floor of 2 x n x n triangles over [0, 1]^2 at z = 0, and below it, at z = -1, one large square (the last two ids).
Scene floors(uint32_t n, const vec3& origin = vec3(0.0f), bool lower = true) {
    Scene scene;
    scene.materials.emplace_back();
    scene.instances.emplace_back();
    Mesh& mesh = scene.meshes.emplace_back();
    const auto quad = [&](const vec3& corner, float size) {
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        for (const vec3& offset : {vec3(0.0f), vec3(size, 0, 0), vec3(size, size, 0), vec3(0, size, 0)})
            mesh.positions.push_back(origin + corner + offset);
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.triangles.emplace_back(first, first + 2, first + 3);
    };
    const float step = 1.0f / static_cast<float>(n);
    for (uint32_t y = 0; y < n; ++y)
        for (uint32_t x = 0; x < n; ++x) quad(step * vec3(x, y, 0.0f), step);
    if (lower) quad(vec3(-8, -8, -1), 16.0f);
    mesh.materials.resize(mesh.triangles.size(), 0);
    return scene;
}

struct Judge {
    explicit Judge(Scene s) : scene(std::move(s)), geometry(flatten(scene)), tree(geometry) {}

    Ray down(float x, float y) const { return {vec3(x, y, 1.0f), 0.0f, vec3(0, 0, -1), 3.4e38f}; }

    /// What a device that is right would say.
    Hit truth(const Ray& ray) const {
        const reference::Hit hit = tree.closest(widen(ray));
        if (hit.primitive == noTriangle) return nothing;
        return {static_cast<float>(hit.t), static_cast<float>(hit.u), static_cast<float>(hit.v), hit.primitive};
    }
    HitClass judge(const Ray& ray, const Hit& answer) const {
        return classifyHit(tree, ray, tree.closest(widen(ray)), answer);
    }

    static constexpr Hit nothing{0.0f, 0.0f, 0.0f, NO_HIT};
    Scene scene;
    Geometry geometry;
    reference::Tree tree;
};

TEST(CompareHits, RightAnswersAreTheSame) {
    const Judge judge(floors(4));
    std::mt19937 random(1);
    std::uniform_real_distribution<float> unit(-1.0f, 2.0f);
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int i = 0; i < 500; ++i) {
        rays.push_back(judge.down(8.0f * unit(random) / 2.0f, unit(random)));
        hits.push_back(judge.truth(rays.back()));
    }
    const HitComparison got = compareHits(judge.tree, rays, hits);
    EXPECT_EQ(got.count(HitClass::same), 500u);
    EXPECT_EQ(got.faultCount(), 0u);
    EXPECT_EQ(got.tUlp.max, 0.0);
    EXPECT_GT(got.met, 400u) << "the rays test little";
    EXPECT_LT(got.offset.max, 1.0);
}

// From inside a sphere there is no silhouette: every ray goes somewhere, to all sides, and meets the sphere.
TEST(AimedRays, FromInsideASphereMeetIt) {
    Scene scene;
    scene.materials.emplace_back();
    scene.instances.emplace_back();
    scene.meshes.emplace_back().materials = {0};
    scene.meshes[0].spheres = {{vec3(3, -2, 1), 2.0f}};
    const Judge judge(scene);
    for (const vec3& eye : {vec3(3, -2, 1), vec3(3.5f, -3, 1.25f), vec3(3, -2, 2.999f)}) {
        const std::vector<Ray> rays = aimedRays(judge.geometry, eye, 300);
        ASSERT_EQ(rays.size(), 300u);
        Box met;
        for (const Ray& ray : rays) {
            ASSERT_NE(ray.direction, vec3(0));
            const reference::Hit hit = judge.tree.closest(widen(ray));
            ASSERT_EQ(hit.primitive, 0u) << ray.direction.x << ' ' << ray.direction.y << ' ' << ray.direction.z;
            met.grow(vec3(dvec3(eye) + hit.t * dvec3(ray.direction)));
        }
        for (int axis = 0; axis < 3; ++axis) EXPECT_GT(met.extent()[axis], 3.5f) << "all on one side";
    }
}

// Two triangles of a fan, a ray at their vertex that grazes one of them: exactly, that one is met only farther on, but the
// vertex itself belongs to both. A point beside the vertex is no tie.
TEST(CompareHits, ASharedVertexBelongsToEachOfItsTriangles) {
    Scene scene;
    scene.materials.resize(1);
    scene.instances.emplace_back();
    Mesh& mesh = scene.meshes.emplace_back();
    mesh.positions = {{-0.0659713969f, 0.0703350008f, 0.0357802995f},
                      {-0.0661036968f, 0.0713258982f, 0.0366500989f},
                      {-0.067053698f, 0.0714460015f, 0.0363401994f},
                      {-0.0651530027f, 0.0712063015f, 0.036954999f},
                      {-0.0662077963f, 0.0723697022f, 0.0374847986f}};
    mesh.triangles = {{0, 1, 2}, {1, 3, 4}};
    mesh.materials.resize(2, 0);
    const Judge judge(scene);
    const Ray ray{{0.090148218f, 0.185046241f, 0.212440282f}, 0.0f, {-0.156251907f, -0.113720343f, -0.175790191f}, 3.4e38f};
    ASSERT_EQ(judge.truth(ray).primitive, 1u);
    EXPECT_EQ(judge.judge(ray, {1.0f, 1.0f, 0.0f, 0}), HitClass::tie);
    EXPECT_EQ(judge.judge(ray, {1.001f, 1.0f, 0.0f, 0}), HitClass::wrong);
}

// Two triangles that lie side by side without sharing corners, as in a wall whose neighbour ends half-way: a ray at that
// edge may pass between them in floats. Where they share both corners it may not.
TEST(CompareHits, ACrackBetweenOpenEdgesIsATie) {
    const Ray ray{{19.5471687f, 12.1418629f, 22.0943356f}, 0.0f, {-7.54716873f, -10.1418629f, -22.778883f}, 3.4e38f};
    for (const bool shares : {false, true}) {
        Scene scene;
        scene.materials.resize(1);
        scene.instances.emplace_back();
        Mesh& mesh = scene.meshes.emplace_back();
        const float end = shares ? 2.0f : 1.99999952f;
        mesh.positions = {{12, 2.7f, -10}, {12, 2, 0},     {12, end, -10}, {12, 2, shares ? -10.0f : -1.205f},
                          {12, 0.8f, 0},   {11, -50, -50}, {11, 50, -50},  {11, 0, 80}};
        mesh.triangles = {{0, 1, 2}, {3, 1, 4}, {5, 6, 7}};
        mesh.materials.resize(3, 0);
        const Judge judge(scene);
        ASSERT_LT(judge.truth(ray).primitive, 2u);
        const float behind = (11.0f - ray.origin.x) / ray.direction.x;
        EXPECT_EQ(judge.judge(ray, {behind, 0.3f, 0.3f, 2}), shares ? HitClass::wrong : HitClass::tie);
        EXPECT_EQ(judge.judge(ray, {0.0f, 0.0f, 0.0f, NO_HIT}), HitClass::missed) << "there is a wall behind";
        EXPECT_EQ(judge.judge(ray, {1.01f * behind, 0.3f, 0.3f, 2}), HitClass::wrong);
    }
}

// A tracer that names the right triangle at a wrong distance is not right.
TEST(CompareHits, AWrongDistanceToTheRightTriangleShows) {
    const Judge judge(floors(4));
    const std::vector<Ray> rays{judge.down(0.3f, 0.4f), judge.down(0.6f, 0.7f)};
    std::vector<Hit> hits{judge.truth(rays[0]), judge.truth(rays[1])};
    hits[1].t *= 1.001f;
    const HitComparison got = compareHits(judge.tree, rays, hits);
    EXPECT_EQ(got.count(HitClass::same), 2u);
    EXPECT_NEAR(got.offset.max, 0.001 / 0x1p-20, 2.0) << "8 ULP of 1 are 2^-20";
}

TEST(CompareHits, PlantedFaultsAreFoundAndNamed) {
    const Judge judge(floors(4));
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int i = 0; i < 100; ++i) {
        rays.push_back(judge.down(0.003f + 0.0097f * i, 0.4f));
        hits.push_back(judge.truth(rays.back()));
    }
    rays.push_back(judge.down(20.0f, 0.0f));
    hits.push_back({1.0f, 0.1f, 0.1f, 5});  // beside all that there is
    hits[10] = Judge::nothing;
    hits[20].primitive = 32;  // the lower floor, through the upper one
    hits[20].t = 2.0f;
    hits[30].primitive ^= 8;  // a triangle elsewhere
    hits[40].t = NAN;
    hits[50].primitive = 34;  // there are 34: 0 to 33
    hits[60].t = -1.0f;
    const HitComparison got = compareHits(judge.tree, rays, hits);
    EXPECT_EQ(got.count(HitClass::missed), 1u);
    EXPECT_EQ(got.count(HitClass::phantom), 1u);
    EXPECT_EQ(got.count(HitClass::wrong), 5u);
    EXPECT_EQ(got.count(HitClass::same), rays.size() - 7);
    ASSERT_EQ(got.faults.size(), 7u);
    EXPECT_EQ(got.faults[0].ray, 10u);
    EXPECT_EQ(got.faults[0].kind, HitClass::missed);
    EXPECT_EQ(got.faults[6].ray, 100u);
    EXPECT_EQ(got.faults[6].kind, HitClass::phantom);
}

TEST(CompareHits, HolesAtInnerEdgesAndCornersAreNoTies) {
    const Judge judge(floors(4, vec3(0.0f), /* lower= */ false));
    for (const vec2& p : {vec2(0.25f, 0.1f), vec2(0.5f, 0.5f), vec2(0.3f, 0.3f), vec2(0.75f, 0.25f)})
        EXPECT_EQ(judge.judge(judge.down(p.x, p.y), Judge::nothing), HitClass::missed) << "a leak at " << p.x << ' ' << p.y;
    // Nor does it excuse one that there is something far below.
    const Judge both(floors(4));
    const Ray ray = both.down(0.5f, 0.5f);
    EXPECT_EQ(both.judge(ray, {2.0f, 0.5f, 0.5f, 32}), HitClass::wrong);
    EXPECT_EQ(both.judge(ray, Judge::nothing), HitClass::missed);
}

TEST(CompareHits, NeighboursAtASharedEdgeAreTies) {
    const Judge judge(floors(4));
    const float edge = 0.25f, above = std::nextafter(edge, 1.0f);
    for (const float x : {edge, above, std::nextafter(above, 1.0f)}) {
        const Ray ray = judge.down(x, 0.1f);
        for (const uint32_t neighbour : {0u, 3u}) {
            Hit answer = judge.truth(ray);
            answer.primitive = neighbour;
            const HitClass got = judge.judge(ray, answer);
            EXPECT_TRUE(got == HitClass::same || got == HitClass::tie) << x << ": " << neighbour;
        }
        Hit far = judge.truth(ray);
        far.primitive = 5;
        EXPECT_EQ(judge.judge(ray, far), HitClass::wrong);
    }
    // 8 ULP of 1, the largest coordinate here, are 2^-20.
    const Ray inside = judge.down(0.25f + 0x1p-19f, 0.1f);
    Hit answer = judge.truth(inside);
    answer.primitive = 0;
    EXPECT_EQ(judge.judge(inside, answer), HitClass::wrong) << "twice the tolerance beside the edge";
}

TEST(CompareHits, SilhouettesAreTiesBothWays) {
    const Judge alone(floors(1, vec3(0.0f), /* lower= */ false));
    EXPECT_EQ(alone.judge(alone.down(0.0f, 0.5f), Judge::nothing), HitClass::tie);
    EXPECT_EQ(alone.judge(alone.down(0x1p-21f, 0.5f), Judge::nothing), HitClass::tie);
    EXPECT_EQ(alone.judge(alone.down(0x1p-18f, 0.5f), Judge::nothing), HitClass::missed);
    EXPECT_EQ(alone.judge(alone.down(-0x1p-21f, 0.5f), {1.0f, 0.0f, 0.5f, 1}), HitClass::tie);
    EXPECT_EQ(alone.judge(alone.down(-0x1p-18f, 0.5f), {1.0f, 0.0f, 0.5f, 1}), HitClass::phantom);

    const Judge both(floors(1));  // 2 and 3 are the lower floor
    const Ray inside = both.down(0x1p-21f, 0.25f), outside = both.down(-0x1p-21f, 0.25f);
    const Hit upper = both.truth(inside), lower = both.truth(outside);
    ASSERT_LT(upper.primitive, 2u);
    ASSERT_GE(lower.primitive, 2u);
    EXPECT_EQ(both.judge(inside, lower), HitClass::tie);
    EXPECT_EQ(both.judge(outside, upper), HitClass::tie);
    EXPECT_EQ(both.judge(both.down(0x1p-18f, 0.25f), lower), HitClass::wrong);
    EXPECT_EQ(both.judge(both.down(-0x1p-18f, 0.25f), upper), HitClass::wrong);
}

TEST(CompareHits, SilhouettesOfSpheresAreTiesBothWays) {
    Scene scene = floors(1);  // ids 2 and 3: the lower floor
    scene.meshes[0].spheres = {{vec3(0.5f, 0.5f, 0.25f), 0.25f}};
    scene.meshes[0].materials.push_back(0);
    const Judge judge(scene);
    constexpr uint32_t sphere = 4;
    const auto at = [&](float offset) { return judge.down(0.75f + offset, 0.5f); };
    ASSERT_EQ(judge.truth(judge.down(0.5f, 0.5f)).primitive, sphere);
    ASSERT_EQ(judge.truth(at(-0x1p-21f)).primitive, sphere);
    const Hit beside = judge.truth(at(0x1p-21f)), upon = judge.truth(at(-0x1p-21f));
    ASSERT_LT(beside.primitive, 2u);
    EXPECT_EQ(judge.judge(at(-0x1p-21f), beside), HitClass::tie);
    EXPECT_EQ(judge.judge(at(0x1p-21f), upon), HitClass::tie);
    EXPECT_EQ(judge.judge(at(-0x1p-17f), beside), HitClass::wrong);
    EXPECT_EQ(judge.judge(at(0x1p-17f), upon), HitClass::wrong);
    EXPECT_EQ(judge.judge(judge.down(0.5f, 0.5f), Judge::nothing), HitClass::missed);
    Hit far = judge.truth(judge.down(0.5f, 0.5f));
    EXPECT_EQ(far.t, 0.5f);
    const HitComparison right = compareHits(judge.tree, std::vector{judge.down(0.5f, 0.5f)}, std::vector{far});
    EXPECT_EQ(right.offset.max, 0.0);
    far.t = 0.75f;  // the right sphere, and a wrong distance
    EXPECT_GT(compareHits(judge.tree, std::vector{judge.down(0.5f, 0.5f)}, std::vector{far}).offset.max, 1e4);
}

TEST(CompareHits, DuplicatesAreTies) {
    Scene scene = floors(1);
    scene.instances.push_back(scene.instances[0]);
    const Judge judge(scene);
    Hit answer = judge.truth(judge.down(0.3f, 0.1f));
    answer.primitive += 4;
    EXPECT_EQ(judge.judge(judge.down(0.3f, 0.1f), answer), HitClass::tie);
}

TEST(CompareHits, ToleranceGrowsWithTheCoordinates) {
    const vec3 far(4194304.0f, 0.0f, 0.0f);  // 2^22: floats are 1/2 apart, so the 8 ULP are 4
    const Judge judge(floors(1, far, /* lower= */ false));
    const Ray beside{far + vec3(3.5f, 0.5f, 1.0f), 0.0f, vec3(0, 0, -1), 3.4e38f};
    const Ray apart{far + vec3(8.0f, 0.5f, 1.0f), 0.0f, vec3(0, 0, -1), 3.4e38f};
    EXPECT_EQ(judge.judge(beside, {1.0f, 0.5f, 0.5f, 0}), HitClass::tie);
    EXPECT_EQ(judge.judge(apart, {1.0f, 0.5f, 0.5f, 0}), HitClass::phantom);
}

TEST(CompareHits, RaysThatCannotHitAreHeldToIt) {
    const Judge judge(floors(1));
    for (Ray ray : {Ray{vec3(NAN), 0, vec3(0, 0, -1), 9}, Ray{vec3(0.3f, 0.1f, 1), 0, vec3(0.0f), 9},
                    Ray{vec3(0.3f, 0.1f, 1), 2, vec3(0, 0, -1), 1}}) {
        EXPECT_EQ(judge.judge(ray, Judge::nothing), HitClass::same);
        const HitClass got = judge.judge(ray, {1.0f, 0.1f, 0.1f, 0});
        EXPECT_TRUE(got == HitClass::phantom || got == HitClass::wrong);
    }
}

TEST(CompareHits, DistancesAreCountedInFloats) {
    EXPECT_EQ(ulpsApart(1.0f, 1.0f), 0u);
    EXPECT_EQ(ulpsApart(0.0f, -0.0f), 0u);
    EXPECT_EQ(ulpsApart(1.0f, std::nextafter(1.0f, 2.0f)), 1u);
    EXPECT_EQ(ulpsApart(2.0f, 1.0f), 1u << 23);
    EXPECT_EQ(ulpsApart(-1e-45f, 1e-45f), 2u);

    const Judge judge(floors(4));
    std::vector<Ray> rays;
    std::vector<Hit> hits;
    for (int i = 0; i < 200; ++i) {
        rays.push_back(judge.down(0.003f + 0.0047f * i, 0.4f));
        hits.push_back(judge.truth(rays.back()));
    }
    hits[7].t = std::nextafter(std::nextafter(hits[7].t, 9.0f), 9.0f);
    const HitComparison got = compareHits(judge.tree, rays, hits);
    EXPECT_EQ(got.tUlp.median, 0.0);
    EXPECT_EQ(got.tUlp.p99, 0.0);
    EXPECT_EQ(got.tUlp.max, 2.0);
}

TEST(CompareSpread, TakesTheNearestRank) {
    std::vector<double> values;
    for (int i = 100; i >= 1; --i) values.push_back(i);
    const Spread spread = spreadOf(values);
    EXPECT_EQ(spread.median, 50.0);
    EXPECT_EQ(spread.p99, 99.0);
    EXPECT_EQ(spread.max, 100.0);
    EXPECT_EQ(spreadOf({}).max, 0.0);
    EXPECT_EQ(spreadOf({3.0}).median, 3.0);
}

/// A picture of the floors from above, with an edge of the upper one in view.
reference::Picture expectedPicture() {
    Scene scene = floors(2);
    scene.ambient = vec3(0.25f);
    Light light;
    light.position = vec3(0.5f, 0.5f, 2.0f);
    scene.lights = {light};
    Camera camera;
    camera.eye = vec3(0.9f, 0.5f, 2.0f);
    scene.cameras = {camera};
    const Geometry geometry = flatten(scene);
    const reference::World world(scene, geometry);
    reference::PictureOptions options;
    options.width = 48;
    options.height = 32;
    return reference::render(world, options);
}

TEST(ComparePictures, TheReferenceAgreesWithItself) {
    const reference::Picture expected = expectedPicture();
    const PictureComparison got = compareToReference(roundedImage(expected), expected);
    EXPECT_EQ(got.everywhere.max, 0.0);
    EXPECT_EQ(got.everywhere.nan, 0u);
    EXPECT_EQ(got.outsideTies.pixels + got.ties, 48u * 32u);
    EXPECT_LT(got.ties, 48u) << "few pixels are at the mercy of rounding";
}

// Black compared with black agrees exactly, and must be told apart from a picture that is right.
TEST(ComparePictures, BlankReferencesAreTold) {
    reference::Picture expected = expectedPicture();
    EXPECT_FALSE(compareToReference(roundedImage(expected), expected).blank);
    std::fill(expected.radiance.begin(), expected.radiance.end(), dvec3(0.0));
    EXPECT_TRUE(compareToReference(roundedImage(expected), expected).blank);
}

TEST(ComparePictures, OnlyTiesAreLeftOut) {
    reference::Picture expected = expectedPicture();
    std::fill(expected.sensitivity.begin(), expected.sensitivity.end(), 0.0);
    expected.sensitivity[100] = 0.5;
    expected.sensitivity[101] = 0.0009;
    Image picture = roundedImage(expected);
    picture.pixels[100] += 0.5f;
    const PictureComparison tied = compareToReference(picture, expected);
    EXPECT_EQ(tied.ties, 1u);
    EXPECT_EQ(tied.outsideTies.max, 0.0);
    EXPECT_NEAR(tied.everywhere.max, 0.5, 1e-6);
    picture.pixels[101].x += 0.5f;
    picture.pixels[102].x = NAN;
    const PictureComparison broken = compareToReference(picture, expected);
    EXPECT_NEAR(broken.outsideTies.max, 0.5, 1e-6);
    EXPECT_NEAR(broken.outsideTies.rmse, 0.5 / std::sqrt(3.0 * (48.0 * 32.0 - 2.0)), 1e-6);
    EXPECT_EQ(broken.outsideTies.nan, 1u);
}

}  // namespace
}  // namespace raig
