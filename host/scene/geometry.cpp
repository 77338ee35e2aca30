#include "scene/geometry.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>

namespace raig {

namespace {

/// Where each instance's vertices begin, and the total at the end.
std::vector<size_t> firstVertices(const Scene& scene) {
    std::vector<size_t> first{0};
    for (const Instance& instance : scene.instances)
        first.push_back(first.back() + scene.meshes[instance.mesh].positions.size());
    return first;
}

void transformVertices(const Mesh& mesh, const dmat4& toWorld, size_t first, Geometry& geometry) {
    const glm::dmat3 linear(toWorld);
    // Of the inverse transpose only the direction matters: the cofactors have it even where no inverse exists.
    const glm::dmat3 cofactors(glm::cross(linear[1], linear[2]), glm::cross(linear[2], linear[0]),
                               glm::cross(linear[0], linear[1]));
    const double side = glm::dot(linear[0], cofactors[0]) < 0.0 ? -1.0 : 1.0;
    parallelFor(mesh.positions.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            geometry.positions[first + i] = placePoint(toWorld, mesh.positions[i]);
            if (!mesh.normals.empty()) {
                const dvec3 n = side * (cofactors * dvec3(mesh.normals[i]));
                const double length = glm::length(n);
                geometry.normals[first + i] = length > 0.0 && std::isfinite(length) ? vec3(n / length) : vec3(0.0f);
            }
            if (!mesh.uvs.empty()) geometry.uvs[first + i] = mesh.uvs[i];
            if (!mesh.colors.empty()) geometry.colors[first + i] = mesh.colors[i];
        }
    });
}

/// Copies the triangles, offset to the instance's vertices. A mirroring transform swaps two corners, so that the front
/// stays the front.
void copyTriangles(const Mesh& mesh, const dmat4& toWorld, size_t firstVertex, size_t first, Geometry& geometry) {
    const bool mirrors = glm::determinant(glm::dmat3(toWorld)) < 0.0;
    parallelFor(mesh.triangles.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = mesh.triangles[i] + static_cast<uint32_t>(firstVertex);
            geometry.triangles[first + i] = mirrors ? uvec3(t.x, t.z, t.y) : t;
            geometry.materials[first + i] = mesh.materials[i];
        }
    });
}

void copySpheres(const Mesh& mesh, const dmat4& toWorld, size_t first, Geometry& geometry) {
    for (const Sphere& sphere : mesh.spheres) {
        geometry.triangles[first] = uvec3(geometry.spheres.size(), Geometry::noVertex, Geometry::noVertex);
        geometry.materials[first] = mesh.materials[first - geometry.firstTriangle.back()];
        geometry.spheres.push_back(placeSphere(toWorld, sphere));
        ++first;
    }
}

void measureSphere(const Sphere& sphere, Box& bounds, Dropped& dropped) {
    if (isUsableSphere(sphere.centre, sphere.radius)) {
        bounds.grow(sphereBox(sphere.centre, sphere.radius));
    } else if (isInRange(sphere.centre) && sphere.radius <= 0.0f) {
        ++dropped.zeroArea;
    } else {
        ++dropped.nonFinite;
    }
}

/// Fills in the bounds of the usable primitives and counts the others.
void measure(Geometry& geometry) {
    std::mutex mutex;
    parallelFor(geometry.triangles.size(), 16384, [&](size_t begin, size_t end) {
        Box bounds;
        Dropped dropped;
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = geometry.triangles[i];
            if (geometry.isSphere(static_cast<uint32_t>(i))) {
                measureSphere(geometry.spheres[t.x], bounds, dropped);
                continue;
            }
            const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
            if (isUsable(a, b, c)) {
                bounds.grow(a);
                bounds.grow(b);
                bounds.grow(c);
            } else if (isInRange(a) && isInRange(b) && isInRange(c)) {
                ++dropped.zeroArea;
            } else {
                ++dropped.nonFinite;
            }
        }
        const std::lock_guard lock(mutex);
        geometry.bounds.grow(bounds);
        geometry.dropped.zeroArea += dropped.zeroArea;
        geometry.dropped.nonFinite += dropped.nonFinite;
    });
}

}  // namespace

Geometry::Place Geometry::place(uint32_t index) const {
    RAIG_CHECK_OP(index, <, triangles.size());
    const auto after = std::upper_bound(firstTriangle.begin(), firstTriangle.end(), index);
    const auto instance = static_cast<uint32_t>(after - firstTriangle.begin()) - 1;
    return {instance, index - firstTriangle[instance]};
}

std::optional<double> uniformScale(const dmat4& toWorld) {
    const glm::dmat3 linear(toWorld);
    const double squared =
        (glm::dot(linear[0], linear[0]) + glm::dot(linear[1], linear[1]) + glm::dot(linear[2], linear[2])) / 3.0;
    if (squared == 0.0) return 0.0;
    for (int i = 0; i < 3; ++i) {
        const double along = glm::dot(linear[i], linear[i]), across = glm::dot(linear[i], linear[(i + 1) % 3]);
        // Half the difference of squares is that of lengths.
        if (!(std::abs(along - squared) <= 0x1p-15 * squared && std::abs(across) <= 0x1p-16 * squared)) return std::nullopt;
    }
    return std::sqrt(squared);
}

Sphere placeSphere(const dmat4& toWorld, const Sphere& sphere) {
    const std::optional<double> scale = uniformScale(toWorld);
    RAIG_CHECK(scale.has_value());
    return {placePoint(toWorld, sphere.centre), static_cast<float>(*scale * sphere.radius)};
}

Geometry flatten(const Scene& scene) {
    const std::vector<size_t> firstVertex = firstVertices(scene);
    size_t triangleCount = 0;
    bool anyNormals = false, anyUvs = false, anyColors = false;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        triangleCount += mesh.primitiveCount();
        anyNormals |= !mesh.normals.empty();
        anyUvs |= !mesh.uvs.empty();
        anyColors |= !mesh.colors.empty();
    }
    if (triangleCount > 0x7ffffffe || firstVertex.back() > 0xfffffffe)
        throw limitError("the scene has {} triangles and spheres with its instances written out; at most {} can be traced",
                         triangleCount, 0x7ffffffe);

    Geometry geometry;
    geometry.positions.resize(firstVertex.back());
    if (anyNormals) geometry.normals.resize(firstVertex.back(), vec3(0.0f));
    if (anyUvs) geometry.uvs.resize(firstVertex.back(), vec2(0.0f));
    if (anyColors) geometry.colors.resize(firstVertex.back(), vec3(1.0f));
    geometry.triangles.resize(triangleCount);
    geometry.materials.resize(triangleCount);
    geometry.firstTriangle.push_back(0);
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const Instance& instance = scene.instances[i];
        const Mesh& mesh = scene.meshes[instance.mesh];
        transformVertices(mesh, instance.toWorld, firstVertex[i], geometry);
        copyTriangles(mesh, instance.toWorld, firstVertex[i], geometry.firstTriangle.back(), geometry);
        copySpheres(mesh, instance.toWorld, geometry.firstTriangle.back() + mesh.triangles.size(), geometry);
        geometry.firstTriangle.push_back(geometry.firstTriangle.back() + static_cast<uint32_t>(mesh.primitiveCount()));
    }
    measure(geometry);
    geometry.dropped.other = scene.otherPrimitives;
    return geometry;
}

}  // namespace raig
