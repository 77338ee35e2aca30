#include "reference/whitted.hpp"

#include "reference/environment.hpp"
#include "reference/lobe.hpp"
#include "reference/sampling.hpp"
#include "reference/scattering.hpp"
#include "reference/shadows.hpp"

#include <algorithm>

namespace raig::reference {

namespace {

/// One sample's recursion.
class Recursion {
public:
    Recursion(const World& world, const Bounds& bounds, const SampleId& id) : world_(world), bounds_(bounds), id_(id) {}

    /// The radiance along `ray`, times `weight`.
    /// `travelled` is how far light has come from its origin to the camera.
    dvec3 trace(const Ray& ray, dvec3 weight, uint32_t depth, uint32_t key, uint32_t leaving, const Nest& nest,
                double travelled, uint32_t passes = 0) {
        const Hit hit = world_.tree.closest(ray, leaving);
        if (hit.primitive == noTriangle) return weight * distantRadiance(world_.scene, ray.direction);
        const double distance = travelled + hit.t;
        const SurfacePoint p = surfaceAt(world_, ray, hit, id_.pixelWidth + id_.pixelSpread * distance);
        const Passing passing = pass(world_, p, nest);
        weight *= glm::exp(-passing.absorption * (hit.t - ray.tMin));
        if (passing.isHidden)
            return follow(p, ray.direction, weight, -p.normal, depth, 2 * key + 2, hit.primitive, passing.beyond, distance,
                          passes);

        dvec3 radiance(0.0);
        if (p.surface.coverage < 1.0) {
            Ray rest = ray;
            rest.tMin = std::nextafter(hit.t, INFINITY);
            radiance += passOn(rest, weight * (1.0 - p.surface.coverage), depth, 2 * key + 2, hit.primitive, passing.beyond,
                               travelled, passes + 1);
            weight *= p.surface.coverage;
            if (largest(weight) <= 0.0) return radiance;
        }
        const Scattering scattering = scatter(p, ray.direction, passing);
        radiance += weight * p.surface.emission;
        radiance += weight * directLight(p, scattering, -ray.direction, hit.primitive, key);
        radiance += follow(p, scattering.reflected, weight * scattering.reflection, p.normal, depth, 2 * key + 1,
                           hit.primitive, passing.here, distance, passes);
        radiance += follow(p, scattering.transmitted, weight * scattering.transmission, -p.normal, depth, 2 * key + 2,
                           hit.primitive, passing.beyond, distance, passes);
        return radiance;
    }

    /// Of a ray that has been traced with a weight of 1.
    Radiance found(const dvec3& value) const { return {value, discarded_, brightest_, double(depth_)}; }

private:
    dvec3 follow(const SurfacePoint& p, const dvec3& direction, const dvec3& weight, const dvec3& side, uint32_t depth,
                 uint32_t key, uint32_t leaving, const Nest& nest, double travelled, uint32_t passes) {
        if (largest(weight) <= 0.0) return dvec3(0.0);
        if (depth + 1 > bounds_.maxDepth || largest(weight) < bounds_.minContribution) {
            discarded_ += largest(weight);
            return dvec3(0.0);
        }
        Ray child;
        child.origin = leave(p, p.position, side, id_, 4 * key);
        child.direction = id_.rounding.direction(direction, 4 * key + 1);
        depth_ = std::max(depth_, depth + 1);
        const dvec3 weighted = trace(child, weight, depth + 1, key, leaving, nest, travelled, passes);
        noteBrightness(weighted, weight);
        return weighted;
    }

    /// What comes along the rest of a ray that a surface lets pass by its alpha.
    dvec3 passOn(const Ray& rest, const dvec3& weight, uint32_t depth, uint32_t key, uint32_t leaving, const Nest& nest,
                 double travelled, uint32_t passes) {
        if (largest(weight) <= 0.0) return dvec3(0.0);
        if (passes > mostPasses || largest(weight) < bounds_.minContribution) {
            discarded_ += largest(weight);
            return dvec3(0.0);
        }
        const dvec3 weighted = trace(rest, weight, depth, key, leaving, nest, travelled, passes);
        noteBrightness(weighted, weight);
        return weighted;
    }

    void noteBrightness(const dvec3& weighted, const dvec3& weight) {
        for (int channel = 0; channel < 3; ++channel)
            if (weight[channel] > 0.0) brightest_ = std::max(brightest_, weighted[channel] / weight[channel]);
    }

    /// The light of lights and from everywhere that goes back along the ray, to `eye`.
    dvec3 directLight(const SurfacePoint& p, const Scattering& scattering, const dvec3& eye, uint32_t leaving,
                      uint32_t key) {
        constexpr double pi = 3.14159265358979323846;
        dvec3 light = p.surface.openness * dvec3(world_.scene.ambient) * (scattering.diffuse + scattering.rough);
        const auto add = [&](const Arriving& arriving, double share, double leastSpread) {
            if (arriving.irradiance == dvec3(0.0)) return;
            const dvec3 mirrored = lobeTowards(scattering.lobe, p.shadingNormal, p.surface.roughness, eye,
                                               arriving.direction, leastSpread);
            const dvec3 value = scattering.diffuse / pi + share * mirrored;
            if (value != dvec3(0.0))
                light += shareSeen(world_, p, arriving, /* throughGlass= */ true, leaving, id_, key) * value *
                         arriving.irradiance;
        };
        const double share = p.surface.transmits ? 0.0 : 1.0 - p.surface.gloss;
        for (const Arriving& each : lightsSeen(world_, p, id_, key, bounds_.seed, emitterCandidates))
            add(each, each.isDrawn ? share : 1.0, each.isDrawn ? 1.0 / 16.0 : 0.01);
        return light;
    }

    static constexpr uint32_t emitterCandidates = 4;

    const World& world_;
    const Bounds& bounds_;
    const SampleId& id_;
    double discarded_ = 0.0;
    double brightest_ = 0.0;
    uint32_t depth_ = 0;
};

}  // namespace

dvec3 leave(const SurfacePoint& p, const dvec3& from, const dvec3& side, const SampleId& id, uint32_t key) {
    const dvec3 rounded = id.rounding.position(from, p.magnitude, key) - from;
    const double height = glm::dot(rounded, side);
    return from + (height < 0.0 ? rounded - 2.0 * height * side : rounded) + 1e-12 * p.magnitude * side;
}

Radiance traceRay(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id) {
    Recursion recursion(world, bounds, id);
    return recursion.found(recursion.trace(ray, dvec3(1.0), 0, 0, noTriangle, id.media, 0.0));
}

}  // namespace raig::reference
