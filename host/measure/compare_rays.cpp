#include "measure/compare_rays.hpp"

#include "base/parallel.hpp"
#include "measure/compare.hpp"
#include "reference/sampling.hpp"

#include <algorithm>

namespace raig {

namespace {

constexpr float farAway = 3.4e38f;

/// A direction evenly spread over the sphere.
dvec3 anyDirection(uint32_t index) {
    const dvec2 place = reference::sample2(index, 0, 0, /* seed= */ 0xb0uL);
    const double z = 2.0 * place.x - 1.0, r = std::sqrt(1.0 - z * z), phi = 6.283185307179586 * place.y;
    return {r * std::cos(phi), r * std::sin(phi), z};
}

}  // namespace

std::vector<Ray> bounceRays(const reference::Tree& tree, std::span<const Ray> rays) {
    const Geometry& geometry = tree.geometry();
    std::vector<Ray> bounced(rays.size(), Ray{vec3(0.0f), 1.0f, vec3(0.0f), 0.0f});
    parallelFor(rays.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const reference::Hit hit = tree.closest(widen(rays[i]));
            if (hit.primitive == reference::noTriangle) continue;
            const uvec3 t = geometry.triangles[hit.primitive];
            const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
            const dvec3 face = glm::normalize(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            const dvec3 normal = glm::dot(face, dvec3(rays[i].direction)) < 0.0 ? face : -face;
            const dvec3 point = (1.0 - hit.u - hit.v) * dvec3(a) + hit.u * dvec3(b) + hit.v * dvec3(c);
            const dvec3 d = anyDirection(static_cast<uint32_t>(i));
            bounced[i] = {vec3(point + positionTolerance(rays[i], a, b, c) * normal), 0.0f,
                          vec3(glm::dot(d, normal) < 0.0 ? -d : d), farAway};
        }
    });
    std::erase_if(bounced, [](const Ray& ray) { return ray.tMin > ray.tMax; });
    return bounced;
}

std::vector<Ray> aimedRays(const Geometry& geometry, const vec3& eye, size_t count) {
    std::vector<Ray> rays;
    if (geometry.bounds.empty()) return rays;
    for (uint32_t i = 0; rays.size() < count; ++i) {
        const uvec3 t = geometry.triangles[reference::hash(i, 0xa1u) % geometry.triangles.size()];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (!isUsable(a, b, c)) continue;
        const double along = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.5 : reference::hash(i, 0xa2u) * 0x1p-32;
        const vec3 direction = vec3(glm::mix(dvec3(a), dvec3(b), along) - dvec3(eye));
        rays.push_back({eye, 0.0f, direction, farAway});
    }
    return rays;
}

}  // namespace raig
