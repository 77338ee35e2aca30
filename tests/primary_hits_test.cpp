// What is seen first in each pixel: the same bits everywhere, and what the reference finds in double precision.
#include "measure/compare.hpp"
#include "support/devices.hpp"
#include "support/first_seen.hpp"
#include "support/leaves.hpp"

#include <cmath>
#include <filesystem>
#include <optional>

namespace raig {
namespace {

using namespace test;
namespace fs = std::filesystem;

/// Everything that AOVs tell of: texture coordinates, vertex colours, smooth normals, glass, mirrors, spheres, and meshes in
/// several places, one of them mirrored.
Scene furnishedRoom() {
    Scene scene = variedRoom();
    const uint32_t ball = addSphere(scene, {-1.2f, 1.0f, 0.5f}, 1.0f, 10, true, tintedGlass());
    const uint32_t block = addSphere(scene, {1.2f, 1.0f, -0.5f}, 1.0f, 6, false, metal(vec3(0.9f, 0.8f, 0.5f)));
    Material polished = matte(vec3(0.3f, 0.6f, 0.9f));
    polished.roughness = 0.1f;
    addTrueSphere(scene, {0.2f, 0.5f, 2.0f}, 0.5f, polished);
    dmat4 mirrored(1.0);
    mirrored[0] = dvec4(-0.8, 0, 0.1, 0);
    mirrored[1].y = 0.6;
    mirrored[3] = dvec4(1.6, 0.4, 2.2, 1);
    dmat4 moved(0.7);
    moved[3] = dvec4(-1.0, 0.8, -2.0, 1);
    for (const uint32_t mesh : {ball, block})
        for (const dmat4& place : {mirrored, moved}) scene.instances.push_back({mesh, place});
    return scene;
}

// ---- Against the reference ---------------------------------------------------------------------------------------------

double largest(const dvec3& v) {
    return std::max({std::abs(v.x), std::abs(v.y), std::abs(v.z)});
}

/// What a pixel may be off by: how far its point may lie from the reference's, in the surface, and how much normals,
/// coordinates and colours change with that.
struct Allowed {
    double slide = 0.0, normal = 2e-6, uv = 2e-6, albedo = 2e-6;
    double share = 0.0;  ///< of the triangle, so in barycentric coordinates
};

/// The point is off by positionTolerance across the surface, so by that over the cosine along it; a corner's values change
/// to another's over the triangle's least height.
Allowed allowedOf(const reference::World& world, const Ray& ray, uint32_t id, const reference::SurfacePoint& p) {
    const Geometry& g = world.geometry;
    Allowed allowed;
    const double cosine = std::abs(glm::dot(dvec3(ray.direction), p.normal));
    allowed.slide = 2.0 * positionTolerance(g, ray, id) / cosine;
    if (g.isSphere(id)) {
        allowed.normal += allowed.slide / g.sphere(id).radius;
        return allowed;
    }
    const uvec3 t = g.triangles[id];
    const dvec3 a = g.positions[t.x], b = g.positions[t.y], c = g.positions[t.z];
    const double longest = std::max({glm::length(b - a), glm::length(c - a), glm::length(c - b)});
    const double share = allowed.share = allowed.slide * longest / glm::length(glm::cross(b - a, c - a));
    const auto change = [&](const auto& values) {
        using Wide = std::conditional_t<std::is_same_v<std::decay_t<decltype(values[0])>, vec2>, dvec2, dvec3>;
        const Wide x = values[t.x], y = values[t.y], z = values[t.z];
        return share * (glm::length(y - x) + glm::length(z - x));
    };
    if (!g.normals.empty()) allowed.normal += 2.0 * change(g.normals);
    if (g.uvs.empty()) allowed.uv += 2.0 * share;
    if (!g.uvs.empty()) {
        allowed.uv += change(g.uvs);
        for (const vec2& uv : {g.uvs[t.x], g.uvs[t.y], g.uvs[t.z]})
            allowed.uv += 1e-6 * std::max(std::abs(uv.x), std::abs(uv.y));
    }
    if (!g.colors.empty()) allowed.albedo += change(g.colors);
    const auto& texture = world.scene.materials[g.materials[id]].baseColorTexture;
    if (texture && !g.uvs.empty()) {  // from one texel to the next, all can change
        const Texels& image = world.scene.images[texture->image];
        allowed.albedo += 2.0 * allowed.uv * std::max(image.width, image.height);
    }
    return allowed;
}

dvec3 albedoOf(const reference::SurfacePoint& p) {
    const reference::LocalSurface& s = p.surface;
    const dvec3 mirrored = (1.0 - s.metallic) * s.dielectric + s.metallic * s.metal;
    return s.transmits ? s.diffuse + s.transmission : mirrored + (1.0 - s.dielectric) * s.diffuse;
}

dvec2 uvOf(const Geometry& g, const reference::Hit& hit) {
    if (g.uvs.empty() || g.isSphere(hit.primitive)) return g.uvs.empty() ? dvec2(hit.u, hit.v) : dvec2(0.0);
    const uvec3 t = g.triangles[hit.primitive];
    return (1.0 - hit.u - hit.v) * dvec2(g.uvs[t.x]) + hit.u * dvec2(g.uvs[t.y]) + hit.v * dvec2(g.uvs[t.z]);
}

/// Holds every pixel against the reference, which traces the same rays.
class AgainstReference {
public:
    explicit AgainstReference(const Scene& s) : scene(s), flat(flatten(scene)), world(scene, flat) {}

