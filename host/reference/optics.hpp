/// Reflection and refraction at a smooth surface, in double precision.
#pragma once

#include "base/vectors.hpp"

#include <optional>

namespace raig::reference {

/// The share of unpolarised light that is reflected where it passes from index n1 to n2, at an angle of incidence whose
/// cosine is cosI in [0, 1]. 1 beyond the critical angle (total internal reflection); 0 for equal indices.
/// Source: Fresnel's equations; Born and Wolf 1999, "Principles of Optics", section 1.5.
double fresnel(double cosI, double n1, double n2);

/// The mirror direction of d at a surface of unit normal n.
dvec3 reflect(const dvec3& d, const dvec3& n);

/// The direction in which light that arrives along d (unit) goes on, at a surface whose unit normal n is turned against d;
/// eta = n1 / n2. Nothing beyond the critical angle. Source: Snell's law in vector form.
std::optional<dvec3> refract(const dvec3& d, const dvec3& n, double eta);

}  // namespace raig::reference
