/// Path tracing, in double precision: the radiance that arrives along a ray, by one chain of rays.
#pragma once

#include "reference/whitted.hpp"

namespace raig::reference {

/// An estimate of the radiance along `ray` (unit direction): the mean over uniform random numbers is what arrives, but for
/// light that is reflected more than maxDepth times.
///   - Where nothing is hit: the sky, or the environment; a surface's own emission.
///   - Direct light as by Whitted's recursion, without ambient light; to the emitters and the environment no surface is
///     passed by that transmits.
///   - One ray goes on: mirrored, transmitted, or in a direction drawn by its cosine to the shading normal (dimension 6 + 3
///     k) and by the lobe of a rough surface. Of these it takes the first, in this order, whose chance and those before it
///     add up to more than the first number of dimension 2^30 + k; chances are in proportion to the largest component of the
///     weight that it would have, of the lobe by its share of light from everywhere. The weight is divided by the chance, or
///     for the last two by the density of both. A surface whose roughness squared is less than 1/1000 is a mirror, others
///     have none.
///   - If the largest component is less than rouletteFactor times minContribution it goes on only if the second number of
///     that dimension is less than the ratio, and then weighs that much.
///   - What is not there by its alpha is passed if the first number of dimension 2^29 + k is at least the coverage.
/// k counts the rays of the chain from 0. What is found both by a drawn ray and by one to a light counts by the balance
/// heuristic, with densities by solid angle; those of emitters are taken to be the luminance of the material's emission over
/// its sum by area, those of the last point's drawn rays to be none.
/// Source: Kajiya 1986, "The Rendering Equation"; Veach and Guibas 1995, "Optimally Combining Sampling Techniques for Monte
/// Carlo Rendering"; Arvo and Kirk 1990, "Particle Transport and Image Synthesis" (roulette).
Radiance tracePath(const World& world, const Ray& ray, const Bounds& bounds, const SampleId& id);

}  // namespace raig::reference