    void expectAgreement(const PrimaryHits& got, const FrameOptions& options) {
        FrameOptions centre = options;
        centre.samples = 1;
        pixelSize = 2.0 * std::tan(0.5 * scene.cameras.at(options.camera).yfov) / options.height;
        const std::vector<Ray> rays = cameraRays(scene, centre);
        ASSERT_EQ(got.pixels.size(), rays.size());
        for (size_t i = 0; i < rays.size() && !testing::Test::HasFailure(); ++i) {
            EXPECT_EQ(got.pixels[i].pixel, i);
            expectPixel(got.pixels[i], rays[i], "pixel " + std::to_string(i));
        }
        EXPECT_GT(met, 0.5 * static_cast<double>(rays.size())) << "the scene is looked at";
        EXPECT_LE(ties, 1 + met / 100);
        EXPECT_LE(doubtful, met / 100);
        EXPECT_GT(tight, 0.8 * static_cast<double>(met)) << "mostly float accuracy is asked for";
    }

private:
    /// The first that the reference meets of what is there by half; none where rounding may decide whether something is.
    /// `ray` then starts behind what it has passed.
    std::optional<reference::Hit> firstThere(Ray& ray) const {
        const reference::Ray whole = widen(ray);
        reference::Ray rest = whole;
        uint32_t leaving = reference::noTriangle;
        for (uint32_t passed = 0; passed <= shared::MOST_PASSES; ++passed) {
            const reference::Hit hit = world.tree.closest(rest, leaving);
            if (hit.primitive == reference::noTriangle) return hit;
            const auto at = [&](double u, double v) {
                return reference::surfaceAt(world, whole, {hit.t, u, v, hit.primitive}, pixelSize * hit.t);
            };
            const reference::SurfacePoint p = at(hit.u, hit.v);
            const bool isThere = p.surface.coverage >= 0.5;
            const double off = allowedOf(world, ray, hit.primitive, p).share + 1e-6;
            for (const dvec2 aside : {dvec2(off, 0), dvec2(-off, 0), dvec2(0, off), dvec2(0, -off)})
                if ((at(hit.u + aside.x, hit.v + aside.y).surface.coverage >= 0.5) != isThere) return std::nullopt;
            if (isThere) return hit;
            leaving = hit.primitive;
            rest.tMin = std::nextafter(hit.t, INFINITY);
            ray.tMin = std::nextafter(static_cast<float>(hit.t), INFINITY);
        }
        return reference::Hit{};
    }

    void expectPixel(const PrimaryHit& got, Ray ray, const std::string& where) {
        const std::optional<reference::Hit> first = firstThere(ray);
        if (!first) {
            ++doubtful;
            return;
        }
        const reference::Hit want = *first;
        const bool none = got.primitive == NO_HIT;
        ASSERT_EQ(none, got.instance == NO_HIT) << where;
        ASSERT_EQ(none, got.material == NO_HIT) << where;
        ASSERT_EQ(none, std::isinf(got.depth)) << where;
        const uint32_t id = none ? NO_HIT : flat.firstTriangle.at(got.instance) + got.primitive;
        if (id != want.primitive) {
            const Hit hit{got.depth, 0.0f, 0.0f, id};
            ASSERT_EQ(classifyHit(world.tree, ray, want, hit), HitClass::tie) << where;
            ++ties;
            return;
        }
        if (none) {
            EXPECT_TRUE(got.position == vec3(0.0f) && got.normal == vec3(0.0f) && got.albedo == vec3(0.0f)) << where;
            return;
        }
        ++met;
        EXPECT_EQ(got.material, flat.materials[id]) << where;
        const reference::SurfacePoint p = reference::surfaceAt(world, widen(ray), want, pixelSize * want.t);
        const Allowed allowed = allowedOf(world, ray, id, p);
        tight += allowed.slide < 1e-4 * want.t;
        EXPECT_NEAR(got.depth, want.t, allowed.slide) << where;
        EXPECT_LE(largest(dvec3(got.position) - p.position), allowed.slide) << where;
        // Where the interpolated normal is seen edge-on, rounding decides whether it is taken: then either is right.
        const bool edgeOn = std::abs(glm::dot(dvec3(ray.direction), p.shadingNormal)) < 1e-4;
        if (!edgeOn) {
            EXPECT_LE(largest(dvec3(got.normal) - p.shadingNormal), allowed.normal) << where;
        }
        const dvec2 uv = uvOf(flat, want);
        EXPECT_NEAR(got.u, uv.x, allowed.uv) << where;
        EXPECT_NEAR(got.v, uv.y, allowed.uv) << where;
        EXPECT_LE(largest(dvec3(got.albedo) - albedoOf(p)), allowed.albedo) << where;
    }

