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

struct Place {
    dvec3 point;
    dvec3 outwards;  ///< unit
};

Place placeOf(const Geometry& geometry, const Ray& ray, const reference::Hit& hit) {
    if (geometry.isSphere(hit.primitive)) {
        const dvec3 point = dvec3(ray.origin) + hit.t * dvec3(ray.direction);
        return {point, glm::normalize(point - dvec3(geometry.sphere(hit.primitive).centre))};
    }
    const uvec3 t = geometry.triangles[hit.primitive];
    const dvec3 a(geometry.positions[t.x]), b(geometry.positions[t.y]), c(geometry.positions[t.z]);
    return {(1.0 - hit.u - hit.v) * a + hit.u * b + hit.v * c, glm::normalize(glm::cross(b - a, c - a))};
}

/// A ray through the sphere's centre or past its silhouette; from inside, where it has none, to any point of it.
vec3 directionAt(const Sphere& sphere, const vec3& eye, uint32_t i) {
    const dvec3 away = dvec3(sphere.centre) - dvec3(eye);
    const double distance = glm::length(away);
    if (!(distance > sphere.radius)) return vec3(away + double{sphere.radius} * anyDirection(i));
    const dvec3 aside = glm::cross(away, anyDirection(i));
    const double sine = sphere.radius / distance;
    if (i % 3 == 0 || !(glm::length(aside) > 0.0)) return vec3(away);
    const dvec3 tangent = away * (1.0 - sine * sine) + sphere.radius * std::sqrt(1.0 - sine * sine) * glm::normalize(aside);
    return vec3(tangent);
}

}  // namespace

std::vector<Ray> bounceRays(const reference::Tree& tree, std::span<const Ray> rays) {
    const Geometry& geometry = tree.geometry();
    std::vector<Ray> bounced(rays.size(), Ray{vec3(0.0f), 1.0f, vec3(0.0f), 0.0f});
    parallelFor(rays.size(), 256, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const reference::Hit hit = tree.closest(widen(rays[i]));
            if (hit.primitive == reference::noTriangle) continue;
            const Place place = placeOf(geometry, rays[i], hit);
            const dvec3 normal = glm::dot(place.outwards, dvec3(rays[i].direction)) < 0.0 ? place.outwards : -place.outwards;
            const dvec3 d = anyDirection(static_cast<uint32_t>(i));
            const double away = positionTolerance(geometry, rays[i], hit.primitive);
            bounced[i] = {vec3(place.point + away * normal), 0.0f, vec3(glm::dot(d, normal) < 0.0 ? -d : d), farAway};
        }
    });
    std::erase_if(bounced, [](const Ray& ray) { return ray.tMin > ray.tMax; });
    return bounced;
}

std::vector<Ray> aimedRays(const Geometry& geometry, const vec3& eye, size_t count) {
    std::vector<Ray> rays;
    if (geometry.bounds.empty()) return rays;
    for (uint32_t i = 0; rays.size() < count; ++i) {
        const auto id = static_cast<uint32_t>(reference::hash(i, 0xa1u) % geometry.triangles.size());
        if (geometry.isSphere(id)) {
            const Sphere& sphere = geometry.sphere(id);
            if (isUsableSphere(sphere.centre, sphere.radius))
                rays.push_back({eye, 0.0f, directionAt(sphere, eye, i), farAway});
            continue;
        }
        const uvec3 t = geometry.triangles[id];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (!isUsable(a, b, c)) continue;
        const double along = i % 3 == 0 ? 0.0 : i % 3 == 1 ? 0.5 : reference::hash(i, 0xa2u) * 0x1p-32;
        const vec3 direction = vec3(glm::mix(dvec3(a), dvec3(b), along) - dvec3(eye));
        rays.push_back({eye, 0.0f, direction, farAway});
    }
    return rays;
}

}  // namespace raig
