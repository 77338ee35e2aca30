// The double-precision reference against what needs no reference: closed forms, exact counts, and trying every triangle.
#include "base/parallel.hpp"
#include "reference/optics.hpp"
#include "reference/picture.hpp"
#include "reference/sampling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <random>
#include <set>

namespace raig::reference {
namespace {

constexpr double pi = 3.14159265358979323846;

/// A scene put together triangle by triangle.
struct Builder {
    Scene scene;

    Builder() { scene.meshes.emplace_back(); }

    uint32_t material(const Material& m) {
        scene.materials.push_back(m);
        return static_cast<uint32_t>(scene.materials.size() - 1);
    }

    void triangle(const vec3& a, const vec3& b, const vec3& c, uint32_t material = 0) {
        Mesh& mesh = scene.meshes[0];
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.materials.push_back(material);
    }

    /// The parallelogram corner + [0, 1] u + [0, 1] v, its front towards u x v.
    void quad(const vec3& corner, const vec3& u, const vec3& v, uint32_t material = 0) {
        triangle(corner, corner + u, corner + u + v, material);
        triangle(corner, corner + u + v, corner + v, material);
    }
};

/// The scene, kept where the world expects it.
struct Made {
    explicit Made(Scene s) : scene(std::move(s)), geometry(flatten(withDefaults(scene))), world(scene, geometry) {}

    static const Scene& withDefaults(Scene& scene) {
        if (scene.materials.empty()) scene.materials.emplace_back();
        if (scene.instances.empty() && !scene.meshes.empty()) scene.instances.emplace_back();
        return scene;
    }

