#include "reference/emitters.hpp"

#include "reference/sampling.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raig::reference {

bool canReach(const SurfacePoint& p, const dvec3& direction) {
    if (glm::dot(p.smoothNormal, direction) <= 0.0) return false;
    return glm::dot(p.normal, direction) > 0.0 || p.lift != dvec3(0.0);
}

namespace {

/// Both cosines over the squared distance: what of a point's light the way it lies to p lets through.
double geometryOf(const World& world, const SurfacePoint& p, const Arriving& light) {
    if (light.direction == dvec3(0.0) || !canReach(p, light.direction)) return 0.0;
    const Geometry::Corners corners = world.geometry.corners(world.geometry.place(light.triangle));
    const dvec3 a = corners.a, b = corners.b, c = corners.c;
    const double there = std::abs(glm::dot(glm::normalize(glm::cross(b - a, c - a)), light.direction));
    const dvec3 way = light.position - p.position;
    return std::max(0.0, glm::dot(p.shadingNormal, light.direction)) * there / glm::dot(way, way);
}

}  // namespace

Arriving drawnFromEmitters(const World& world, const SurfacePoint& p, const SampleId& id, uint32_t key, uint32_t seed,
                           uint32_t candidates) {
    std::vector<Arriving> points;
    std::vector<double> sums;
    double sum = 0.0;
    for (uint32_t c = 0; c < candidates; ++c) {
        const uint32_t index = id.sample * candidates + c;
        const dvec2 choice = sample2(id.pixel, index, 1 + 3 * key, seed);
        const dvec2 place = sample2(id.pixel, index, 2 + 3 * key, seed);
        points.push_back(arrivingFromEmitters(world, choice.x, place, p.position, p.shadingNormal));
        sum += geometryOf(world, p, points.back());
        sums.push_back(sum);
    }
    if (sum == 0.0) return {};
    const double place = sample2(id.pixel, id.sample, 0x40000000u + key, seed).x * sum;
    const size_t i = std::ranges::upper_bound(sums, place) - sums.begin();
    points[i].irradiance *= sum / (candidates * (sums[i] - (i > 0 ? sums[i - 1] : 0.0)));
    return points[i];
}

}  // namespace raig::reference
