#include "reference/scattering.hpp"

#include "reference/optics.hpp"

#include <algorithm>

namespace raig::reference {

namespace {

double indexIn(const World& world, const Nest& nest) {
    return nest.isEmpty() ? 1.0 : double{world.surfaces[nest.innermost()].ior};
}

dvec3 absorptionIn(const World& world, const Nest& nest) {
    return nest.isEmpty() ? dvec3(0.0) : dvec3(world.surfaces[nest.innermost()].absorption);
}

}  // namespace

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

namespace {

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

}  // namespace

Scattering scatter(const SurfacePoint& p, const dvec3& d, const Passing& passing) {
    const double cosI = std::min(1.0, -glm::dot(d, p.shadingNormal));
    Scattering result =
        p.surface.transmits ? scatterTransmissive(p, d, cosI, passing.n1, passing.n2) : scatterOpaque(p, cosI);
    result.reflected = reflect(d, p.shadingNormal);
    if (glm::dot(result.reflected, p.normal) <= 0.0) result.reflected = reflect(d, p.normal);
    result.reflected = glm::normalize(result.reflected);
    return result;
}

}  // namespace raig::reference
