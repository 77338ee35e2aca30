#include "reference/whitted.hpp"

#include "reference/environment.hpp"
#include "reference/optics.hpp"
#include "reference/sampling.hpp"

#include <algorithm>

namespace raig::reference {

namespace {

double largest(const dvec3& v) {
    return std::max({v.x, v.y, v.z});
}

/// What a ray passes from, and into, at a surface.
struct Passing {
    Nest here;    ///< the media that the ray is in
    Nest beyond;  ///< ... will be in on the other side
    double n1 = 1.0;
    double n2 = 1.0;
    dvec3 absorption{0.0};  ///< of what the ray has run through
    bool isHidden = false;  ///< what it runs through goes on on the other side
};

double indexIn(const World& world, const Nest& nest) {
    return nest.isEmpty() ? 1.0 : double{world.surfaces[nest.innermost()].ior};
}

dvec3 absorptionIn(const World& world, const Nest& nest) {
    return nest.isEmpty() ? dvec3(0.0) : dvec3(world.surfaces[nest.innermost()].absorption);
}

Passing pass(const World& world, const SurfacePoint& p, const Nest& nest) {
    const LocalSurface& s = p.surface;
    Passing passing{.here = nest, .beyond = nest};
    passing.absorption = absorptionIn(world, nest);
    if (!s.transmits) return passing;
    passing.n2 = s.ior;
    if (s.thin) return passing;
    if (p.front) {
        passing.n1 = indexIn(world, nest);
        if (p.medium != noMedium) passing.beyond.enter(p.medium);
        return passing;
    }
    passing.n1 = s.ior;
    passing.absorption = s.absorption;
    if (p.medium != noMedium) {
        if (!passing.beyond.leave(p.medium)) {
            passing.here.enter(p.medium);  // as no surface was seen where it was entered
        } else if (nest.innermost() != p.medium) {
            passing.isHidden = true;
            passing.absorption = absorptionIn(world, nest);
        }
    }
    passing.n2 = indexIn(world, passing.beyond);
    return passing;
}

/// What a surface does with light that arrives along a ray.
struct Scattering {
    dvec3 diffuse{0.0};
    dvec3 reflection{0.0};
    dvec3 transmission{0.0};
    dvec3 reflected{0.0};  ///< directions, unit
    dvec3 transmitted{0.0};
};

Scattering scatterOpaque(const SurfacePoint& p, double cosI) {
    const LocalSurface& s = p.surface;
    Scattering result;
    if (s.gloss > 0.0) result.reflection = s.mirror + (s.gloss - s.mirror) * std::pow(1.0 - cosI, 5.0);
    result.diffuse = (1.0 - result.reflection) * s.diffuse;
    return result;
}

Scattering scatterTransmissive(const SurfacePoint& p, const dvec3& d, double cosI, double n1, double n2) {
    const LocalSurface& s = p.surface;
    double reflectance = fresnel(cosI, n1, n2);
    Scattering result;
    if (s.thin) {
        result.transmitted = d;
    } else if (reflectance < 1.0) {
        std::optional<dvec3> bent = refract(d, p.shadingNormal, n1 / n2);
        // An interpolated normal may send the ray back out of the face it went into: the face's own normal never does.
        if (bent && glm::dot(*bent, p.normal) >= 0.0) bent = refract(d, p.normal, n1 / n2);
        if (bent)
            result.transmitted = glm::normalize(*bent);
        else
            reflectance = 1.0;
    }
    result.reflection = dvec3(reflectance);
    result.transmission = (1.0 - reflectance) * s.transmission;
    result.diffuse = (1.0 - reflectance) * s.diffuse;
    return result;
}

Scattering scatter(const SurfacePoint& p, const dvec3& d, const Passing& passing) {
    const double cosI = std::min(1.0, -glm::dot(d, p.shadingNormal));
    Scattering result =
        p.surface.transmits ? scatterTransmissive(p, d, cosI, passing.n1, passing.n2) : scatterOpaque(p, cosI);
    result.reflected = reflect(d, p.shadingNormal);
    if (glm::dot(result.reflected, p.normal) <= 0.0) result.reflected = reflect(d, p.normal);
    result.reflected = glm::normalize(result.reflected);
    return result;
}

/// Where a ray leaves the surface from, on the side that `side` points to. Double precision needs hardly any offset, as the
/// triangle that is left is known; a rounded origin stays on its side, as float renderers see to that.
dvec3 leave(const SurfacePoint& p, const dvec3& side, const SampleId& id, uint32_t key) {
    const dvec3 rounded = id.rounding.position(p.position, p.magnitude, key) - p.position;
    const double height = glm::dot(rounded, side);
    return p.position + (height < 0.0 ? rounded - 2.0 * height * side : rounded) + 1e-12 * p.magnitude * side;
}

/// One sample's recursion.
class Recursion {
public:
    Recursion(const World& world, const Bounds& bounds, const SampleId& id) : world_(world), bounds_(bounds), id_(id) {}

