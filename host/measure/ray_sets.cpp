#include "measure/ray_sets.hpp"

#include "base/error.hpp"
#include "reference/sphere.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace raig {

namespace {

constexpr double farthest = 1e30;
constexpr double offset = 2e-5;  // of the distance, along the normal

dvec3 normalized(const dvec3& v) { return v / std::sqrt(glm::dot(v, v)); }

/// The output permutation of the 32-bit PCG generator, one step on [O'Neill 2014; Jarzynski, Olano 2020, "Hash Functions for
/// GPU Rendering"].
uint32_t pcg(uint32_t x) {
    const uint32_t s = x * 747796405u + 2891336453u;
    const uint32_t w = ((s >> ((s >> 28) + 4)) ^ s) * 277803737u;
    return (w >> 22) ^ w;
}

uvec2 mortonPlace(uint32_t index) {
    uvec2 place(0u);
    for (uint32_t bit = 0; bit < 3; ++bit) {
        place.x |= (index >> (2 * bit) & 1u) << bit;
        place.y |= (index >> (2 * bit + 1) & 1u) << bit;
    }
    return place;
}

/// Pixel (column, row) of the ray of that number.
uvec2 pixelOf(uint32_t index, uint32_t side) {
    const uint32_t tile = index / 64, tiles = side / 8;
    return uvec2(tile % tiles, tile / tiles) * 8u + mortonPlace(index % 64);
}

dvec3 directionThrough(const MeasuringCamera& camera, const uvec2& pixel, uint32_t side) {
    const double x = (2.0 * (pixel.x + 0.5) / side - 1.0) * camera.tanHalfFov;
    const double y = (1.0 - 2.0 * (pixel.y + 0.5) / side) * camera.tanHalfFov;
    return normalized(camera.forward + x * camera.right + y * camera.up);
}

Ray rounded(const dvec3& origin, const dvec3& direction, double tMax) {
    return {vec3(origin), 0.0f, vec3(direction), static_cast<float>(tMax)};
}

/// Cosine-distributed about n [basis: Duff et al. 2017, "Building an Orthonormal Basis, Revisited"].
dvec3 diffuseDirection(const dvec3& n, uint32_t pixel) {
    const double u1 = pcg(2 * pixel) / 4294967296.0, u2 = pcg(2 * pixel + 1) / 4294967296.0;
    const double sign = std::copysign(1.0, n.z), a = -1.0 / (sign + n.z), b = n.x * n.y * a;
    const dvec3 tangent(1.0 + sign * n.x * n.x * a, sign * b, -sign * n.x), bitangent(b, sign + n.y * n.y * a, -n.y);
    const double angle = 2.0 * std::numbers::pi * u2;
    return std::sqrt(u1) * std::cos(angle) * tangent + std::sqrt(u1) * std::sin(angle) * bitangent + std::sqrt(1.0 - u1) * n;
}

/// Where the primitive that was hit lies along the ray, and its normal there.
dvec3 normalAt(const Geometry& geometry, uint32_t primitive, const dvec3& eye, const dvec3& d, double& t) {
    if (geometry.isSphere(primitive)) {
        const Sphere& sphere = geometry.sphere(primitive);
        const auto crossing = reference::crossSphere({.origin = eye, .direction = d}, sphere.centre, sphere.radius);
        t = !crossing ? std::numeric_limits<double>::infinity() : crossing->near > 0.0 ? crossing->near : crossing->far;
        return normalized(eye + t * d - dvec3(sphere.centre));
    }
    const uvec3 corners = geometry.triangles[primitive];
    const dvec3 a(geometry.positions[corners.x]), b(geometry.positions[corners.y]), c(geometry.positions[corners.z]);
    const dvec3 n = normalized(glm::cross(b - a, c - a));
    t = glm::dot(n, a - eye) / glm::dot(n, d);
    return n;
}

}  // namespace

MeasuringCamera measuringCamera(const Geometry& geometry, const Box& framed) {
    const dvec3 centre = (dvec3(framed.lo) + dvec3(framed.hi)) * 0.5, towards = normalized(dvec3(0.5, 0.35, 1.0));
    MeasuringCamera camera;
    camera.forward = -towards;
    camera.right = normalized(glm::cross(camera.forward, dvec3(0, 1, 0)));
    camera.up = glm::cross(camera.right, camera.forward);
    camera.tanHalfFov = std::tan(std::numbers::pi / 8.0);
    double distance = 0.0;
    const auto show = [&](const vec3& position) {
        if (glm::any(glm::lessThan(position, framed.lo)) || glm::any(glm::greaterThan(position, framed.hi))) return;
        const dvec3 p = dvec3(position) - centre;
        const double across = std::max(std::abs(glm::dot(p, camera.right)), std::abs(glm::dot(p, camera.up)));
        distance = std::max(distance, across / (0.95 * camera.tanHalfFov) - glm::dot(p, camera.forward));
    };
    for (const uvec3& triangle : geometry.triangles)
        for (int corner = 0; corner < 3 && triangle.y != Geometry::noVertex; ++corner)
            show(geometry.positions[triangle[corner]]);
    for (const Sphere& sphere : geometry.spheres) {
        const Box box = sphereBox(sphere.centre, sphere.radius);
        for (int i = 0; i < 8; ++i) show(glm::mix(box.lo, box.hi, glm::bvec3(i & 1, i & 2, i & 4)));
    }
    camera.eye = centre + distance * towards;
    return camera;
}

RaySets makeRaySets(const Geometry& geometry, const Box& framed, const MeasuringCamera& camera, uint32_t side,
                    Tracer& tracer) {
    RAIG_CHECK_OP(side % 8, ==, 0u);
    RaySets sets;
    for (uint32_t i = 0; i < side * side; ++i)
        sets.primary.push_back(rounded(camera.eye, directionThrough(camera, pixelOf(i, side), side), farthest));
    std::vector<Hit> hits(sets.primary.size());
    tracer.trace(sets.primary, hits, Query::closest);

    const dvec3 centre = (dvec3(framed.lo) + dvec3(framed.hi)) * 0.5, half = (dvec3(framed.hi) - dvec3(framed.lo)) * 0.5;
    const dvec3 light = centre + 3.0 * std::sqrt(glm::dot(half, half)) * normalized(dvec3(-0.6, 1.0, 0.8));
    for (uint32_t i = 0; i < side * side; ++i) {
        if (hits[i].primitive == NO_HIT) continue;
        const uvec2 pixel = pixelOf(i, side);
        const dvec3 d = directionThrough(camera, pixel, side);
        double t = 0.0;
        dvec3 n = normalAt(geometry, hits[i].primitive, camera.eye, d, t);
        if (!std::isfinite(t)) continue;
        if (glm::dot(n, d) > 0.0) n = -n;
        const dvec3 point = camera.eye + t * d, start = point + offset * t * n, toLight = light - start;
        const double distance = std::sqrt(glm::dot(toLight, toLight));
        if (glm::dot(n, light - point) > 0.0)
            sets.shadow.push_back(rounded(start, toLight / distance, distance * (1.0 - 1e-4)));
        sets.diffuse.push_back(rounded(start, diffuseDirection(n, pixel.y * side + pixel.x), farthest));
        sets.specular.push_back(rounded(start, normalized(d - 2.0 * glm::dot(d, n) * n), farthest));
    }
    return sets;
}

}  // namespace raig
