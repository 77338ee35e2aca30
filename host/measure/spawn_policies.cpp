#include "measure/spawn_policies.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "base/random.hpp"
#include "measure/oracle.hpp"
#include "rays/frame_kernels.hpp"
#include "rays/tracer.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>
#include <numbers>

namespace raig {

namespace {

constexpr float inf = std::numeric_limits<float>::infinity();
constexpr size_t raysOfPair = 8;
constexpr double leastSize = 1e-4;  // of the place

double ulpOf(double magnitude) {
    const auto x = static_cast<float>(magnitude);
    return double{std::nextafter(x, inf)} - double{x};
}

/// How far its nearest corner is from the origin.
double distanceOf(const Triangle& t) {
    return std::min(glm::length(dvec3(t.a)), std::min(glm::length(dvec3(t.b)), glm::length(dvec3(t.c))));
}

/// The triangle's longest side, and its height over it.
dvec2 extentOf(const Triangle& t) {
    const dvec3 ab = dvec3(t.b) - dvec3(t.a), ac = dvec3(t.c) - dvec3(t.a), bc = dvec3(t.c) - dvec3(t.b);
    const double longest = std::max(glm::length(ab), std::max(glm::length(ac), glm::length(bc)));
    return {longest, longest > 0.0 ? glm::length(glm::cross(ab, ac)) / longest : 0.0};
}

dvec3 placeOf(const SpawnScale& scale) {
    return scale.place * dvec3(1, -1, 1);
}

/// A triangle across n, moved along it by no less than `gap` from `t`, in floats: so large that all that leaves `t` at more
/// than 6 degrees meets it.
Triangle nextTo(const Triangle& t, const dvec3& n, double gap) {
    const dvec3 middle = (dvec3(t.a) + dvec3(t.b) + dvec3(t.c)) / 3.0;
    const dvec3 x = glm::normalize(dvec3(t.b) - dvec3(t.a)), y = glm::cross(n, x);
    const double step = ulpOf(distanceOf(t)), reach = 2.0 * (extentOf(t).x + 20.0 * gap);
    for (double away = gap;; away += 0.5 * step) {
        const auto corner = [&](double angle) {
            return vec3(middle + away * n + reach * (std::cos(angle) * x + std::sin(angle) * y));
        };
        const Triangle moved{corner(0.0), corner(2.0 * std::numbers::pi / 3.0), corner(4.0 * std::numbers::pi / 3.0)};
        double least = inf;
        for (const vec3& at : {moved.a, moved.b, moved.c}) least = std::min(least, glm::dot(dvec3(at) - dvec3(t.a), n));
        if (least >= gap) return moved;
    }
}

/// Source: Waechter and Binder 2019, in Ray Tracing Gems, chapter 6.
vec3 stepAlong(const vec3& p, const vec3& n) {
    constexpr float nearZero = 1.0f / 32.0f, floatScale = 1.0f / 65536.0f, integerScale = 256.0f;
    vec3 moved(0.0f);
    for (int axis = 0; axis < 3; ++axis) {
        const auto steps = static_cast<int32_t>(integerScale * n[axis]);
        const int32_t bits = std::bit_cast<int32_t>(p[axis]) + (p[axis] < 0.0f ? -steps : steps);
        moved[axis] = std::abs(p[axis]) < nearZero ? p[axis] + floatScale * n[axis] : std::bit_cast<float>(bits);
    }
    return moved;
}

/// Code shared with devices, called by name.
shared::FrameKernels& code() {
    static shared::FrameKernels kernels;
    return kernels;
}

Ray leave(SpawnPolicy policy, const SpawnPair& pair, const Ray& arriving, const Hit& hit, const vec3& direction) {
    const vec3 p = arriving.origin + hit.t * arriving.direction;
    switch (policy) {
        case SpawnPolicy::none:
            return {p, 0.0f, direction, inf};
        case SpawnPolicy::smallestT:
            return {p, 1e-4f, direction, inf};
        case SpawnPolicy::alongNormal:
            return {p + 1e-4f * pair.side, 0.0f, direction, inf};
        case SpawnPolicy::integerSteps:
            return {stepAlong(p, pair.side), 0.0f, direction, inf};
        case SpawnPolicy::bounds:
            break;
    }
    const Triangle& t = pair.left;
    return {code().spawnOrigin(code().pointOf(t.a, t.b, t.c, hit.u, hit.v), pair.side), 0.0f, direction, inf};
}

}  // namespace

const char* nameOf(SpawnPolicy policy) {
    constexpr const char* names[] = {"t >= 0", "t >= 1e-4", "1e-4 along the normal", "Waechter-Binder", "error bounds"};
    return names[static_cast<size_t>(policy)];
}

std::vector<SpawnScale> spawnScales(double gap) {
    std::vector<SpawnScale> scales;
    for (const double place : {0.0, 1e4, 1e6})
        for (const double size : {1e-6, 1e-3, 1.0, 1e3, 1e6})
            if (size >= leastSize * place) scales.push_back({size, place, gap});
    return scales;
}

std::vector<SpawnPair> spawnPairs(const SpawnScale& scale, size_t count, uint32_t seed) {
    RAIG_CHECK(scale.size > 0.0 && scale.size >= leastSize * scale.place);
    Random random(101 ^ (uint64_t{seed} << 32));
    std::vector<SpawnPair> pairs;
    while (pairs.size() < count) {
        const dvec3 centre = placeOf(scale) + scale.size * random.direction();
        const auto corner = [&] { return vec3(centre + 0.1 * scale.size * dvec3(random.inCube(-1, 1))); };
        Triangle t{corner(), corner(), corner()};
        if (pairs.size() % 4 == 3) {  // in a plane of coordinates
            const auto axis = static_cast<int>(random.below(3));
            t.b[axis] = t.c[axis] = t.a[axis];
        }
        const dvec2 extent = extentOf(t);
        if (!t.usable() || extent.y < 0.02 * extent.x || extent.x < 0.04 * scale.size) continue;
        vec3 n = code().faceNormal(t.a, t.b, t.c, vec3(0.0f));
        if (random.below(2) == 0) n = -n;
        dvec3 exact = glm::normalize(glm::cross(dvec3(t.b) - dvec3(t.a), dvec3(t.c) - dvec3(t.a)));
        if (glm::dot(exact, dvec3(n)) < 0.0) exact = -exact;
        const double gap = std::max(scale.gap * scale.size, 8.0 * ulpOf(distanceOf(t)));
        pairs.push_back({t, nextTo(t, exact, gap), n});
    }
    return pairs;
}

std::vector<Ray> spawnRays(SpawnPolicy policy, const SpawnPair& pair, const SpawnScale& scale, size_t count, uint32_t seed) {
    Random random(102 ^ (uint64_t{seed} << 32));
    const Structure structure = structureType("brute").build(std::span(&pair.left, 1), {});
    const std::unique_ptr<Tracer> tracer = makeCpuTracer(structure);
    std::vector<Ray> rays;
    while (rays.size() < count) {
        std::vector<Ray> arriving(count);
        for (Ray& ray : arriving) {
            const double r = std::sqrt(random.unit()), s = random.unit();
            const dvec3 a(pair.left.a), b(pair.left.b), c(pair.left.c);
            const dvec3 target = a + r * (1.0 - s) * (b - a) + r * s * (c - a);
            dvec3 away = random.direction();
            if (glm::dot(away, dvec3(pair.side)) < 0.0) away = -away;
            const vec3 origin(target + scale.size * random.within(1.0, 20.0) * away);
            ray = {origin, 0.0f, vec3(glm::normalize(target - dvec3(origin))), inf};
        }
        std::vector<Hit> hits(count);
        tracer->trace(arriving, hits, Query::closest);
        for (size_t i = 0; i < count && rays.size() < count; ++i) {
            dvec3 direction = random.direction();
            const double cosine = glm::dot(direction, dvec3(pair.side));
            if (cosine < 0.0) direction = -direction;
            if (hits[i].primitive == NO_HIT || std::abs(cosine) < 0.1) continue;
            rays.push_back(leave(policy, pair, arriving[i], hits[i], vec3(direction)));
        }
    }
    return rays;
}

SpawnFindings judgeSpawning(SpawnPolicy policy, const SpawnScale& scale, uint64_t rays, uint32_t seed) {
    const std::vector<SpawnPair> pairs = spawnPairs(scale, (rays + raysOfPair - 1) / raysOfPair, seed);
    return parallelReduce(
        pairs.size(), 4, SpawnFindings{},
        [&](size_t begin, size_t end, SpawnFindings findings) {
            for (size_t i = begin; i < end; ++i) {
                const size_t count = std::min<uint64_t>(raysOfPair, rays - i * raysOfPair);
                const hard::Oracle left(std::span(&pairs[i].left, 1)), next(std::span(&pairs[i].next, 1));
                for (const Ray& ray : spawnRays(policy, pairs[i], scale, count, seed + static_cast<uint32_t>(i))) {
                    const bool meetsSelf = left.closest(ray).primitive != NO_HIT;
                    ++findings.rays;
                    findings.selfHits += meetsSelf;
                    findings.leaks += !meetsSelf && next.closest(ray).primitive == NO_HIT;
                }
            }
            return findings;
        },
        [](SpawnFindings a, const SpawnFindings& b) {
            return SpawnFindings{a.rays + b.rays, a.selfHits + b.selfHits, a.leaks + b.leaks};
        });
}

}  // namespace raig