    Scene scene;
    Geometry geometry;
    World world;
};

Material white() {
    Material m;
    m.baseColor = vec3(1.0f);
    return m;
}

Material lamp(float radiance) {
    Material m;
    m.baseColor = vec3(0.0f);
    m.emission = vec3(radiance);
    return m;
}

Material clear(float ior, bool thin = false) {
    Material m;
    m.baseColor = vec3(1.0f);
    m.roughness = 0.0f;
    m.transmission = 1.0f;
    m.ior = ior;
    m.thin = thin;
    return m;
}

Ray rayTo(const dvec3& origin, const dvec3& target) {
    return {origin, glm::normalize(target - origin)};
}

Bounds bounds(uint32_t maxDepth, float minContribution = 0.0f) {
    return {maxDepth, minContribution, /* seed= */ 0};
}

Hit bruteForce(const Geometry& geometry, const Ray& ray) {
    Hit best;
    best.t = ray.tMax;
    for (uint32_t id = 0; id < geometry.triangles.size(); ++id) {
        const uvec3 t = geometry.triangles[id];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (!raig::isUsable(a, b, c)) continue;
        const auto crossing = cross(ray, a, b, c);
        if (!crossing || crossing->t < ray.tMin || crossing->t > best.t) continue;
        if (crossing->t < best.t || best.primitive == noTriangle) best = {crossing->t, crossing->u, crossing->v, id};
    }
    return best.primitive == noTriangle ? Hit{} : best;
}

// ---- Sampling numbers --------------------------------------------------------------------------------------------------

// The table was computed apart from this code, the Sobol matrix as Pascal's triangle modulo 2.
TEST(ReferenceSampling, NumbersAreAsDefined) {
    EXPECT_EQ(hash(0), 0x07bb2fe2u);
    EXPECT_EQ(hash(1), 0xa8beea3cu);
    EXPECT_EQ(hash(0xffffffffu), 0xe62a4902u);
    EXPECT_EQ(hash(3, 5), 0x5e2b14a2u);
    EXPECT_EQ(scramble(0, 0x12345678), 0x1679d7f6u);
    EXPECT_EQ(scramble(0x80000000u, 0x12345678), 0x87e32b06u);
    EXPECT_EQ(sobol(7, 1), 0xe0000000u);
    EXPECT_EQ(sobol(0xdeadbeefu, 1), 0x0c66ae4du);
    EXPECT_EQ(sample2(0, 0, 0, 0), 0x1p-24 * dvec2(9976068, 11330730));
    EXPECT_EQ(sample2(1, 2, 3, 4), 0x1p-24 * dvec2(2880132, 5227808));
    EXPECT_EQ(sample2(65535, 1000, 7, 1), 0x1p-24 * dvec2(2444910, 6125215));
    EXPECT_EQ(sample2(123456, 65535, 0xfffffffeu, 0), 0x1p-24 * dvec2(9986293, 11180683));
}

TEST(ReferenceSampling, EveryAlignedBlockFillsEveryElementaryBoxOnce) {
    for (const uint32_t pixel : {0u, 77u, 1u << 20})
        for (uint32_t m = 0; m <= 8; ++m)
            for (const uint32_t block : {0u, 1u, 5u})
                for (uint32_t a = 0; a <= m; ++a) {
                    std::set<std::pair<uint32_t, uint32_t>> boxes;
                    for (uint32_t i = 0; i < 1u << m; ++i) {
                        const dvec2 p = sample2(pixel, (block << m) + i, 2, 9);
                        boxes.emplace(static_cast<uint32_t>(p.x * (1u << a)), static_cast<uint32_t>(p.y * (1u << (m - a))));
                    }
                    ASSERT_EQ(boxes.size(), size_t{1} << m) << "pixel " << pixel << " block " << block << " of 2^" << m;
                }
}

// ---- The closest hit ---------------------------------------------------------------------------------------------------

/// Triangles of all sizes, slivers, duplicates, and some that cannot be used, around `centre`.
Scene soup(uint32_t count, const vec3& centre, uint32_t seed) {
    Builder builder;
    std::mt19937 random(seed);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    const auto point = [&](float size) { return size * vec3(unit(random), unit(random), unit(random)); };
    for (uint32_t i = 0; i < count; ++i) {
        const vec3 a = centre + point(1.0f);
        const float size = std::exp2(4.0f * unit(random) - 4.0f);
        const vec3 b = a + point(size), c = i % 7 == 0 ? b + point(1e-6f) : a + point(size);
        builder.triangle(a, b, i % 50 == 0 ? a : c);
        if (i % 10 == 0) builder.triangle(a, b, c);
    }
    builder.triangle(vec3(NAN), vec3(1.0f), vec3(0.0f, 1.0f, 0.0f));
    return builder.scene;
}

TEST(ReferenceHit, TreeFindsWhatTryingEveryTriangleFinds) {
    std::mt19937 random(3);
    std::uniform_real_distribution<double> unit(-1.0, 1.0);
    for (const vec3& centre : {vec3(0.0f), vec3(1e6f, -2e5f, 3e3f)}) {
        const Made made(soup(700, centre, 11));
        std::vector<Ray> rays;
        const auto point = [&] { return dvec3(centre) + 1.5 * dvec3(unit(random), unit(random), unit(random)); };
        for (int i = 0; i < 2000; ++i) {
            rays.push_back(rayTo(point(), point()));
            dvec3 axis(0.0);
            axis[i % 3] = i % 2 ? 1.0 : -1.0;
            rays.push_back({vec3(point()), axis});
            const uvec3 t = made.geometry.triangles[random() % made.geometry.triangles.size()];
            const dvec3 a = made.geometry.positions[t.x], b = made.geometry.positions[t.y];
            if (!isFinite(vec3(a))) continue;
            const dvec3 eye = vec3(point());
            rays.push_back({eye, vec3(a - eye)});
            rays.push_back({eye, vec3(0.5 * (a + b) - eye), 0.5, 1.0});
        }
        const std::vector<Hit> hits = closest(made.world.tree, rays);
        size_t found = 0;
        parallelFor(rays.size(), 64, [&](size_t begin, size_t end) {
            for (size_t i = begin; i < end; ++i) {
                EXPECT_EQ(hits[i], bruteForce(made.geometry, rays[i])) << "ray " << i;
                EXPECT_EQ(made.world.tree.blocked(rays[i], {}), hits[i].primitive != noTriangle) << "ray " << i;
            }
        });
        for (const Hit& hit : hits) found += hit.primitive != noTriangle;
        EXPECT_GT(found, rays.size() / 4) << "the rays test little";
    }
}

/// A closed sphere of float corners.
Scene sphere(uint32_t rings, float radius, const vec3& centre) {
    Builder builder;
    const uint32_t around = 2 * rings;
    const auto point = [&](uint32_t ring, uint32_t step) {
        const double theta = pi * ring / rings, phi = 2.0 * pi * (step % around) / around;
        if (ring == 0 || ring == rings) return centre + radius * vec3(0.0f, ring == 0 ? 1.0f : -1.0f, 0.0f);
        return centre + radius * vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    };
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t step = 0; step < around; ++step) {
            if (ring > 0) builder.triangle(point(ring, step), point(ring, step + 1), point(ring + 1, step));
            if (ring + 1 < rings) builder.triangle(point(ring, step + 1), point(ring + 1, step + 1), point(ring + 1, step));
        }
    return builder.scene;
}

TEST(ReferenceHit, ClosedMeshesDoNotLeakAtCornersAndEdges) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    for (const vec3& centre : {vec3(0.0f), vec3(148376.0f, 1234.0f, -223423.0f)}) {
        const Made made(sphere(24, 2.0f, centre));
        size_t leaks = 0;
        for (int i = 0; i < 20000; ++i) {
            const uvec3 t = made.geometry.triangles[random() % made.geometry.triangles.size()];
            const vec3 a = made.geometry.positions[t.x], b = made.geometry.positions[t.y];
            const vec3 eye = centre + 0.5f * vec3(unit(random), unit(random), unit(random));
            const float along = i % 2 ? 0.0f : 0.5f + 0.5f * unit(random);
            const Ray ray{eye, a + along * (b - a) - eye};
            leaks += made.world.tree.closest(ray).primitive == noTriangle;
        }
        EXPECT_EQ(leaks, 0u);
    }
}

