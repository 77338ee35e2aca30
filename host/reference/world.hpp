/// What the reference shades with: surfaces, textures and lights of a scene, looked up in double precision.
#pragma once

#include "reference/media.hpp"
#include "reference/texture.hpp"
#include "reference/tree.hpp"
#include "scene/surface.hpp"

namespace raig::reference {

/// The triangles that emit light (no spheres), to be chosen in proportion to area times luminance (.2126 .7152 .0722).
struct Emitters {
    std::vector<uint32_t> triangles;  ///< usable ones with emission, by id
    std::vector<double> areas;
    std::vector<float> cumulative;  ///< shares summed in double, kept as floats; the last is exactly 1
    double glow = 0.0;  ///< the sum of areas times the luminance of the material's emission, without its texture
};

/// A scene made ready. Scene and geometry must outlive it.
struct World {
    const Scene& scene;
    const Geometry& geometry;
    Tree tree;
    std::vector<Surface> surfaces;    ///< one a material
    std::vector<uint8_t> mayPass;     ///< one a material: 1 where it may let rays pass by its alpha
    bool anyPass = false;
    std::vector<uint8_t> seeThrough;  ///< one a material: 1 where it transmits, and so casts no shadow
    std::vector<uint32_t> media;      ///< one a material: closedMedia()
    Emitters emitters;
    Pyramids pyramids;

    /// Requires `geometry` to be flatten(scene). Cost: that of Tree.
    World(const Scene& scene, const Geometry& geometry);
};

/// A material as it is at a point, textures and vertex colours applied, in the terms of scene/surface.hpp.
struct LocalSurface {
    dvec3 diffuse{0.0};       ///< before the share that the dielectric mirrors is taken off
    double metallic = 0.0;    ///< the share that is metal; the rest is a dielectric
    dvec3 metal{0.0};         ///< what the metal reflects along the normal; at grazing it reflects all
    double dielectric = 0.0;  ///< what the dielectric reflects along the normal ...
    double grazing = 0.0;     ///< ... and at grazing
    double gloss = 0.0;
    double roughness = 1.0;
    dvec3 transmission{0.0};
    bool transmits = false;  ///< without textures: the surface is of the kind that lets light through
    double ior = 1.5;
    bool thin = true;
    dvec3 absorption{0.0};
    dvec3 emission{0.0};
    double coverage = 1.0;  ///< how much of it is there: the rest of the light passes straight on
    double openness = 1.0;  ///< the share of ambient light that arrives
};

/// A point on a surface, as shading needs it.
struct SurfacePoint {
    LocalSurface surface;
    uint32_t medium;  ///< that it holds, or noMedium
    dvec3 position;
    dvec3 faceNormal;     ///< unit, by the corners' order; of a sphere, outwards
    dvec3 normal;         ///< unit, the face's, turned against the ray
    dvec3 smoothNormal;   ///< unit, interpolated, on the side of `normal`
    dvec3 shadingNormal;  ///< unit, that bent by the normal texture, turned against the ray
    dvec3 lift;           ///< from there to where shadow rays start
    bool front;
    double magnitude;  ///< the largest coordinate that went into the position: corners, and corners seen from the origin
};

/// The point that `ray` (unit direction) hits; `width` is how wide the ray is there.
///
/// The shading normal is the interpolated one where every corner has one and their blend is at least 1e-3 long, else the
/// face's. The normal texture's x, y and z are along the tangent, across it, and along that normal, all of the front: the
/// tangent is where the texture's u grows, made perpendicular to the normal, from the vertices where all have one, else from
/// the triangle's texture coordinates; across is -v. What then faces the ray at a cosine c < 1/1024 is bent towards where
/// it comes from, unless it is the face's own: 1/1024 - c times the way there is added.
///
/// A texture's square (reference/texture.hpp) is as wide as the ray's ellipse on the triangle is long, `width` over the
/// cosine, in texture coordinates by the triangle's areas in these and in the world.
/// lift is zero where the geometry has no normals, and a vertex without one adds nothing to it. Else the point is brought
/// into the plane across the normal at each vertex if it lies below it; the lift goes to the mean of these three points,
/// unless that lies below the face [Hanika 2021, "Hacking the Shadow Terminator"].
SurfacePoint surfaceAt(const World& world, const Ray& ray, const Hit& hit, double width);

/// The coverage of what is hit, textures unfiltered: alpha, times the base colour texture's and the vertices' where it
/// varies; where there is a cutoff, 1 from that on, else 0.
double coverageAt(const World& world, const Hit& hit);

/// The sky's radiance in direction d (unit): blended by height d.y from horizon to zenith, and below from horizon to ground.
dvec3 skyRadiance(const Sky& sky, const dvec3& d);

/// A light seen from a point: the irradiance it would cause there on a surface of normal `shadingNormal`, were nothing in
/// between; its direction (unit), and where it is (for a directional light: a unit step towards it, and isFar).
struct Arriving {
    dvec3 irradiance{0.0};
    dvec3 direction{0.0};
    dvec3 position{0.0};
    bool isFar = false;
    bool castsShadows = true;
    uint32_t triangle = noTriangle;  ///< the emitter's
    bool isDrawn = false;            ///< at random
    double density = 0.0;            ///< by solid angle, with which a path takes it to be drawn
};

/// Light `light` at `position`. Point and spot lights fall off by the square of the distance, reach no farther than their
/// range where they have one, and spots by the square of a ramp between the cosines of their cone angles
/// [KHR_lights_punctual, glTF 2.0].
Arriving arriving(const Light& light, const dvec3& position, const dvec3& shadingNormal);

/// The density, by area, with which a path takes points of a triangle of that material to be drawn: the luminance of its
/// emission, without its texture, over Emitters::glow. (They are drawn by that with the mean of the texture.)
double glowOf(const World& world, uint32_t material);

/// A random point of a random emitter, as a light: its irradiance is divided by the chance per area of that point.
///
/// Requires  at least one emitter; `choice` in [0, 1) chooses it, (u1, u2) in [0, 1)^2 the point on it, evenly by area.
/// Ensures   the mean over uniform choices is the irradiance of all emitters together.
/// Source    Turk 1990, "Generating Random Points in Triangles".
Arriving arrivingFromEmitters(const World& world, double choice, const dvec2& place, const dvec3& position,
                              const dvec3& shadingNormal);

}  // namespace raig::reference
