#include "scene/geometry.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"

#include <algorithm>
#include <atomic>
#include <mutex>
#include <string_view>

namespace raig {

namespace {

/// How many vertices and triangles the instances have, and which attributes.
struct Extent {
    uint64_t vertices = 0, primitives = 0;
    bool anyNormals = false, anyTangents = false, anyUvs = false, anyMoreUvs = false, anyColors = false, anyAlphas = false;

    void add(const Mesh& mesh) {
        vertices += mesh.positions.size();
        primitives += mesh.primitiveCount();
        anyNormals |= !mesh.normals.empty();
        anyTangents |= !mesh.tangents.empty();
        anyUvs |= !mesh.uvs.empty();
        anyMoreUvs |= !mesh.moreUvs.empty();
        anyColors |= !mesh.colors.empty();
        anyAlphas |= !mesh.alphas.empty();
    }
};

void makeRoom(const Extent& extent, Geometry& geometry) {
    geometry.positions.resize(extent.vertices);
    if (extent.anyNormals) geometry.normals.resize(extent.vertices, vec3(0.0f));
    if (extent.anyTangents) geometry.tangents.resize(extent.vertices, vec4(0.0f));
    if (extent.anyUvs) geometry.uvs.resize(extent.vertices, vec2(0.0f));
    if (extent.anyMoreUvs) geometry.moreUvs.resize(extent.vertices, vec2(0.0f));
    if (extent.anyColors) geometry.colors.resize(extent.vertices, vec3(1.0f));
    if (extent.anyAlphas) geometry.alphas.resize(extent.vertices, 1.0f);
    geometry.triangles.resize(extent.primitives);
    geometry.materials.resize(extent.primitives);
}

void checkVertices(uint64_t vertices, std::string_view how) {
    if (vertices > 0xfffffffd)
        throw limitError("the scene has {} vertices with its instances {}; at most {} can be traced", vertices, how,
                         0xfffffffd);
}

void transformVertices(const Mesh& mesh, const dmat4& toWorld, size_t first, Geometry& geometry) {
    const Placement placement = placementOf(toWorld);
    const NormalPlacement normalPlacement = normalPlacementOf(toWorld);
    const float handedness = mirrors(toWorld) ? -1.0f : 1.0f;
    parallelFor(mesh.positions.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            geometry.positions[first + i] = placePoint(placement, mesh.positions[i]);
            if (!mesh.normals.empty()) geometry.normals[first + i] = placeNormal(normalPlacement, mesh.normals[i]);
            if (!mesh.tangents.empty())
                geometry.tangents[first + i] =
                    vec4(placeTangent(placement, mesh.tangents[i]), handedness * mesh.tangents[i].w);
            if (!mesh.uvs.empty()) geometry.uvs[first + i] = mesh.uvs[i];
            if (!mesh.moreUvs.empty()) geometry.moreUvs[first + i] = mesh.moreUvs[i];
            if (!mesh.colors.empty()) geometry.colors[first + i] = mesh.colors[i];
            if (!mesh.alphas.empty()) geometry.alphas[first + i] = mesh.alphas[i];
        }
    });
}

/// Copies the triangles, offset to the instance's vertices. A mirroring transform swaps two corners, so that the front
/// stays the front.
void copyTriangles(const Mesh& mesh, const dmat4& toWorld, size_t firstVertex, size_t first, Geometry& geometry) {
    const bool swaps = mirrors(toWorld);
    parallelFor(mesh.triangles.size(), 16384, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) {
            const uvec3 t = mesh.triangles[i] + static_cast<uint32_t>(firstVertex);
            geometry.triangles[first + i] = swaps ? uvec3(t.x, t.z, t.y) : t;
            geometry.materials[first + i] = mesh.materials[i];
        }
    });
}

/// Writes out the mesh's spheres, as primitives from `first` on.
void copySpheres(const Mesh& mesh, const dmat4& toWorld, size_t first, Geometry& geometry) {
    for (const Sphere& sphere : mesh.spheres) {
        geometry.triangles[first] = uvec3(geometry.spheres.size(), Geometry::noVertex, Geometry::noVertex);
        geometry.materials[first] = mesh.materials[first - geometry.firstTriangle.back()];
        geometry.spheres.push_back(placeSphere(toWorld, sphere));
        ++first;
    }
}