TEST(ReferenceHit, UnusableRaysHitNothing) {
    Builder builder;
    builder.quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0));
    const Made made(builder.scene);
    const dvec3 o(0.1, 0.2, 1.0), d(0.0, 0.0, -1.0);
    EXPECT_EQ(made.world.tree.closest({o, d}).t, 1.0);
    EXPECT_EQ(made.world.tree.closest({o, d, 0.0, 1.0}).t, 1.0) << "tMax is part of the ray";
    EXPECT_EQ(made.world.tree.closest({o, d, 1.0, 2.0}).t, 1.0) << "tMin is part of the ray";
    for (const Ray& ray : {Ray{o, dvec3(0.0)}, Ray{o, dvec3(0, 0, NAN)}, Ray{dvec3(INFINITY, 0, 0), d}, Ray{o, d, 2.0, 0.0},
                           Ray{o, d, NAN, 3.0}, Ray{o, dvec3(1, 0, 0)}})
        EXPECT_EQ(made.world.tree.closest(ray), Hit{});
    EXPECT_EQ(Made(Scene{}).world.tree.closest({o, d}), Hit{}) << "the empty scene";
}

TEST(ReferenceHit, EqualDistancesGoToTheLowestId) {
    Builder builder;
    for (int i = 0; i < 100; ++i) builder.triangle(vec3(-1, -1, 0), vec3(1, -1, 0), vec3(0, 1, 0));
    EXPECT_EQ(Made(builder.scene).world.tree.closest({dvec3(0, 0, 1), dvec3(0, 0, -1)}).primitive, 0u);
}

