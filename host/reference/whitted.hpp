/// The lecture's recursion: the radiance that arrives along a ray, mirrored and refracted rays included.
#pragma once

#include "reference/rounding.hpp"
#include "reference/world.hpp"

namespace raig::reference {

/// What bounds the recursion, and what seeds it.
struct Bounds {
    uint32_t maxDepth = 8;                  ///< NIVELL_MAX: the camera's ray is at depth 0
    float minContribution = 1.0f / 512.0f;  ///< MIN_CONTRIB: rays of less weight are not followed
    uint32_t seed = 0;
};

/// Which sample of which pixel a ray belongs to, and how its rays are rounded.
struct SampleId {
    uint32_t pixel = 0;  ///< y * width + x
    uint32_t sample = 0;
    Rounding rounding{};
    Nest media{};              ///< that the camera's ray starts in
    double pixelWidth = 0.0;   ///< how wide a ray of this pixel is where it starts, and ...
    double pixelSpread = 0.0;  ///< ... how much wider it gets over a unit of length; mirrors and lenses count as flat
};

/// Where a ray that starts at `from` leaves the surface, on the side that `side` points to. Double precision needs hardly
/// any offset, as the triangle that is left is known; a rounded origin stays on its side, as float renderers see to that.
/// `key` is the rounding's.
dvec3 leave(const SurfacePoint& p, const dvec3& from, const dvec3& side, const SampleId& id, uint32_t key);

struct Radiance {
    dvec3 value{0.0};
    double discarded = 0.0;  ///< the weight of the rays not followed, summed: times the brightest radiance, bounds the error
    double brightest = 0.0;  ///< the largest radiance, in any channel, that arrived along a mirrored or transmitted ray
    double depth = 0.0;      ///< of the deepest ray that was followed
};

/// The radiance along `ray` (unit direction), by Whitted's recursion with one shadow ray to the emitters a shading point:
///   - nothing hit: the sky, or the environment;
///   - a surface's own emission, both sides;
///   - reflection, diffuse and by the lobe (reference/lobe.hpp), of the ambient light, of every light, of a random point of
///     the emitters and of a random direction of the environment, where no opaque triangle is in between (surfaces that
///     transmit cast no shadow: a simplification);
///   - an opaque surface mirrors the share `gloss` of f0, growing to f90 at grazing [Schlick 1994], and the lobe brings the
///     rest of the ambient light, of emitters and of the environment, and all of other lights; one that transmits mirrors by
///     Fresnel's law and transmits the rest, bent by Snell's law unless thin, and what is inside absorbs by Beer and
///     Lambert;
///   - of a surface that alpha says is there in part only that part does all this: the rest of the ray goes straight on, as
///     deep as before, through at most 64 such surfaces since the camera; so do shadow rays, which are dark after 64;
///   - what a ray runs through is what it entered last, and that is what it passes from; where it leaves a medium, but runs
///     through one that it entered later, it goes straight on as if nothing were there [Schmidt and Budge 2002, "Simple
///     Nested Dielectrics in Ray Traced Images"]. Media that are not closed are not remembered.
/// A child ray is followed if its depth is at most maxDepth and the largest component of its weight, the product of
/// reflectances and transmittances so far, is at least minContribution.
///
/// Random numbers come from reference/sampling.hpp; dimensions 1 + 3 k, 2 + 3 k and 2^30 + k (emitters: four points are
/// drawn and one is asked), and 2^31 + 2 k and the next (environment), belong to the ray of key k, whose mirrored child has
/// key 2 k + 1 and whose transmitted one 2 k + 2. Cost: up to 2^(maxDepth + 1) rays, fewer by minContribution. Source:
/// Whitted 1980, "An Improved Illumination Model for Shaded Display"; Hall and Greenberg 1983, "A Testbed for Realistic
/// Image Synthesis" (adaptive depth).
Radiance traceRay(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id);

}  // namespace raig::reference
