/// Scenes put together in tests of the double-precision reference, and rays into them.
#pragma once

#include "reference/picture.hpp"

#include <cmath>

namespace raig::test {

inline constexpr double pi = 3.14159265358979323846;

/// A scene put together triangle by triangle.
struct Builder {
    Scene scene;

    Builder() { scene.meshes.emplace_back(); }

    uint32_t material(const Material& m) {
        scene.materials.push_back(m);
        return static_cast<uint32_t>(scene.materials.size() - 1);
    }

    void triangle(const vec3& a, const vec3& b, const vec3& c, uint32_t material = 0) {
        Mesh& mesh = scene.meshes[0];
        const auto first = static_cast<uint32_t>(mesh.positions.size());
        mesh.positions.insert(mesh.positions.end(), {a, b, c});
        mesh.triangles.emplace_back(first, first + 1, first + 2);
        mesh.materials.push_back(material);
    }

    /// The parallelogram corner + [0, 1] u + [0, 1] v, its front towards u x v.
    void quad(const vec3& corner, const vec3& u, const vec3& v, uint32_t material = 0) {
        triangle(corner, corner + u, corner + u + v, material);
        triangle(corner, corner + u + v, corner + v, material);
    }
};

/// The scene, kept where the world expects it; with a material and an instance if it has none.
struct Made {
    explicit Made(Scene s) : scene(std::move(s)), geometry(flatten(withDefaults(scene))), world(scene, geometry) {}

    static const Scene& withDefaults(Scene& scene) {
        if (scene.materials.empty()) scene.materials.emplace_back();
        if (scene.instances.empty() && !scene.meshes.empty()) scene.instances.emplace_back();
        return scene;
    }

    Scene scene;
    Geometry geometry;
    reference::World world;
};

/// Matte, and reflects all light.
inline Material white() {
    Material m;
    m.baseColor = vec3(1.0f);
    return m;
}

/// Matte and black, and glows.
inline Material lamp(float radiance) {
    Material m;
    m.baseColor = vec3(0.0f);
    m.emission = vec3(radiance);
    return m;
}

/// Smooth and without colour: glass of that index of refraction, solid unless `thin`.
inline Material clear(float ior, bool thin = false) {
    Material m;
    m.baseColor = vec3(1.0f);
    m.roughness = 0.0f;
    m.transmission = 1.0f;
    m.ior = ior;
    m.thin = thin;
    return m;
}

/// A ray from one point through another, of direction of length 1.
inline reference::Ray rayTo(const dvec3& origin, const dvec3& target) {
    return {origin, glm::normalize(target - origin)};
}

/// How deep rays go and how little they may carry; the seed is 0.
inline reference::Bounds bounds(uint32_t maxDepth, float minContribution = 0.0f) {
    return {maxDepth, minContribution, /* seed= */ 0};
}

/// A closed sphere of float corners, faces outwards: `rings` rows of 2 `rings` quads.
inline Scene closedSphere(uint32_t rings, float radius, const vec3& centre) {
    Builder builder;
    const uint32_t around = 2 * rings;
    const auto point = [&](uint32_t ring, uint32_t step) {
        const double theta = pi * ring / rings, phi = 2.0 * pi * (step % around) / around;
        if (ring == 0 || ring == rings) return centre + radius * vec3(0.0f, ring == 0 ? 1.0f : -1.0f, 0.0f);
        return centre + radius * vec3(std::sin(theta) * std::cos(phi), std::cos(theta), std::sin(theta) * std::sin(phi));
    };
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t step = 0; step < around; ++step) {
            if (ring > 0) builder.triangle(point(ring, step), point(ring, step + 1), point(ring + 1, step));
            if (ring + 1 < rings) builder.triangle(point(ring, step + 1), point(ring + 1, step + 1), point(ring + 1, step));
        }
    return builder.scene;
}

}  // namespace raig::test