/// Takes usable spheres into the bounds, and counts the others.
void measureSpheres(std::span<const Sphere> spheres, Geometry& geometry) {
    for (const Sphere& sphere : spheres) {
        if (isUsableSphere(sphere.centre, sphere.radius))
            geometry.bounds.grow(sphereBox(sphere.centre, sphere.radius));
        else
            ++(isInRange(sphere.centre) && sphere.radius <= 0.0f ? geometry.dropped.zeroArea : geometry.dropped.nonFinite);
    }
}

/// True if the triangle is usable; if not, it is counted.
bool isUsableOrCounted(const Geometry::Corners& t, Dropped& dropped) {
    if (isUsable(t.a, t.b, t.c)) return true;
    ++(isInRange(t.a) && isInRange(t.b) && isInRange(t.c) ? dropped.zeroArea : dropped.nonFinite);
    return false;
}

/// Takes the usable ones of so many triangles into the bounds, and counts the others. `cornersOf(i)` are in the world.
template <class CornersOf>
void measure(size_t triangles, const CornersOf& cornersOf, Geometry& geometry) {
    std::mutex mutex;
    parallelFor(triangles, 16384, [&](size_t begin, size_t end) {
        Box bounds;
        Dropped dropped;
        for (size_t i = begin; i < end; ++i) {
            const Geometry::Corners t = cornersOf(i);
            if (!isUsableOrCounted(t, dropped)) continue;
            bounds.grow(t.a);
            bounds.grow(t.b);
            bounds.grow(t.c);
        }
        const std::lock_guard lock(mutex);
        geometry.bounds.grow(bounds);
        geometry.dropped.zeroArea += dropped.zeroArea;
        geometry.dropped.nonFinite += dropped.nonFinite;
    });
}

/// Copies a mesh's arrays to where `stored` says.
void storeMesh(const Mesh& mesh, const Geometry::Stored& stored, Geometry& geometry) {
    std::ranges::copy(mesh.positions, geometry.positions.begin() + stored.firstVertex);
    std::ranges::copy(mesh.normals, geometry.normals.begin() + (mesh.normals.empty() ? 0 : stored.firstVertex));
    std::ranges::copy(mesh.tangents, geometry.tangents.begin() + (mesh.tangents.empty() ? 0 : stored.firstVertex));
    std::ranges::copy(mesh.uvs, geometry.uvs.begin() + (mesh.uvs.empty() ? 0 : stored.firstVertex));
    std::ranges::copy(mesh.moreUvs, geometry.moreUvs.begin() + (mesh.moreUvs.empty() ? 0 : stored.firstVertex));
    std::ranges::copy(mesh.colors, geometry.colors.begin() + (mesh.colors.empty() ? 0 : stored.firstVertex));
    std::ranges::copy(mesh.alphas, geometry.alphas.begin() + (mesh.alphas.empty() ? 0 : stored.firstVertex));
    for (size_t i = 0; i < mesh.triangles.size(); ++i)
        geometry.triangles[stored.firstTriangle + i] = mesh.triangles[i] + stored.firstVertex;
    for (uint32_t i = 0; i < stored.spheres; ++i)
        geometry.triangles[stored.firstTriangle + stored.triangles + i] = {i, Geometry::noVertex, Geometry::noVertex};
    std::ranges::copy(mesh.materials, geometry.materials.begin() + stored.firstTriangle);
}

}  // namespace

Geometry::Place Geometry::place(uint32_t index) const {
    RAIG_CHECK_OP(index, <, primitiveCount());
    const auto after = std::upper_bound(firstTriangle.begin(), firstTriangle.end(), index);
    const auto instance = static_cast<uint32_t>(after - firstTriangle.begin()) - 1;
    return {instance, index - firstTriangle[instance]};
}

size_t Geometry::storedTriangle(const Place& place) const {
    if (!isInstanced()) return size_t{firstTriangle[place.instance]} + place.primitive;
    return size_t{stored[placed[place.instance].mesh].firstTriangle} + place.primitive;
}

Geometry::Corners Geometry::corners(const Place& place) const {
    const uvec3 t = triangles[storedTriangle(place)];
    if (!isInstanced()) return {positions[t.x], positions[t.y], positions[t.z]};
    const Placed& instance = placed[place.instance];
    const vec3 a = placePoint(instance.placement, positions[t.x]);
    const vec3 b = placePoint(instance.placement, positions[t.y]);
    const vec3 c = placePoint(instance.placement, positions[t.z]);
    return instance.mirrored ? Corners{a, c, b} : Corners{a, b, c};
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
    return {placePoint(placementOf(toWorld), sphere.centre), static_cast<float>(*scale * sphere.radius)};
}