TEST(ReferenceTriangle, NearestPointsAreNearest) {
    const vec3 a(0, 0, 0), b(2, 0, 0), c(0, 2, 0);
    EXPECT_NEAR(approach({dvec3(3, 0, 5), dvec3(0, 0, -1)}, a, b, c).distance, 1.0, 1e-15);
    EXPECT_NEAR(approach({dvec3(3, 0, 5), dvec3(0, 0, -1)}, a, b, c).t, 5.0, 1e-15);
    EXPECT_NEAR(approach({dvec3(2, 2, 5), dvec3(0, 0, -2)}, a, b, c).distance, std::sqrt(2.0), 1e-15);
    EXPECT_EQ(approach({dvec3(0.5, 0.5, 5), dvec3(0, 0, -2)}, a, b, c).distance, 0.0);
    EXPECT_EQ(approach({dvec3(0.5, 0.5, 5), dvec3(0, 0, -2), 0.0, 1.0}, a, b, c).distance, 3.0) << "ends before it";
    EXPECT_EQ(approach({dvec3(0.5, 0.5, 5), dvec3(0, 0, 1)}, a, b, c).distance, 5.0) << "points away";
    EXPECT_NEAR(distanceToTriangle(dvec3(-3, -4, 0), a, b, c), 5.0, 1e-15);
    EXPECT_NEAR(distanceToTriangle(dvec3(0.5, 0.5, -7), a, b, c), 7.0, 1e-15);
}

// ---- Optics ------------------------------------------------------------------------------------------------------------

TEST(ReferenceOptics, FresnelMatchesItsSpecialAngles) {
    const double n = 1.5;
    EXPECT_NEAR(fresnel(1.0, 1.0, n), 0.04, 1e-15);
    EXPECT_NEAR(fresnel(0.0, 1.0, n), 1.0, 1e-15);
    // At Brewster's angle, tan = n, light polarised in the plane of incidence is not reflected at all.
    const double senkrecht = (1.0 - n * n) / (1.0 + n * n);
    EXPECT_NEAR(fresnel(std::cos(std::atan(n)), 1.0, n), 0.5 * senkrecht * senkrecht, 1e-15);
    for (const double cosI : {0.1, 0.35, 0.8, 0.99}) {
        const double cosT = std::sqrt(1.0 - (1.0 - cosI * cosI) / (n * n));
        EXPECT_NEAR(fresnel(cosI, 1.0, n), fresnel(cosT, n, 1.0), 1e-14) << "the same from both sides";
        EXPECT_EQ(fresnel(cosI, 1.3, 1.3), 0.0);
    }
    const double critical = std::sqrt(1.0 - 1.0 / (n * n));
    EXPECT_EQ(fresnel(critical * 0.999, n, 1.0), 1.0);
    EXPECT_LT(fresnel(critical * 1.001, n, 1.0), 1.0);
    EXPECT_FALSE(refract(dvec3(std::sqrt(0.75), 0.0, -0.5), dvec3(0, 0, 1), n));
}