    const Scene& scene;
    const Geometry flat;
    const reference::World world;
    double pixelSize = 0.0;  ///< at distance 1
    size_t met = 0, ties = 0, tight = 0, doubtful = 0;
};

TEST(PrimaryHits, AreThoseOfTheReferenceInTheSmallScenes) {
    for (const char* name : {"cornell_spheres.gltf", "cornell_box.gltf"}) {
        SCOPED_TRACE(name);
        const Stage stage(importScene(fs::path(RAIG_SOURCE_DIR) / "assets" / name));
        AgainstReference(stage.scene).expectAgreement(onCpu(stage, square(96, 1)), square(96, 1));
    }
}

TEST(PrimaryHits, AreThoseOfTheReferenceWithInstancesKeptAndWrittenOut) {
    const Stage written(furnishedRoom()), kept = Stage::kept(furnishedRoom());
    ASSERT_TRUE(kept.structure.isInstanced());
    const PrimaryHits hits = onCpu(kept, square(96, 1));
    AgainstReference(kept.scene).expectAgreement(hits, square(96, 1));
    EXPECT_TRUE(haveSameBits(hits, onCpu(written, square(96, 1))));
}

TEST(PrimaryHits, AreThoseOfTheReferenceAmongLeavesAndVeils) {
    const Stage stage(leafyScene());
    AgainstReference(stage.scene).expectAgreement(onCpu(stage, square(96, 1)), square(96, 1));
}

TEST(PrimaryHits, AreThoseOfTheReferenceInARealRoom) {
    const fs::path room = fs::path(RAIG_SOURCE_DIR) / "../shared/scenes/rooms/white_room.glb";
    if (!fs::exists(room)) GTEST_SKIP() << "the real scenes (../shared/scenes) are not here";
    const Stage stage(importScene(room));
    AgainstReference(stage.scene).expectAgreement(onCpu(stage, square(64, 1)), square(64, 1));
}

// Ids of different surfaces have no mean, so they may not depend on samples or tiles.
TEST(PrimaryHits, AreOfThePixelsCentreWhateverTheSamples) {
    const Stage stage(furnishedRoom());
    FrameOptions options = square(40, 1);
    const PrimaryHits one = onCpu(stage, options);
    options.samples = 16;
    options.seed = 7;
    EXPECT_TRUE(haveSameBits(onCpu(stage, options), one));
}

TEST(PrimaryHits, OfNothingAreInfinitelyFarAndHaveNoIds) {
    Scene scene;
    scene.materials.emplace_back();
    scene.cameras.emplace_back();
    for (const PrimaryHit& hit : onCpu(Stage(scene), square(9, 1)).pixels) {
        EXPECT_EQ(hit.depth, std::numeric_limits<float>::infinity());
        EXPECT_TRUE(hit.primitive == NO_HIT && hit.instance == NO_HIT && hit.material == NO_HIT);
        EXPECT_TRUE(hit.normal == vec3(0.0f) && hit.position == vec3(0.0f) && hit.u == 0.0f && hit.v == 0.0f);
    }
}

// ---- On devices --------------------------------------------------------------------------------------------------------

class PrimaryHitsOnDevice : public OnEveryDevice {};
INSTANTIATE_TEST_SUITE_P(Devices, PrimaryHitsOnDevice, testing::ValuesIn(devicesToTest()), testName);

// 300 x 300 pixels are more than one tile, and no multiple of one.
TEST_P(PrimaryHitsOnDevice, HaveTheCpusBits) {
    Device device(info);
    for (const bool keeps : {false, true}) {
        const Stage stage = keeps ? Stage::kept(furnishedRoom()) : Stage(furnishedRoom());
        const FrameOptions options = square(300, 1);
        EXPECT_TRUE(haveSameBits(onDevice(device, stage, options), onCpu(stage, options)))
            << (keeps ? "kept" : "written out");
    }
}

}  // namespace
}  // namespace raig
