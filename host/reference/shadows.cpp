#include "reference/shadows.hpp"

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

}  // namespace raig::reference
