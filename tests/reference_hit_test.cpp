// The double-precision reference, from sampling numbers to the closest hit, against counts, and trying every triangle.
#include "base/parallel.hpp"
#include "reference/sampling.hpp"
#include "support/reference_scenes.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

namespace raig::reference {
namespace {

using namespace test;

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

TEST(ReferenceHit, ClosedMeshesDoNotLeakAtCornersAndEdges) {
    std::mt19937 random(5);
    std::uniform_real_distribution<float> unit(-1.0f, 1.0f);
    for (const vec3& centre : {vec3(0.0f), vec3(148376.0f, 1234.0f, -223423.0f)}) {
        const Made made(closedSphere(24, 2.0f, centre));
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

}  // namespace
}  // namespace raig::reference
