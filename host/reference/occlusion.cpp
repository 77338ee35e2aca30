#include "reference/occlusion.hpp"

#include "reference/directions.hpp"
#include "reference/optics.hpp"
#include "reference/sampling.hpp"
#include "reference/shadows.hpp"

namespace raig::reference {

Radiance openness(const World& world, Ray ray, double reach, const Bounds& bounds, const SampleId& id) {
    Radiance found;
    double weight = 1.0;
    uint32_t leaving = noTriangle;
    for (uint32_t passes = 0; weight > 0.0; ++passes) {
        if (passes > mostPasses || (passes > 0 && weight < bounds.minContribution)) {
            found.discarded += weight;
            break;
        }
        const Hit hit = world.tree.closest(ray, leaving);
        if (hit.primitive == noTriangle) {
            found.value += weight;
            break;
        }
        const SurfacePoint p = surfaceAt(world, ray, hit, id.pixelWidth + id.pixelSpread * hit.t);
        dvec3 way = cosineDirection(p.shadingNormal, sample2(id.pixel, id.sample, 6 + 3 * passes, bounds.seed));
        if (glm::dot(way, p.normal) < 0.0) way = reflect(way, p.normal);
        Ray probe;
        probe.origin = leave(p, p.position, p.normal, id, 4 * passes + 2);
        probe.direction = id.rounding.direction(way, 4 * passes + 3);
        probe.tMax = reach;
        const double kept = weight * p.surface.coverage;
        if (kept > 0.0) found.value += kept * transmittance(world, probe, /* throughGlass= */ false, hit.primitive);
        weight *= 1.0 - p.surface.coverage;
        ray.tMin = std::nextafter(hit.t, INFINITY);
        leaving = hit.primitive;
    }
    return found;
}

}  // namespace raig::reference