// A slab of glass over a floor whose colour tells where it is met: the ray leaves parallel, moved by Snell's law.
TEST(ReferenceOptics, SlabsShiftRaysBySnellsLaw) {
    for (const double degrees : {0.0, 20.0, 45.0, 70.0}) {
        Builder builder;
        const uint32_t glass = builder.material(clear(1.5f)), floor = builder.material(white());
        builder.quad(vec3(-9, 2, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
        builder.quad(vec3(-9, 1, -9), vec3(18, 0, 0), vec3(0, 0, 18), glass);
        builder.quad(vec3(-8, 0, 8), vec3(16, 0, 0), vec3(0, 0, -16), floor);
        for (const vec3& p : builder.scene.meshes[0].positions) builder.scene.meshes[0].colors.emplace_back((p.x + 9) / 18);
        builder.scene.ambient = vec3(1.0f);
        const Made made(builder.scene);
        const double angle = degrees * pi / 180.0, inside = std::asin(std::sin(angle) / 1.5);
        const double through = 1.0 - fresnel(std::cos(angle), 1.0, 1.5);
        const double x = -5.0 + 2.0 * std::tan(angle) + std::tan(inside);  // 1 above, 1 inside, 1 below
        const Ray ray{dvec3(-5, 3, 0.3), dvec3(std::sin(angle), -std::cos(angle), 0.0)};
        // The glass is tinted by the vertex colours where the ray enters and leaves.
        const double enter = (-5.0 + std::tan(angle) + 9) / 18, leave = (-5.0 + std::tan(angle) + std::tan(inside) + 9) / 18;
        const double want = through * through * enter * leave * (x + 9) / 18;
        EXPECT_NEAR(traceRay(made.world, ray, bounds(2), {}).value.x, want, 1e-6 * want) << degrees << " degrees";
    }
}

TEST(ReferenceOptics, NothingPassesBeyondTheCriticalAngle) {
    Builder builder;
    const uint32_t glass = builder.material(clear(1.5f)), ceiling = builder.material(lamp(3.0f));
    builder.quad(vec3(-9, 1, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
    builder.quad(vec3(-9, -2, 9), vec3(18, 0, 0), vec3(0, 0, -18), ceiling);
    builder.scene.sky = {vec3(100.0f), vec3(100.0f), vec3(100.0f)};
    const Made made(builder.scene);
    for (const double degrees : {42.0, 60.0, 75.0}) {
        const double angle = degrees * pi / 180.0;
        const Radiance got =
            traceRay(made.world, {dvec3(-8, 0, 0), dvec3(std::sin(angle), std::cos(angle), 0.0)}, bounds(1), {});
        EXPECT_EQ(got.value, dvec3(3.0)) << degrees << " degrees: the emitting floor, mirrored whole";
        EXPECT_EQ(got.discarded, 0.0);
    }
}

TEST(ReferenceOptics, LightFadesByTheLengthInside) {
    Material tinted = clear(1.0f);
    tinted.attenuationColor = vec3(0.5f, 0.25f, 0.9f);
    tinted.attenuationDistance = 2.0f;
    Builder builder;
    const uint32_t glass = builder.material(tinted);
    builder.quad(vec3(-9, 3, 9), vec3(18, 0, 0), vec3(0, 0, -18), glass);
    builder.quad(vec3(-9, 0, -9), vec3(18, 0, 0), vec3(0, 0, 18), glass);
    builder.scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Made made(builder.scene);
    for (const double degrees : {0.0, 30.0, 60.0}) {
        const double angle = degrees * pi / 180.0, length = 3.0 / std::cos(angle);
        const dvec3 got =
            traceRay(made.world, {dvec3(-2, 5, 0.1), dvec3(std::sin(angle), -std::cos(angle), 0.0)}, bounds(2), {}).value;
        const dvec3 want = glm::pow(dvec3(tinted.attenuationColor), dvec3(length / 2.0));
        for (int i = 0; i < 3; ++i) EXPECT_NEAR(got[i], want[i], 1e-6) << degrees << " degrees";
    }
}

// ---- The recursion -----------------------------------------------------------------------------------------------------

// Radiance e + K e + K^2 e + ... between two mirrors that glow; what the depth cuts off is bounded by the discarded weight.
TEST(ReferenceRecursion, FacingMirrorsSumTheGeometricSeries) {
    for (const float k : {0.5f, 0.9f, 0.98f}) {
        Material mirror = lamp(1.0f);
        mirror.baseColor = vec3(k);
        mirror.metallic = 1.0f;
        mirror.roughness = 0.0f;
        Builder builder;
        builder.material(mirror);
        builder.quad(vec3(-9, -9, -1), vec3(18, 0, 0), vec3(0, 18, 0));
        builder.quad(vec3(-9, -9, 1), vec3(0, 18, 0), vec3(18, 0, 0));
        const Made made(builder.scene);
        for (const uint32_t depth : {0u, 1u, 3u, 8u, 30u}) {
            const Radiance got = traceRay(made.world, {dvec3(0.1, 0.2, 0), dvec3(0, 0, -1)}, bounds(depth), {});
            const double left = std::pow(double{k}, depth + 1.0);
            EXPECT_NEAR(got.value.x, (1.0 - left) / (1.0 - k), 1e-12) << k << " to depth " << depth;
            EXPECT_NEAR(got.discarded, left, 1e-13);
            EXPECT_NEAR(1.0 / (1.0 - k) - got.value.x, got.discarded * (1.0 / (1.0 - k)), 1e-11)
                << "the bound is met exactly";
        }
        const Radiance cut = traceRay(made.world, {dvec3(0.1, 0.2, 0), dvec3(0, 0, -1)}, bounds(1000, 0.1f), {});
        EXPECT_LT(cut.discarded, 0.1);
        EXPECT_GE(cut.discarded, 0.1 * k);
    }
}

TEST(ReferenceRecursion, WhatIsNotThereShowsTheSky) {
    Scene scene;
    scene.sky = {vec3(1, 0, 0), vec3(0, 1, 0), vec3(0, 0, 1)};
    const Made made(scene);
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0, 1, 0)}, bounds(8), {}).value, dvec3(1, 0, 0));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(1, 0, 0)}, bounds(8), {}).value, dvec3(0, 1, 0));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0, -1, 0)}, bounds(8), {}).value, dvec3(0, 0, 1));
    EXPECT_EQ(traceRay(made.world, {dvec3(0.0), dvec3(0.8, 0.6, 0)}, bounds(8), {}).value, dvec3(0.6, 0.4, 0));
}

