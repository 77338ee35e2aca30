// Shading, part by part: sampling numbers, Fresnel, refraction, absorption, normals and spawned rays.
#include "base/random.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/tracer.hpp"
#include "support/soups.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <set>

namespace raig {
namespace {

using namespace test;
using shared::FrameKernels;

/// Code shared with devices, called by name.
FrameKernels& code() {
    static FrameKernels kernels;
    return kernels;
}

// ---- Sampling numbers --------------------------------------------------------------------------------------------------

TEST(Sampling, SecondDimensionIsSobols) {
    Random random(3);
    for (int n = 0; n < 10'000; ++n) {
        const auto i = n < 1000 ? static_cast<uint32_t>(n) : static_cast<uint32_t>(random.bits());
        uint32_t want = 0;
        for (uint32_t v = 0x80000000u, rest = i; rest != 0; rest >>= 1, v ^= v >> 1)
            if (rest & 1) want ^= v;
        ASSERT_EQ(code().sobol1(i), want) << i;
    }
}

TEST(Sampling, PermutesBits) {
    std::set<uint32_t> hashes, scrambled;
    for (uint32_t i = 0; i < 4096; ++i) {
        hashes.insert(code().hash(i));
        scrambled.insert(code().scramble(i, 12345));
    }
    EXPECT_EQ(hashes.size(), 4096u);
    EXPECT_EQ(scrambled.size(), 4096u);
}

// Every elementary interval of area 1/64 holds one of the first 64 samples, in every pixel and dimension.
TEST(Sampling, StratifiesEveryElementaryInterval) {
    for (const uint32_t pixel : {0u, 1u, 511u, 262143u})
        for (const uint32_t dimension : {0u, 1u, 5u, 4000000000u})
            for (uint32_t wide = 1; wide <= 64; wide *= 2) {
                std::set<uint32_t> cells;
                for (uint32_t s = 0; s < 64; ++s) {
                    const vec2 p = code().sampleSquare(pixel, s, dimension, 7);
                    ASSERT_TRUE(p.x >= 0.0f && p.x < 1.0f && p.y >= 0.0f && p.y < 1.0f);
                    cells.insert(static_cast<uint32_t>(p.x * float(wide)) * 64 +
                                 static_cast<uint32_t>(p.y * float(64 / wide)));
                }
                EXPECT_EQ(cells.size(), 64u) << pixel << ' ' << dimension << ' ' << wide;
            }
}

// ---- Surfaces ----------------------------------------------------------------------------------------------------------

TEST(Fresnel, IsThatOfTheEquationsAtEveryAngle) {
    for (const auto& [n1, n2] : {std::pair(1.0, 1.5), std::pair(1.5, 1.0), std::pair(1.0, 1.33), std::pair(2.4, 1.0)})
        for (double degrees = 0.0; degrees < 90.0; degrees += 0.25) {
            const double cosI = std::cos(degrees * M_PI / 180.0), sinT = n1 / n2 * std::sqrt(1.0 - cosI * cosI);
            if (std::abs(sinT - 1.0) < 1e-3) continue;  // at the critical angle a rounding decides
            const double cosT = std::sqrt(std::max(0.0, 1.0 - sinT * sinT));
            const double s = (n1 * cosI - n2 * cosT) / (n1 * cosI + n2 * cosT);
            const double p = (n2 * cosI - n1 * cosT) / (n2 * cosI + n1 * cosT);
            const double want = sinT > 1.0 ? 1.0 : 0.5 * (s * s + p * p);
            EXPECT_NEAR(code().fresnelReflectance(float(cosI), float(n1), float(n2)), want, 2e-5) << n1 << ' ' << degrees;
        }
}

TEST(Refraction, FollowsSnellAndIsTotallyReflectedBeyondTheCriticalAngle) {
    const vec3 n(0, 1, 0);
    for (double degrees = 0.0; degrees < 89.0; degrees += 0.5) {
        const double angle = degrees * M_PI / 180.0;
        const vec3 d(float(std::sin(angle)), float(-std::cos(angle)), 0.0f);
        const vec3 in = code().bent(d, n, 1.0f / 1.5f);
        EXPECT_NEAR(in.x, std::sin(angle) / 1.5, 1e-6);
        EXPECT_LT(in.y, 0.0f);
        const vec3 out = code().bent(d, n, 1.5f);
        const double sine = 1.5 * std::sin(angle);
        if (std::abs(sine - 1.0) < 1e-3) continue;  // at the critical angle a rounding decides
        EXPECT_NEAR(out.x, sine > 1.0 ? 0.0 : sine, 2e-6) << degrees;
        EXPECT_EQ(out == vec3(0.0f), sine > 1.0) << degrees;
    }
}

TEST(Decay, IsTheExponentialWithinTwoUlp) {
    double worst = 0.0;
    for (float x = 0.0f; x < 87.0f; x += 0.00123f) {
        const double want = std::exp(-double{x});
        worst = std::max(worst, std::abs(code().decay(x) / want - 1.0));
    }
    EXPECT_LT(worst, 2 * 1.2e-7);
    EXPECT_EQ(code().decay(0.0f), 1.0f);
    EXPECT_EQ(code().decay(1e30f), 0.0f);
}

TEST(FaceNormal, IsRightAtEverySize) {
    Random random(5);
    for (const double size : {1e-18, 1e-6, 1.0, 1e6, 1e18})
        for (int i = 0; i < 200; ++i) {
            const vec3 a = random.inCube(-size, size), b = random.inCube(-size, size), c = random.inCube(-size, size);
            const dvec3 cross = glm::cross((dvec3(b) - dvec3(a)) / size, (dvec3(c) - dvec3(a)) / size);
            if (glm::length(cross) < 0.05) continue;
            const vec3 n = code().faceNormal(a, b, c, vec3(0.0f));
            EXPECT_LT(glm::length(dvec3(n) - glm::normalize(cross)), 2e-5) << size;
        }
}

// ---- Spawned rays ------------------------------------------------------------------------------------------------------

/// Rays that leave points of `triangles` to the side of each one's normal, at all angles down to 1e-4 above the surface.
std::vector<Ray> spawn(const std::vector<Triangle>& triangles, size_t count, uint64_t seed) {
    Random random(seed);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        const Triangle& t = triangles[random.below(static_cast<uint32_t>(triangles.size()))];
        const double r = std::sqrt(random.unit()), s = random.unit();
        const auto point = code().pointOf(t.a, t.b, t.c, float(r * (1 - s)), float(r * s));
        const vec3 n = code().faceNormal(t.a, t.b, t.c, vec3(0.0f));
        dvec3 d = random.direction();
        d -= glm::dot(d, dvec3(n)) * (rays.size() % 2 ? 1.0 - std::pow(10.0, -4.0 * random.unit()) : 0.0) * dvec3(n);
        if (glm::dot(d, dvec3(n)) < 0.0) d = -d;
        const vec3 direction(glm::normalize(d));
        if (!(glm::dot(direction, n) > 0.0f)) continue;
        rays.push_back({code().spawnOrigin(point, n), 0.0f, direction, shared::FAR_AWAY});
    }
    return rays;
}

size_t countHits(const std::vector<Triangle>& triangles, const std::vector<Ray>& rays) {
    const Structure structure = structureType("bvh").build(triangles, {});
    std::vector<Hit> hits(rays.size());
    makeCpuTracer(structure)->trace(rays, hits, Query::any);
    return static_cast<size_t>(std::ranges::count_if(hits, [](const Hit& hit) { return hit.primitive != NO_HIT; }));
}

const dvec3 places[] = {{0, 0, 0}, {1e4, -1e4, 1e4}, {-1e6, 1e6, 1e6}};

/// The outside of a convex body: nothing that leaves it can meet it again.
TEST(SpawnedRays, NeverMeetTheConvexBodyTheyLeave) {
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places) {
            // At sizes below the spacing of floats there, bodies are dents and points: not convex any more.
            if (size < glm::length(place) * 1e-4) continue;
            const std::vector<Triangle> sphere = test::sphere(12, size, place);
            EXPECT_EQ(countHits(sphere, spawn(sphere, 20'000, 11)), 0u) << "size " << size << " at " << place.x;
        }
}

/// Single triangles of any shape, slivers and those in planes of coordinates among them: a plane is never met again.
TEST(SpawnedRays, NeverMeetTheTriangleTheyLeave) {
    Random random(9);
    size_t met = 0, rays = 0;
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places)
            for (int i = 0; i < 60; ++i) {
                vec3 p[3];
                for (vec3& corner : p) corner = vec3(place + size * dvec3(random.inCube(-1, 1)));
                if (i % 3 == 1) p[0][i % 2] = p[1][i % 2] = p[2][i % 2] = float(place[i % 2]);
                if (i % 3 == 2) p[2] = vec3(glm::mix(dvec3(p[0]), dvec3(p[1]), 0.4)) + 0.01f * (p[2] - vec3(place));
                const std::vector<Triangle> one = {{p[0], p[1], p[2]}};
                const double longest =
                    std::max(glm::length(dvec3(p[1]) - dvec3(p[0])), glm::length(dvec3(p[2]) - dvec3(p[0])));
                const double area = glm::length(glm::cross(dvec3(p[1]) - dvec3(p[0]), dvec3(p[2]) - dvec3(p[0])));
                if (!one[0].usable() || area < 1e-3 * longest * longest) continue;
                met += countHits(one, spawn(one, 100, random.bits()));
                rays += 100;
            }
    EXPECT_GT(rays, 50'000u);
    EXPECT_EQ(met, 0u);
}

/// Rays start nearer to the triangle's plane than 8 ULP of the body's largest coordinates.
TEST(SpawnedRays, NeverJumpAGapOfEightUlp) {
    for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
        for (const dvec3& place : places) {
            if (size < glm::length(place) * 1e-4) continue;
            const std::vector<Triangle> body = test::sphere(12, size, place);
            const float reach = float(glm::length(place) + size);
            const float gap = 8.0f * (std::nextafter(reach, INFINITY) - reach);
            Random random(21);
            size_t leaks = 0;
            for (int i = 0; i < 300; ++i) {
                const Triangle& t = body[random.below(static_cast<uint32_t>(body.size()))];
                const vec3 n = code().faceNormal(t.a, t.b, t.c, vec3(0.0f));
                const auto point = code().pointOf(t.a, t.b, t.c, 0.3f, 0.5f);
                const double height = glm::dot(dvec3(code().spawnOrigin(point, n)) - dvec3(t.a), dvec3(n));
                leaks += height > gap;
            }
            EXPECT_EQ(leaks, 0u) << "size " << size << " at " << place.x;
        }
}

}  // namespace
}  // namespace raig
