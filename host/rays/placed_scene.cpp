#include "rays/placed_scene.hpp"

#include "base/error.hpp"

namespace raig {

TriangleCounts countTriangles(const Scene& scene, const KeepRule& rule) {
    std::vector<uint32_t> places(scene.meshes.size(), 0);
    for (const Instance& instance : scene.instances) ++places[instance.mesh];
    TriangleCounts counts;
    for (size_t i = 0; i < scene.meshes.size(); ++i) {
        const uint64_t triangles = scene.meshes[i].triangles.size(), spheres = scene.meshes[i].spheres.size();
        const bool keeps = places[i] > 1 && triangles >= rule.leastTriangles;
        counts.writtenOut += (triangles + spheres) * places[i];
        counts.stored += triangles * (keeps ? 1 : places[i]) + spheres * places[i];
    }
    return counts;
}

PlacedScene placedScene(const Geometry& geometry, const KeepRule& rule) {
    RAIG_CHECK(geometry.isInstanced() && rule.leastTriangles > 0);
    PlacedScene scene;
    scene.positions = geometry.positions;
    scene.bounds = geometry.bounds;
    scene.leastTriangles = rule.leastTriangles;
    for (const Geometry::Stored& stored : geometry.stored)
        scene.meshes.push_back({std::span(geometry.triangles).subspan(stored.firstTriangle, stored.triangles),
                                stored.firstVertex, stored.vertices, stored.triangles >= rule.leastTriangles});
    for (size_t i = 0; i < geometry.placed.size(); ++i) {
        const Geometry::Placed& placed = geometry.placed[i];
        scene.instances.push_back({placed.mesh, geometry.firstTriangle[i], placed.placement, placed.mirrored});
        const Geometry::Stored& stored = geometry.stored[placed.mesh];
        for (uint32_t k = 0; k < stored.spheres; ++k) {
            const Sphere& sphere = geometry.spheres[placed.firstSphere + k];
            scene.others.push_back({Primitive::sphere(sphere.centre, sphere.radius),
                                    geometry.firstTriangle[i] + stored.triangles + k});
        }
    }
    return scene;
}

}  // namespace raig