TEST(ReferenceRecursion, AWhiteSceneInWhiteLightIsWhite) {
    Builder builder;
    builder.material(white());
    builder.quad(vec3(-1, -1, 0), vec3(2, 0, 0), vec3(0, 2, 0));
    builder.scene.ambient = vec3(1.0f);
    const Made made(builder.scene);
    EXPECT_EQ(traceRay(made.world, rayTo(dvec3(0.3, 2, 3), dvec3(0.1, 0.1, 0)), bounds(8), {}).value, dvec3(1.0));
    // Glass in a white environment loses nothing but what is cut off, and that is told.
    Builder glass;
    glass.material(clear(1.5f));
    glass.scene = sphere(16, 1.0f, vec3(0.0f));
    glass.scene.materials = {clear(1.5f)};
    glass.scene.sky = {vec3(1.0f), vec3(1.0f), vec3(1.0f)};
    const Made ball(glass.scene);
    for (const dvec3& target : {dvec3(0.0), dvec3(0.3, 0.1, 0), dvec3(0.9, 0.2, 0.1)}) {
        const Radiance got = traceRay(ball.world, rayTo(dvec3(0.2, 0.5, 5), target), bounds(8), {});
        EXPECT_NEAR(got.value.x + got.discarded, 1.0, 1e-12);
        EXPECT_LT(got.discarded, 0.1);
    }
}

// ---- Lights ------------------------------------------------------------------------------------------------------------

/// What a rectangle of sides x and y, its corner h above the point and parallel to the floor, sends there as a share of pi
/// times its radiance. Source: Howell 2010, "A Catalog of Radiation Heat Transfer Configuration Factors", B-4.
double configurationFactor(double x, double y, double h) {
    const double a = x / h, b = y / h, ra = std::sqrt(1.0 + a * a), rb = std::sqrt(1.0 + b * b);
    return (a / ra * std::atan(b / ra) + b / rb * std::atan(a / rb)) / (2.0 * pi);
}

TEST(ReferenceLights, ASquareLampLightsTheFloorAsItsFormulaSays) {
    Builder builder;
    const uint32_t floor = builder.material(white()), bright = builder.material(lamp(4.0f));
    builder.quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18), floor);
    builder.quad(vec3(0, 2, 0), vec3(1, 0, 0), vec3(0, 0, 1), bright);
    const Made made(builder.scene);
    // The floor's points p at x, z <= 0: the lamp is the difference of rectangles with a corner above p.
    for (const dvec2& p : {dvec2(0.0, 0.0), dvec2(-0.5, 0.0), dvec2(-1.0, -2.0), dvec2(-3.0, -0.25)}) {
        const auto factor = [&](double x, double z) { return configurationFactor(x, z, 2.0); };
        const double x0 = -p.x, x1 = 1.0 - p.x, z0 = -p.y, z1 = 1.0 - p.y;
        const double want = 4.0 * (factor(x1, z1) - factor(x0, z1) - factor(x1, z0) + factor(x0, z0));
        // Different pixels are independent, the samples of one are not.
        constexpr uint32_t count = 40000;
        double sum = 0.0, squares = 0.0;
        for (uint32_t pixel = 0; pixel < count; ++pixel) {
            const Ray ray = rayTo(dvec3(p.x - 1.0, 1.0, p.y - 1.0), dvec3(p.x, 0.0, p.y));
            const double value = traceRay(made.world, ray, bounds(0), {pixel, 0}).value.x;
            sum += value;
            squares += value * value;
        }
        const double mean = sum / count, deviation = std::sqrt((squares / count - mean * mean) / count);
        EXPECT_NEAR(mean, want, 3.9 * deviation) << "p < 1e-4 at (" << p.x << ", " << p.y << ")";
        EXPECT_LT(deviation, 0.01 * want) << "the test could not tell";
    }
}

