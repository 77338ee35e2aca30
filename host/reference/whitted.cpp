#include "reference/whitted.hpp"

#include "reference/environment.hpp"
#include "reference/lobe.hpp"
#include "reference/optics.hpp"
#include "reference/sampling.hpp"
#include "reference/shadows.hpp"

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
    dvec3 rough{0.0};  ///< the lobe's share of light from everywhere
    Lobe lobe;
    dvec3 reflection{0.0};
    dvec3 transmission{0.0};
    dvec3 reflected{0.0};  ///< directions, unit
    dvec3 transmitted{0.0};
};

/// What mirrors: metal, or a dielectric, which weighs `weight` at a point.
struct Mirror {
    double weight;
    dvec3 f0, f90;
};

Scattering scatterOpaque(const SurfacePoint& p, double cosI) {
    const LocalSurface& s = p.surface;
    Scattering result;
    const LobeAlbedo albedo = lobeAlbedo(cosI, s.roughness);
    result.lobe = lobeOf(s, albedo.all);
    const auto add = [&](const Mirror& m) {
        // Source: Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
        const dvec3 sharp = s.gloss * (m.f0 + (m.f90 - m.f0) * std::pow(1.0 - cosI, 5.0));
        const dvec3 gain = 1.0 + m.f0 * (1.0 - albedo.all) / albedo.all;
        const dvec3 rough = (1.0 - s.gloss) * gain * (m.f0 * (albedo.all - albedo.grazing) + m.f90 * albedo.grazing);
        result.reflection += m.weight * sharp;
        result.rough += m.weight * rough;
        return sharp + rough;
    };
    add({s.metallic, s.metal, dvec3(1.0)});
    // Only what the dielectric does not mirror gets to its coloured inside; a metal has none.
    result.diffuse = (1.0 - add({1.0 - s.metallic, dvec3(s.dielectric), dvec3(s.grazing)})) * s.diffuse;
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
    if (s.thin || p.front) result.lobe = lobeOf(s, 1.0);
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
            if (value != dvec3(0.0)) light += value * unshadowed(p, arriving, leaving, key);
        };
        const double share = p.surface.transmits ? 0.0 : 1.0 - p.surface.gloss;
        for (const Light& l : world_.scene.lights) add(arriving(l, p.position, p.shadingNormal), 1.0, 0.01);
        if (!world_.emitters.triangles.empty()) {
            const dvec2 choice = sample2(id_.pixel, id_.sample, 1 + 3 * key, bounds_.seed);
            const dvec2 place = sample2(id_.pixel, id_.sample, 2 + 3 * key, bounds_.seed);
            add(arrivingFromEmitters(world_, choice.x, place, p.position, p.shadingNormal), share, 1.0 / 16.0);
        }
        if (world_.scene.environment && world_.scene.environment->shines()) {
            const uint32_t dimension = 0x80000000u + 2 * key;
            const dvec2 choice = sample2(id_.pixel, id_.sample, dimension, bounds_.seed);
            const dvec2 place = sample2(id_.pixel, id_.sample, dimension + 1, bounds_.seed);
            add(arrivingFromEnvironment(*world_.scene.environment, choice, place, p.shadingNormal), share, 1.0 / 16.0);
        }
        return light;
    }

    /// The irradiance of `light`, or none where it is behind the smooth surface or hidden, or behind the face though nothing
    /// lies above that.
    dvec3 unshadowed(const SurfacePoint& p, const Arriving& light, uint32_t leaving, uint32_t key) {
        const bool fromAbove = glm::dot(p.normal, light.direction) > 0.0;
        if (light.irradiance == dvec3(0.0) || (!fromAbove && p.lift == dvec3(0.0))) return dvec3(0.0);
        if (glm::dot(p.smoothNormal, light.direction) <= 0.0) return dvec3(0.0);
        if (!light.castsShadows) return light.irradiance;
        Ray shadow;
        shadow.origin = leave(p, p.position + p.lift, p.normal, id_, 4 * key + 2);
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
        // Light from below the face's plane may be in the face's own shadow, as the ray starts above it.
        const uint32_t passedOver = fromAbove ? leaving : noTriangle;
        return transmittance(world_, shadow, /* throughGlass= */ true, passedOver, light.triangle) * light.irradiance;
    }

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