void checkPrimitiveCount(const Scene& scene) {
    uint64_t primitives = 0;
    for (const Instance& instance : scene.instances) primitives += scene.meshes[instance.mesh].primitiveCount();
    if (primitives > 0x7ffffffe)
        throw limitError("the scene has {} triangles and spheres with its instances written out; at most {} can be traced",
                         primitives, 0x7ffffffe);
}

Geometry flatten(const Scene& scene) {
    checkPrimitiveCount(scene);
    Extent extent;
    for (const Instance& instance : scene.instances) extent.add(scene.meshes[instance.mesh]);
    checkVertices(extent.vertices, "written out");

    Geometry geometry;
    makeRoom(extent, geometry);
    geometry.firstTriangle.push_back(0);
    size_t firstVertex = 0;
    for (const Instance& instance : scene.instances) {
        const Mesh& mesh = scene.meshes[instance.mesh];
        transformVertices(mesh, instance.toWorld, firstVertex, geometry);
        copyTriangles(mesh, instance.toWorld, firstVertex, geometry.firstTriangle.back(), geometry);
        copySpheres(mesh, instance.toWorld, geometry.firstTriangle.back() + mesh.triangles.size(), geometry);
        geometry.firstTriangle.push_back(geometry.firstTriangle.back() + static_cast<uint32_t>(mesh.primitiveCount()));
        firstVertex += mesh.positions.size();
    }
    const auto cornersOf = [&](size_t i) {
        const uvec3 t = geometry.triangles[i];
        return Geometry::Corners{geometry.positions[t.x], geometry.positions[t.y], geometry.positions[t.z]};
    };
    for (size_t i = 0; i < scene.instances.size(); ++i) {
        const size_t first = geometry.firstTriangle[i], triangles = scene.meshes[scene.instances[i].mesh].triangles.size();
        measure(triangles, [&](size_t k) { return cornersOf(first + k); }, geometry);
    }
    measureSpheres(geometry.spheres, geometry);
    geometry.dropped.other = scene.otherPrimitives;
    return geometry;
}

Geometry gatherInstances(const Scene& scene) {
    checkPrimitiveCount(scene);
    Geometry geometry;
    std::vector<uint8_t> used(scene.meshes.size());
    for (const Instance& instance : scene.instances) used[instance.mesh] = 1;
    Extent extent;
    geometry.stored.resize(scene.meshes.size());
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
        if (used[i] == 0) continue;
        const Mesh& mesh = scene.meshes[i];
        geometry.stored[i] = {static_cast<uint32_t>(extent.vertices), static_cast<uint32_t>(mesh.positions.size()),
                              static_cast<uint32_t>(extent.primitives), static_cast<uint32_t>(mesh.triangles.size()),
                              static_cast<uint32_t>(mesh.spheres.size())};
        extent.add(mesh);
    }
    checkVertices(extent.vertices, "kept");
    makeRoom(extent, geometry);
    for (size_t i = 0; i < scene.meshes.size(); ++i)
        if (used[i] != 0) storeMesh(scene.meshes[i], geometry.stored[i], geometry);

    geometry.firstTriangle.push_back(0);
    for (const Instance& instance : scene.instances) {
        const Geometry::Stored& stored = geometry.stored[instance.mesh];
        const auto index = static_cast<uint32_t>(geometry.placed.size());
        geometry.placed.push_back({instance.mesh, static_cast<uint32_t>(geometry.spheres.size()), mirrors(instance.toWorld),
                                   placementOf(instance.toWorld), normalPlacementOf(instance.toWorld)});
        for (const Sphere& sphere : scene.meshes[instance.mesh].spheres)
            geometry.spheres.push_back(placeSphere(instance.toWorld, sphere));
        const auto cornersOf = [&](size_t i) { return geometry.corners({index, static_cast<uint32_t>(i)}); };
        measure(stored.triangles, cornersOf, geometry);
        geometry.firstTriangle.push_back(geometry.firstTriangle.back() + stored.triangles + stored.spheres);
    }
    measureSpheres(geometry.spheres, geometry);
    geometry.dropped.other = scene.otherPrimitives;
    return geometry;
}

}  // namespace raig
