#include "measure/compare_scene.hpp"

#include "base/error.hpp"
#include "measure/compare_rays.hpp"

#include <algorithm>
#include <bit>
#include <cmath>
#include <limits>

namespace raig {

namespace {

/// Zero or a denormal.
bool isTiny(float value) {
    return std::abs(value) < std::numeric_limits<float>::min();
}

bool isSame(const Hit& a, const Hit& b, bool denormalsAreZero) {
    const auto same = [&](float x, float y) {
        return std::bit_cast<uint32_t>(x) == std::bit_cast<uint32_t>(y) || (denormalsAreZero && isTiny(x) && isTiny(y));
    };
    return a.primitive == b.primitive && same(a.t, b.t) && same(a.u, b.u) && same(a.v, b.v);
}

void growTo(Spread& spread, const Spread& other) {
    spread.median = std::max(spread.median, other.median);
    spread.p99 = std::max(spread.p99, other.p99);
    spread.max = std::max(spread.max, other.max);
}

}  // namespace

BitComparison compareBits(std::span<const Ray> rays, std::span<const Hit> device, std::span<const Hit> cpu,
                          bool denormalsAreZero) {
    RAIG_CHECK_OP(rays.size(), ==, device.size());
    RAIG_CHECK_OP(rays.size(), ==, cpu.size());
    BitComparison result;
    result.rays = rays.size();
    for (size_t i = 0; i < rays.size(); ++i) {
        if (isSame(device[i], cpu[i], denormalsAreZero)) continue;
        ++result.different;
        if (device[i].primitive != cpu[i].primitive)
            ++result.otherIds;
        else if (std::isfinite(device[i].t) && std::isfinite(cpu[i].t))
            result.tUlpMax = std::max(result.tUlpMax, ulpsApart(device[i].t, cpu[i].t));
        if (!result.first) result.first = {i, rays[i], device[i], cpu[i]};
    }
    return result;
}

std::vector<RayFamily> compareFamilies(const reference::Tree& tree, std::span<const Ray> camera, const vec3& eye,
                                       Tracer& device, Tracer* cpu, bool denormalsAreZero) {
    std::vector<RayFamily> families;
    const auto add = [&](std::string_view name, uint32_t level, std::span<const Ray> rays) {
        std::vector<Hit> hits(rays.size()), cpuHits(rays.size());
        if (!rays.empty()) device.trace(rays, hits, Query::closest);
        if (!rays.empty() && cpu != nullptr) cpu->trace(rays, cpuHits, Query::closest);
        families.push_back({name, level, compareHits(tree, rays, hits), std::nullopt});
        if (cpu != nullptr) families.back().bits = compareBits(rays, hits, cpuHits, denormalsAreZero);
    };
    add("camera", 0, camera);
    add("aimed", 0, aimedRays(tree.geometry(), eye, camera.size()));
    add("bounce", 1, bounceRays(tree, camera));
    return families;
}

std::optional<Placed<HitComparison::Difference>> firstDifference(std::span<const RayFamily> families) {
    for (const RayFamily& family : families)
        if (!family.hits.faults.empty()) return {{family.name, family.level, family.hits.faults.front()}};
    for (const RayFamily& family : families)
        if (family.hits.firstTie) return {{family.name, family.level, *family.hits.firstTie}};
    return std::nullopt;
}

std::optional<Placed<BitComparison::Difference>> firstBitDifference(std::span<const RayFamily> families) {
    for (const RayFamily& family : families)
        if (family.bits && family.bits->first) return {{family.name, family.level, *family.bits->first}};
    return std::nullopt;
}

HitComparison sumOf(std::span<const RayFamily> families) {
    HitComparison all;
    for (const RayFamily& family : families) {
        const HitComparison& hits = family.hits;
        all.met += hits.met;
        for (size_t i = 0; i < all.counts.size(); ++i) all.counts[i] += hits.counts[i];
        all.tUlps += hits.tUlps;
        growTo(all.tUlp, hits.tUlp);
        growTo(all.offset, hits.offset);
    }
    return all;
}

std::optional<BitComparison> sumOfBits(std::span<const RayFamily> families) {
    std::optional<BitComparison> all;
    for (const RayFamily& family : families) {
        if (!family.bits) continue;
        if (!all) all.emplace();
        all->rays += family.bits->rays;
        all->different += family.bits->different;
        all->otherIds += family.bits->otherIds;
        all->tUlpMax = std::max(all->tUlpMax, family.bits->tUlpMax);
    }
    return all;
}

}  // namespace raig
