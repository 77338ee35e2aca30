/// What Whitted shading needs of a material: how much is scattered, mirrored (K_R) and transmitted (K_T), and by what index.
#pragma once

#include "scene/scene.hpp"

namespace raig {

/// A material reduced to the lecture's terms, without its textures: what these and vertex colours multiply (base colour,
/// roughness, metallic, emission) varies over the surface, and the formulas below hold at each point of it, see
/// shaders/surface.glsl. All in [0, 1] but emission, ior and absorption.
struct Surface {
    vec3 diffuse;       ///< Lambertian reflectance
    vec3 mirror;        ///< K_R at normal incidence of an opaque surface; grows to `gloss` at grazing (Schlick)
    float gloss;        ///< 1 for a polished surface, 0 for one whose reflection is too blurred to be a mirror's
    vec3 transmission;  ///< K_T: what of the light that is not reflected by Fresnel's law passes; 0 for an opaque surface
    float ior;          ///< refraction index of the inside; exactly 1: no Fresnel reflection
    bool thin;          ///< passes light straight on
    vec3 absorption;    ///< per unit of length inside (Beer-Lambert); 0 where thin
    vec3 emission;      ///< radiance, both sides
    bool tintsThrough;  ///< colour varies `transmission`, too (not where only alpha lets light through)
};

/// Reduces a metallic-roughness material:
///     gloss        = max(0, 1 - 2 roughness)^2
///     diffuse      = alpha baseColor ((1 - metallic) (1 - transmission) + metallic (1 - gloss))
///     mirror       = gloss mix(((ior - 1) / (ior + 1))^2, baseColor, metallic)        (opaque only)
///     transmission = (1 - metallic) transmission baseColor, or 1 - alpha where only alpha lets light through
///     absorption   = -ln(attenuationColor) / attenuationDistance                      (not where thin)
/// A surface that passes light only because of alpha is thin, with ior 1. What is glossy but no mirror is shaded as diffuse.
Surface surfaceOf(const Material& material);

/// The share of light along the normal that a dielectric of that index reflects in air.
float normalReflectance(float ior);

}  // namespace raig
