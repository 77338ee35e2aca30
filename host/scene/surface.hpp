/// What Whitted shading needs of a material: how much is scattered, mirrored (K_R) and transmitted (K_T), and by what index.
#pragma once

#include "scene/scene.hpp"

namespace raig {

/// A material reduced to the lecture's terms, without its textures: what these and vertex colours multiply (base colour,
/// roughness, metallic, emission) varies over the surface, and the formulas below hold at each point of it, see
/// shaders/surface.glsl. All in [0, 1] but emission, ior and absorption.
struct Surface {
    vec3 diffuse;       ///< Lambertian reflectance
    vec3 f0;            ///< what an opaque surface mirrors along its normal ...
    float f90;          ///< ... and at grazing; between them by Schlick's formula
    float gloss;        ///< the share of that which the reflected ray brings: 1 of a polished surface, 0 of a blurred mirror
    vec3 mirror;        ///< K_R along the normal: gloss f0; towards grazing it grows to gloss f90
    vec3 transmission;  ///< K_T: what of the light that is not reflected by Fresnel's law passes; 0 for an opaque surface
    float ior;          ///< refraction index of the inside; exactly 1: no Fresnel reflection
    bool thin;          ///< passes light straight on
    vec3 absorption;    ///< per unit of length inside (Beer-Lambert); 0 where thin
    vec3 emission;      ///< radiance, both sides
};

/// Reduces a metallic-roughness material:
///     gloss        = max(0, 1 - 2 roughness)^2
///     shine        = 1 - max(0, 2 roughness - 1)^2
///     r            = ((ior - 1) / (ior + 1))^2
///     f0           = mix(shine r, baseColor, metallic)
///     f90          = mix(shine min(1, 50 r), 1, metallic)
///     diffuse      = baseColor (1 - metallic) (1 - transmission), times what the dielectric does not mirror
///     transmission = (1 - metallic) transmission baseColor
///     absorption   = -ln(attenuationColor) / attenuationDistance                      (not where thin)
/// What an opaque surface mirrors and the reflected ray does not bring is a lobe about that ray, see shaders/lobe.glsl. Of a
/// dielectric it fades from roughness 1/2 on: at 1 it is so wide that it counts as diffuse. A surface that lets light
/// through is as smooth as a window, whatever its roughness. Alpha is not in here: it says how much of the surface there is.
Surface surfaceOf(const Material& material);

/// True if rays may pass straight through a surface of that material, as its alpha, or where it varies that of its texture
/// or of any vertex, may be less than 1. Not where it blends and lets light through by itself: then alpha does not count.
/// O(texels).
bool mayLetPass(const Scene& scene, const Material& material);

/// From which alpha on a surface that is cut out is there; 0 if it blends. A little less than the cutoff, as much as alpha
/// may be off by rounding, which texels of 8 bits do not tell apart: texels of 102/255 are seen where the cutoff is 0.4.
float leastAlpha(const Material& material);

/// The share of light along the normal that a dielectric of that index reflects in air.
float normalReflectance(float ior);

}  // namespace raig
