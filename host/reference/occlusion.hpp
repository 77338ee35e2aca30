/// Ambient occlusion, in double precision.
#pragma once

#include "reference/whitted.hpp"

namespace raig::reference {

/// The value is 1 if `ray` (unit direction) meets nothing, or if another one meets nothing within `reach`: that starts where
/// it hits, in a random direction by its cosine to the shading normal, mirrored in the triangle where it would go below it.
/// Every surface counts, as far as it is there by its alpha: the rest of both rays passes on. Else 0. Dimension 6 + 3 k is
/// the direction's, behind k surfaces that let `ray` pass.
/// Source: Zhukov, Iones and Kronin 1998, "An Ambient Light Illumination Model".
Radiance openness(const World& world, Ray ray, double reach, const Bounds& bounds, const SampleId& id);

}  // namespace raig::reference
