#include "measure/scene_numbers.hpp"

#include "base/parallel.hpp"
#include "scene/surface.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

// In cube roots of their number, triangles crowd by 0.4 in the bunny, 2 in a pool table, 7 in fzk_haus, 15 in glassware; by
// 24 in white_room, 217 in classroom (which stands on a wide plane), and 1,200 in the stadium with a house and a bunny.
constexpr double unevenFactor = 16.0;

/// The average of SceneNumbers::crowding, over triangles with these boxes.
double crowdingOf(const std::vector<Box>& boxes, const Box& bounds) {
    // A flat scene is as thick as one cell.
    dvec3 extent = dvec3(bounds.hi) - dvec3(bounds.lo);
    const double widest = std::max({extent.x, extent.y, extent.z}), count = static_cast<double>(boxes.size());
    extent = glm::max(extent, dvec3(widest / count));
    const double side = std::cbrt(extent.x / count * extent.y * extent.z);
    std::vector<uint64_t> cells(boxes.size());
    for (size_t i = 0; i < boxes.size(); ++i) {
        uint64_t cell = 0;
        for (int axis = 0; axis < 3; ++axis) {
            const double at = (double{boxes[i].centre()[axis]} - bounds.lo[axis]) / side;
            cell = cell << 21 | static_cast<uint64_t>(std::clamp(at, 0.0, 2097151.0));
        }
        cells[i] = cell;
    }
    parallelSort(cells.begin(), cells.end());
    double pairs = 0.0;
    for (size_t begin = 0, end = 0; begin < cells.size(); begin = end) {
        while (end < cells.size() && cells[end] == cells[begin]) ++end;
        pairs += static_cast<double>(end - begin) * static_cast<double>(end - begin);
    }
    return pairs / count;
}

std::vector<uint8_t> findUsed(const Scene& scene, const Geometry& geometry) {
    std::vector<uint8_t> used(scene.materials.size());
    for (const uint32_t material : geometry.materials) used[material] = 1;
    return used;
}

/// Features that a triangle has by its material.
void addSurfaceFeatures(const Material& material, const auto& add) {
    const Surface s = surfaceOf(material);
    const bool transmits = glm::any(glm::greaterThan(s.transmission, vec3(0.0f)));
    add(material.baseColorTexture.has_value(), "textures");
    add(!transmits && s.gloss > 0.0f, "mirrors");
    add(transmits && material.transmission > 0.0f, "transmission");
    add(transmits && !s.thin, "refraction");
    add(material.alpha < 1.0f || (material.alphaVaries && material.alphaCutoff <= 0.0f), "alpha blending");
    add(material.alphaCutoff > 0.0f, "alpha masks");
    add(glm::any(glm::greaterThan(s.absorption, vec3(0.0f))), "absorption");
    add(glm::any(glm::greaterThan(s.emission, vec3(0.0f))), "emission");
}

}  // namespace

double SceneNumbers::sizesRatio() const {
    return medianExtent > 0.0f ? double{largestExtent} / medianExtent : 1.0;
}

bool SceneNumbers::isUneven() const {
    return crowding > unevenFactor * std::cbrt(static_cast<double>(usable));
}

SceneNumbers measureScene(std::span<const Primitive> triangles) {
    SceneNumbers numbers;
    numbers.spheres = static_cast<uint64_t>(std::ranges::count_if(triangles, &Primitive::isSphere));
    numbers.triangles = triangles.size() - numbers.spheres;
    std::vector<Box> boxes;
    std::vector<float> extents;
    for (const Primitive& triangle : triangles) {
        if (!triangle.usable()) continue;
        boxes.push_back(triangle.box());
        numbers.bounds.grow(boxes.back());
        const vec3 extent = boxes.back().extent();
        extents.push_back(std::max({extent.x, extent.y, extent.z}));
    }
    numbers.usable = boxes.size();
    if (boxes.empty()) return numbers;
    numbers.largestExtent = *std::max_element(extents.begin(), extents.end());
    const auto middle = extents.begin() + static_cast<long>(extents.size() / 2);
    std::nth_element(extents.begin(), middle, extents.end());
    numbers.medianExtent = *middle;
    numbers.crowding = crowdingOf(boxes, numbers.bounds);
    return numbers;
}

std::vector<std::string> featuresOf(const Scene& scene, const Geometry& geometry) {
    std::vector<std::string> features;
    const auto add = [&](bool has, const char* feature) {
        if (has && std::find(features.begin(), features.end(), feature) == features.end()) features.emplace_back(feature);
    };
    const std::vector<uint8_t> used = findUsed(scene, geometry);
    for (size_t i = 0; i < used.size(); ++i)
        if (used[i] != 0) addSurfaceFeatures(scene.materials[i], add);
    add(!geometry.spheres.empty(), "spheres");
    add(!geometry.normals.empty(), "vertex normals");
    add(!geometry.colors.empty(), "vertex colours");
    add(scene.instances.size() > scene.meshes.size(), "instances");
    for (const Light& light : scene.lights) {
        add(light.type == Light::Type::point, "point lights");
        add(light.type == Light::Type::spot, "spot lights");
        add(light.type == Light::Type::directional, "directional lights");
    }
    for (const Camera& camera : scene.cameras) add(camera.orthographic, "orthographic cameras");
    return features;
}

uint32_t countUsedMaterials(const Scene& scene, const Geometry& geometry) {
    const std::vector<uint8_t> used = findUsed(scene, geometry);
    return static_cast<uint32_t>(std::count(used.begin(), used.end(), 1));
}

}  // namespace raig
