#include "scene/spheres.hpp"

#include "base/error.hpp"
#include "scene/geometry.hpp"

#include <map>
#include <numbers>

namespace raig {

namespace {

constexpr uint32_t columns = 64, rings = 32;
constexpr size_t facesOfSphere = size_t{2} * columns * (rings - 1);

/// Of all written out spheres: 60 bytes of a file may ask for one, which takes 114 KB here and 1 MB to build a structure.
constexpr size_t mostFaces = size_t{1} << 21;

/// The direction of a corner; all columns meet at the poles.
dvec3 cornerOf(uint32_t ring, uint32_t column) {
    if (ring == 0 || ring == rings) return {0.0, ring == 0 ? 1.0 : -1.0, 0.0};
    const double theta = std::numbers::pi * ring / rings, phi = 2.0 * std::numbers::pi * (column % columns) / columns;
    return {std::sin(theta) * std::sin(phi), std::cos(theta), std::sin(theta) * std::cos(phi)};
}

/// Faces run counterclockwise as seen from outside.
void appendFaces(const Sphere& sphere, uint32_t material, Mesh& mesh, std::vector<uint32_t>& materials) {
    const auto first = static_cast<uint32_t>(mesh.positions.size());
    for (uint32_t ring = 0; ring <= rings; ++ring)
        for (uint32_t column = 0; column < columns; ++column) {
            const dvec3 way = cornerOf(ring, column);
            mesh.positions.emplace_back(dvec3(sphere.centre) + double{sphere.radius} * way);
            mesh.normals.emplace_back(way);
        }
    const auto corner = [&](uint32_t ring, uint32_t column) { return first + ring * columns + column % columns; };
    for (uint32_t ring = 0; ring < rings; ++ring)
        for (uint32_t column = 0; column < columns; ++column) {
            if (ring > 0)
                mesh.triangles.emplace_back(corner(ring, column), corner(ring + 1, column), corner(ring, column + 1));
            if (ring + 1 < rings)
                mesh.triangles.emplace_back(corner(ring, column + 1), corner(ring + 1, column),
                                            corner(ring + 1, column + 1));
        }
    materials.resize(mesh.triangles.size(), material);
}

Mesh withoutSpheres(const Mesh& source) {
    Mesh mesh = source;
    mesh.spheres.clear();
    mesh.normals.resize(mesh.positions.size(), vec3(0.0f));
    std::vector<uint32_t> materials(source.materials.begin(),
                                    source.materials.begin() + static_cast<long>(source.triangles.size()));
    for (size_t i = 0; i < source.spheres.size(); ++i)
        appendFaces(source.spheres[i], source.materials[source.triangles.size() + i], mesh, materials);
    mesh.materials = std::move(materials);
    if (!mesh.tangents.empty()) mesh.tangents.resize(mesh.positions.size(), vec4(0.0f));
    if (!mesh.uvs.empty()) mesh.uvs.resize(mesh.positions.size(), vec2(0.0f));
    if (!mesh.moreUvs.empty()) mesh.moreUvs.resize(mesh.positions.size(), vec2(0.0f));
    if (!mesh.colors.empty()) mesh.colors.resize(mesh.positions.size(), vec3(1.0f));
    if (!mesh.alphas.empty()) mesh.alphas.resize(mesh.positions.size(), 1.0f);
    return mesh;
}

}  // namespace

size_t writeOutDeformedSpheres(Scene& scene, const std::string& file) {
    std::map<uint32_t, uint32_t> copies;
    size_t replaced = 0, faces = 0;
    for (Instance& instance : scene.instances) {
        const size_t spheres = scene.meshes[instance.mesh].spheres.size();
        if (spheres == 0 || uniformScale(instance.toWorld)) continue;
        const auto [copy, isNew] = copies.try_emplace(instance.mesh, static_cast<uint32_t>(scene.meshes.size()));
        if (isNew) {
            faces += facesOfSphere * spheres;
            if (faces > mostFaces)
                throw limitError("{}#/meshes/{}: spheres that nodes scale unevenly are written out; at most {} can be", file,
                                 instance.mesh, mostFaces / facesOfSphere);
            scene.meshes.push_back(withoutSpheres(scene.meshes[instance.mesh]));
        }
        instance.mesh = copy->second;
        replaced += spheres;
    }
    return replaced;
}

}  // namespace raig