    /// The radiance along `ray`, times `weight`.
    /// `travelled` is how far light has come from its origin to the camera.
    dvec3 trace(const Ray& ray, dvec3 weight, uint32_t depth, uint32_t key, uint32_t leaving, const Nest& nest,
                double travelled) {
        const Hit hit = world_.tree.closest(ray, leaving);
        if (hit.primitive == noTriangle) return weight * distantRadiance(world_.scene, ray.direction);
        const double distance = travelled + hit.t;
        const SurfacePoint p = surfaceAt(world_, ray, hit, id_.pixelWidth + id_.pixelSpread * distance);
        const Passing passing = pass(world_, p, nest);
        weight *= glm::exp(-passing.absorption * hit.t);
        if (passing.isHidden)
            return follow(p, ray.direction, weight, -p.normal, depth, 2 * key + 2, hit.primitive, passing.beyond, distance);

        const Scattering scattering = scatter(p, ray.direction, passing);
        dvec3 radiance = weight * p.surface.emission;
        if (largest(scattering.diffuse) > 0.0) radiance += weight * scattering.diffuse * directLight(p, hit.primitive, key);
        radiance += follow(p, scattering.reflected, weight * scattering.reflection, p.normal, depth, 2 * key + 1,
                           hit.primitive, passing.here, distance);
        radiance += follow(p, scattering.transmitted, weight * scattering.transmission, -p.normal, depth, 2 * key + 2,
                           hit.primitive, passing.beyond, distance);
        return radiance;
    }

    /// Of a ray that has been traced with a weight of 1.
    Radiance found(const dvec3& value) const { return {value, discarded_, brightest_, double(depth_)}; }

private:
    dvec3 follow(const SurfacePoint& p, const dvec3& direction, const dvec3& weight, const dvec3& side, uint32_t depth,
                 uint32_t key, uint32_t leaving, const Nest& nest, double travelled) {
        if (largest(weight) <= 0.0) return dvec3(0.0);
        if (depth + 1 > bounds_.maxDepth || largest(weight) < bounds_.minContribution) {
            discarded_ += largest(weight);
            return dvec3(0.0);
        }
        Ray child;
        child.origin = leave(p, side, id_, 4 * key);
        child.direction = id_.rounding.direction(direction, 4 * key + 1);
        depth_ = std::max(depth_, depth + 1);
        const dvec3 weighted = trace(child, weight, depth + 1, key, leaving, nest, travelled);
        for (int channel = 0; channel < 3; ++channel)
            if (weight[channel] > 0.0) brightest_ = std::max(brightest_, weighted[channel] / weight[channel]);
        return weighted;
    }

    /// The light that a white diffuse surface would send back.
    dvec3 directLight(const SurfacePoint& p, uint32_t leaving, uint32_t key) {
        constexpr double pi = 3.14159265358979323846;
        dvec3 light = p.surface.openness * dvec3(world_.scene.ambient);
        for (const Light& l : world_.scene.lights)
            light += unshadowed(p, arriving(l, p.position, p.shadingNormal), leaving, key) / pi;
        if (!world_.emitters.triangles.empty()) {
            const dvec2 choice = sample2(id_.pixel, id_.sample, 1 + 3 * key, bounds_.seed);
            const dvec2 place = sample2(id_.pixel, id_.sample, 2 + 3 * key, bounds_.seed);
            light +=
                unshadowed(p, arrivingFromEmitters(world_, choice.x, place, p.position, p.shadingNormal), leaving, key) / pi;
        }
        if (world_.scene.environment && world_.scene.environment->shines()) {
            const uint32_t dimension = 0x80000000u + 2 * key;
            const dvec2 choice = sample2(id_.pixel, id_.sample, dimension, bounds_.seed);
            const dvec2 place = sample2(id_.pixel, id_.sample, dimension + 1, bounds_.seed);
            light += unshadowed(p, arrivingFromEnvironment(*world_.scene.environment, choice, place, p.shadingNormal),
                                leaving, key) /
                     pi;
        }
        return light;
    }

    /// The irradiance of `light`, or none where it is behind the face or hidden.
    dvec3 unshadowed(const SurfacePoint& p, const Arriving& light, uint32_t leaving, uint32_t key) {
        if (light.irradiance == dvec3(0.0) || glm::dot(p.normal, light.direction) <= 0.0) return dvec3(0.0);
        if (!light.castsShadows) return light.irradiance;
        Ray shadow;
        shadow.origin = leave(p, p.normal, id_, 4 * key + 2);
        if (light.isFar) {
            shadow.direction = id_.rounding.direction(light.direction, 4 * key + 3);
        } else {
            // An emitter's own triangle is passed over by its id, so the ray may end on it.
            const bool isPoint = light.triangle == noTriangle;
            const double magnitude =
                std::max({std::abs(light.position.x), std::abs(light.position.y), std::abs(light.position.z)});
            const dvec3 end = isPoint ? light.position : id_.rounding.position(light.position, magnitude, 4 * key + 3);
            shadow.direction = end - shadow.origin;
            shadow.tMax = isPoint ? 1.0 : 1.0 - 1e-12;
        }
        return world_.tree.blocked(shadow, world_.seeThrough, leaving, light.triangle) ? dvec3(0.0) : light.irradiance;
    }

    const World& world_;
    const Bounds& bounds_;
    const SampleId& id_;
    double discarded_ = 0.0;
    double brightest_ = 0.0;
    uint32_t depth_ = 0;
};

}  // namespace

Radiance traceRay(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id) {
    Recursion recursion(world, bounds, id);
    return recursion.found(recursion.trace(ray, dvec3(1.0), 0, 0, noTriangle, id.media, 0.0));
}

}  // namespace raig::reference
