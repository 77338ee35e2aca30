/// What rough surfaces mirror, in double precision: the GGX lobe.
#pragma once

#include "reference/world.hpp"

namespace raig::reference {

/// Of light from everywhere, the share that a lobe of perfect mirrors reflects, and of it the part that their (1 - cos)^5
/// weighs: polynomials in r, s = sqrt(cosine), cosine, and c = 1 - cosine,
///     all     = 1 - r (1.197116 - 2.842857 s + 1.264805 s^2) - r^2 (-3.802190 + 12.473374 s - 7.462394 s^2)
///                 - r^3 (2.595462 - 8.787570 s + 6.086005 s^2), in [1/4, 1]
///     grazing = c^3 (-3.206164 + 8.244979 c - 3.961959 c^2) + r c^3 (9.963692 - 22.844650 c + 10.347438 c^2)
///                 + r^2 c^3 (-6.954611 + 14.808764 c - 6.313605 c^2), in [0, all]
/// fitted to the integrals of lobeTowards().
struct LobeAlbedo {
    double all, grazing;
};
LobeAlbedo lobeAlbedo(double cosine, double roughness);

/// What the lobe's mirrors reflect along their normals and at grazing.
struct Lobe {
    dvec3 along{0.0}, grazing{0.0};
};

/// The lobe of a surface whose mirrors alone would reflect the share `albedo` of light from everywhere: of metal and of
/// dielectric each gains 1 + f0 (1 - albedo) / albedo, as light does that goes from mirror to mirror [Turquin 2019,
/// "Practical Multiple Scattering Compensation for Microfacet Models"]; both weighted by metallic.
Lobe lobeOf(const LocalSurface& surface, double albedo);

/// Radiance towards `eye` per irradiance from direction `light` (unit, on the side of unit normal n): D G F / (4 (n.l)
/// (n.v)) with GGX's D of width a = max(roughness^2, leastSpread), Smith's height-correlated G and Schlick's F. Source:
/// Walter et al. 2007, "Microfacet Models for Refraction through Rough Surfaces"; Heitz 2014, "Understanding the
/// Masking-Shadowing Function in Microfacet-Based BRDFs", equation 99.
dvec3 lobeTowards(const Lobe& lobe, const dvec3& n, double roughness, const dvec3& eye, const dvec3& light,
                  double leastSpread);

/// A direction in which mirrors of GGX's D of width a, on a surface of unit normal n, send light to `eye`, by which of them
/// are seen from there, for a point of the unit square. Source: Dupuy and Benyoub 2023, "Sampling Visible GGX Normals with
/// Spherical Caps"; the cap's point is the disk's (reference/directions.hpp), taken there by area.
dvec3 mirroredDirection(const dvec3& n, double a, const dvec3& eye, const dvec2& square);

/// Its density by solid angle: D G1 / (4 (n.v)). Source: Heitz 2018, "Sampling the GGX Distribution of Visible Normals".
double mirroredDensity(const dvec3& n, double a, const dvec3& eye, const dvec3& light);

}  // namespace raig::reference
