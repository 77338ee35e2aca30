#include "reference/shadows.hpp"

#include "reference/emitters.hpp"
#include "reference/environment.hpp"
#include "reference/sampling.hpp"

#include <algorithm>
#include <cmath>

namespace raig::reference {

double transmittance(const World& world, Ray shadow, bool throughGlass, uint32_t leaving, uint32_t arriving) {
    const std::span<const uint8_t> seeThrough = throughGlass ? std::span(world.seeThrough) : std::span<const uint8_t>();
    if (!world.anyPass) return world.tree.blocked(shadow, seeThrough, leaving, arriving) ? 0.0 : 1.0;
    double left = 1.0;
    for (uint32_t passes = 0; passes <= mostPasses; ++passes) {
        const Hit hit = world.tree.closest(shadow, leaving);
        if (hit.primitive == noTriangle || hit.primitive == arriving) return left;
        const bool isClear = !seeThrough.empty() && seeThrough[world.geometry.materials[hit.primitive]] != 0;
        if (!isClear) left *= 1.0 - coverageAt(world, hit);
        if (left <= 0.0) return 0.0;
        shadow.tMin = std::nextafter(hit.t, INFINITY);
        leaving = hit.primitive;
    }
    return 0.0;
}

std::vector<Arriving> lightsSeen(const World& world, const SurfacePoint& p, const SampleId& id, uint32_t k, uint32_t seed,
                                 uint32_t candidates) {
    std::vector<Arriving> lights;
    for (const Light& light : world.scene.lights) lights.push_back(arriving(light, p.position, p.shadingNormal));
    if (!world.emitters.triangles.empty()) lights.push_back(drawnFromEmitters(world, p, id, k, seed, candidates));
    if (world.scene.environment && world.scene.environment->shines()) {
        const uint32_t dimension = 0x80000000u + 2 * k;
        const dvec2 choice = sample2(id.pixel, id.sample, dimension, seed);
        const dvec2 place = sample2(id.pixel, id.sample, dimension + 1, seed);
        lights.push_back(arrivingFromEnvironment(*world.scene.environment, choice, place, p.shadingNormal));
    }
    return lights;
}

double shareSeen(const World& world, const SurfacePoint& p, const Arriving& light, bool throughGlass, uint32_t leaving,
                 const SampleId& id, uint32_t key) {
    const bool fromAbove = glm::dot(p.normal, light.direction) > 0.0;
    if (light.irradiance == dvec3(0.0) || !canReach(p, light.direction)) return 0.0;
    if (!light.castsShadows) return 1.0;
    Ray shadow;
    shadow.origin = leave(p, p.position + p.lift, p.normal, id, 4 * key + 2);
    if (light.isFar) {
        shadow.direction = id.rounding.direction(light.direction, 4 * key + 3);
    } else {
        // An emitter's own triangle is passed over by its id, so the ray may end on it.
        const bool isPoint = light.triangle == noTriangle;
        const double magnitude =
            std::max({std::abs(light.position.x), std::abs(light.position.y), std::abs(light.position.z)});
        const dvec3 end = isPoint ? light.position : id.rounding.position(light.position, magnitude, 4 * key + 3);
        shadow.direction = end - shadow.origin;
        shadow.tMax = isPoint ? 1.0 : 1.0 - 1e-12;
    }
    // Light from below the face's plane may be in the face's own shadow, as the ray starts above it.
    const uint32_t passedOver = fromAbove ? leaving : noTriangle;
    return transmittance(world, shadow, throughGlass, passedOver, light.triangle);
}

}  // namespace raig::reference
