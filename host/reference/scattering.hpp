/// What a surface does with light that arrives along a ray, in double precision.
#pragma once

#include "reference/lobe.hpp"
#include "reference/media.hpp"
#include "reference/world.hpp"

#include <algorithm>

namespace raig::reference {

/// The largest component: how much a weight may matter.
inline double largest(const dvec3& v) {
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

/// Of a ray that is in `nest` at p.
Passing pass(const World& world, const SurfacePoint& p, const Nest& nest);

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

/// Of light along unit direction d. An opaque surface mirrors by Schlick's formula, of which `gloss` goes along `reflected`
/// and the rest into the lobe, and scatters what is left; one that transmits mirrors by Fresnel's law, and lets the rest
/// pass. Source: Schlick 1994, "An Inexpensive BRDF Model for Physically-based Rendering".
Scattering scatter(const SurfacePoint& p, const dvec3& d, const Passing& passing);

}  // namespace raig::reference