TEST(ReferenceLights, PointSpotAndSunFollowTheirLaws) {
    Light light;
    light.position = vec3(0, 2, 0);
    light.intensity = vec3(8.0f);
    const dvec3 up(0, 1, 0);
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0, 1e-15);
    EXPECT_NEAR(arriving(light, dvec3(2, 0, 0), up).irradiance.x, 8.0 / 8.0 * std::sqrt(0.5), 1e-15);
    light.range = 4.0f;
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0 * (1.0 - 1.0 / 16.0), 1e-15);
    light.range = 1.9f;
    EXPECT_EQ(arriving(light, dvec3(0.0), up).irradiance.x, 0.0);

    light.range = 0.0f;
    light.type = Light::Type::spot;
    light.direction = vec3(0, -1, 0);
    light.innerConeAngle = 0.0f;
    light.outerConeAngle = static_cast<float>(pi / 3.0);
    EXPECT_NEAR(arriving(light, dvec3(0.0), up).irradiance.x, 2.0, 1e-15);
    const double ramp = (std::sqrt(0.5) - 0.5) / 0.5;
    EXPECT_NEAR(arriving(light, dvec3(2, 0, 0), up).irradiance.x, std::sqrt(0.5) * ramp * ramp, 1e-7);
    EXPECT_EQ(arriving(light, dvec3(4, 0, 0), up).irradiance.x, 0.0);

    light.type = Light::Type::directional;
    light.direction = vec3(0.6f, -0.8f, 0);
    EXPECT_NEAR(arriving(light, dvec3(5, 5, 5), up).irradiance.x, 6.4, 1e-6);
}

TEST(ReferenceLights, OpaqueThingsCastShadowsAndClearOnesDoNot) {
    for (const bool opaque : {true, false}) {
        Builder builder;
        const uint32_t floor = builder.material(white()), between = builder.material(opaque ? white() : clear(1.5f, true));
        builder.quad(vec3(-9, 0, 9), vec3(18, 0, 0), vec3(0, 0, -18), floor);
        builder.quad(vec3(-1, 1, 1), vec3(2, 0, 0), vec3(0, 0, -2), between);
        Light light;
        light.position = vec3(0, 2, 0);
        light.intensity = vec3(static_cast<float>(pi));
        builder.scene.lights = {light};
        const Made made(builder.scene);
        const auto seen = [&](const dvec3& p) {
            return traceRay(made.world, rayTo(p + dvec3(0, 0.5, 0), p), bounds(0), {}).value.x;
        };
        EXPECT_NEAR(seen(dvec3(0.0)), opaque ? 0.0 : 0.25, 1e-7);
        EXPECT_NEAR(seen(dvec3(3, 0, 0)), std::pow(13.0, -1.5) * 2.0, 1e-7) << "outside the shadow";
    }
}

// ---- Textures, cameras, pictures -----------------------------------------------------------------------------------------

