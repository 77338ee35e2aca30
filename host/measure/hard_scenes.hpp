/// Small scenes that the hard cases of pictures are made of.
#pragma once

#include "rays/frame.hpp"
#include "scene/scene.hpp"

#include <functional>
#include <vector>

namespace raig::hard {

/// Glass of that index, solid and clear; a mirror; and what glows and reflects nothing.
Material glass(float ior);
Material mirror(float reflectance);
Material glowing(float radiance);

/// Adds a mesh of its own where it stands.
Mesh& addMesh(raig::Scene& scene, std::vector<vec3> positions, std::vector<uvec3> triangles, const Material& material);
/// The parallelogram at `corner`; its front is where u, v and the viewer's side are right-handed.
void addQuad(raig::Scene& scene, const vec3& corner, const vec3& u, const vec3& v, const Material& material);
/// A closed box, fronts outwards.
void addBox(raig::Scene& scene, const vec3& lo, const vec3& hi, const Material& material);
/// A closed mesh of rings x 2 rings, fronts outwards.
void addBall(raig::Scene& scene, const vec3& centre, float radius, uint32_t rings, const Material& material);
/// A sphere that is one.
void addSphere(raig::Scene& scene, const vec3& centre, float radius, const Material& material);

/// Light of radiance 1 from everywhere.
raig::Scene whiteSky();

/// A camera at `eye` that looks along `forward`.
Camera cameraAt(const vec3& eye, const vec3& forward, float yfov);

/// The ray of a pixel of a picture of the scene. Not for use by two threads at once: those of the last picture are kept.
std::function<Ray(const FrameOptions& options, size_t pixel)> pixelRays(const raig::Scene& scene);

/// One sample through each pixel's centre.
FrameOptions pictureOf(uint32_t width, uint32_t height, uint32_t maxDepth, float minContribution = 0.0f);

}  // namespace raig::hard