TEST(ReferenceTexture, IsBilinearAndWraps) {
    Scene scene;
    Texels image{2, 1, {0, 0, 0, 255, 255, 255, 255, 0}};
    scene.images = {image};
    const Made made(scene);
    const auto red = [&](double u, Wrap wrap) { return textureColour(made.world, {0, wrap, wrap}, {u, 0.5}).x; };
    for (const Wrap wrap : {Wrap::repeat, Wrap::clamp, Wrap::mirror}) {
        EXPECT_EQ(red(0.25, wrap), 0.0);
        EXPECT_EQ(red(0.75, wrap), 1.0);
        EXPECT_NEAR(red(0.4, wrap), 0.3, 1e-15);
    }
    EXPECT_NEAR(red(1.0, Wrap::repeat), 0.5, 1e-15);
    EXPECT_NEAR(red(1.0, Wrap::clamp), 1.0, 1e-15);
    EXPECT_NEAR(red(1.25, Wrap::mirror), 1.0, 1e-15);
    EXPECT_NEAR(red(1.25, Wrap::repeat), 0.0, 1e-15);
    EXPECT_NEAR(red(-0.25, Wrap::repeat), 1.0, 1e-15);
    EXPECT_NEAR(red(-0.25, Wrap::mirror), 0.0, 1e-15);
    EXPECT_NEAR(red(-1e9 + 0.25, Wrap::repeat), 0.0, 1e-15);
    EXPECT_NEAR(made.world.linear[188], 0.5, 0.005);
}

TEST(ReferencePicture, CameraRaysSpanTheFrame) {
    Camera camera;
    camera.yfov = static_cast<float>(pi / 2.0);
    PictureOptions options;
    options.width = 4;
    options.height = 2;
    const dvec3 d = cameraRay(camera, options, 3, 0, 0).direction;
    EXPECT_NEAR(d.x / -d.z, 1.5, 1e-7);
    EXPECT_NEAR(d.y / -d.z, 0.5, 1e-7);
    camera.orthographic = true;
    camera.xmag = camera.ymag = 3.0f;
    EXPECT_EQ(cameraRay(camera, options, 3, 0, 0).origin, dvec3(4.5, 1.5, 1.0)) << "the wider picture sees more, not less";
}

// The left half of the picture is an emitter whose edge runs through the centres of a column of pixels.
TEST(ReferencePicture, OnlyPixelsThatRoundingCanChangeAreSensitive) {
    Builder builder;
    builder.material(lamp(1.0f));
    builder.quad(vec3(-5, -5, 0), vec3(5, 0, 0), vec3(0, 10, 0));
    Camera camera;
    camera.orthographic = true;
    builder.scene.cameras = {camera};
    const Made made(builder.scene);
    PictureOptions options;
    options.width = options.height = 9;
    const Picture picture = render(made.world, options);
    for (uint32_t i = 0; i < 81; ++i) {
        const uint32_t x = i % 9;
        EXPECT_EQ(picture.sensitivity[i], x == 4 ? 1.0 : 0.0) << "pixel " << i;
        if (x != 4) {
            EXPECT_EQ(picture.radiance[i].x, x < 4 ? 1.0 : 0.0);
        }
    }
    // 1e-4 of a pixel beside the edge, rounding changes nothing.
    builder.scene.cameras[0].eye.x = 2.0f / 9.0f * 1e-4f;
    const Picture beside = render(Made(builder.scene).world, options);
    EXPECT_EQ(*std::max_element(beside.sensitivity.begin(), beside.sensitivity.end()), 0.0);
}

TEST(ReferencePicture, IsTheSameEveryTime) {
    Scene scene = sphere(12, 1.0f, vec3(0.0f));
    scene.materials = {clear(1.5f)};
    Light sun;
    sun.type = Light::Type::directional;
    scene.lights = {sun};
    scene.sky = {vec3(0.2f, 0.4f, 1.0f), vec3(1.0f), vec3(0.1f)};
    Camera camera;
    camera.eye = vec3(0, 0, 4);
    scene.cameras = {camera};
    const Made made(scene);
    PictureOptions options;
    options.width = 33;
    options.height = 17;
    options.samples = 3;
    double last = 0.0;
    const Picture first = render(made.world, options, [&](double done) {
        EXPECT_GT(done, last);
        last = done;
    });
    const Picture second = render(made.world, options);
    EXPECT_EQ(last, 1.0);
    EXPECT_EQ(first.radiance, second.radiance);
    EXPECT_EQ(first.sensitivity, second.sensitivity);
    EXPECT_EQ(first.discarded, second.discarded);
}

}  // namespace
}  // namespace raig::reference
