#include "rays/lights.hpp"

#include "base/parallel.hpp"
#include "scene/surface.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace raig {

namespace {

double luminance(const dvec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

/// In linear light.
dvec3 meanOf(const Texels& image) {
    std::array<std::array<uint64_t, 256>, 3> counts{};
    for (size_t i = 0; i < image.rgba.size(); ++i)
        if (i % 4 < 3) ++counts[i % 4][image.rgba[i]];
    dvec3 sum(0.0);
    for (int byte = 0; byte < 256; ++byte) {
        const double c = byte / 255.0, value = c <= 0.04045 ? c / 12.92 : std::pow((c + 0.055) / 1.055, 2.4);
        for (int k = 0; k < 3; ++k) sum[k] += value * static_cast<double>(counts[k][byte]);
    }
    return sum / (static_cast<double>(image.rgba.size()) / 4.0);
}

}  // namespace

std::vector<Emitter> listEmitters(const Scene& scene, const Geometry& geometry) {
    std::vector<double> brightness;
    for (const Material& material : scene.materials) {
        dvec3 emission(material.emission);
        const auto& texture = material.emissionTexture;
        if (texture && !(texture->set == 0 ? geometry.uvs : geometry.moreUvs).empty() && emission != dvec3(0.0))
            emission *= meanOf(scene.images[texture->image]);
        brightness.push_back(luminance(emission));
    }
    std::vector<Emitter> emitters;
    if (std::none_of(brightness.begin(), brightness.end(), [](double b) { return b > 0.0; })) return emitters;

    std::vector<double> sums;
    double sum = 0.0;
    for (uint32_t instance = 0; instance + 1 < geometry.firstTriangle.size(); ++instance) {
        const uint32_t first = geometry.firstTriangle[instance], count = geometry.firstTriangle[instance + 1] - first;
        const size_t stored = geometry.storedTriangle({instance, 0});
        for (uint32_t i = 0; i < count; ++i) {
            const double radiance = brightness[geometry.materials[stored + i]];
            if (!(radiance > 0.0) || geometry.isSphere(Geometry::Place{instance, i})) continue;
            const auto [a, b, c] = geometry.corners({instance, i});
            if (!isUsable(a, b, c)) continue;
            const double area = 0.5 * glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
            if (!(static_cast<float>(area) > 0.0f)) continue;  // too small for a density in floats: it lights nothing
            sum += area * radiance;
            sums.push_back(sum);
            emitters.push_back({.triangle = first + i, .area = static_cast<float>(area), .cumulated = 0.0f});
        }
    }
    for (size_t i = 0; i < emitters.size(); ++i) emitters[i].cumulated = static_cast<float>(sums[i] / sum);
    return emitters;
}

namespace {

/// One byte a material: 1 where it lets light through. Empty if none does.
std::vector<uint8_t> transparentMaterials(const Scene& scene) {
    std::vector<uint8_t> passes;
    for (const Material& material : scene.materials)
        passes.push_back(glm::any(glm::greaterThan(surfaceOf(material).transmission, vec3(0.0f))));
    return std::find(passes.begin(), passes.end(), 1) == passes.end() ? std::vector<uint8_t>{} : passes;
}

}  // namespace

std::vector<uint8_t> findSeeThrough(const Scene& scene, const Geometry& geometry) {
    const std::vector<uint8_t> passes = transparentMaterials(scene);
    if (passes.empty()) return {};
    std::vector<uint8_t> result(geometry.triangles.size());
    parallelFor(result.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) result[i] = passes[geometry.materials[i]];
    });
    return result;
}

void markSeeThrough(const Scene& scene, const Geometry& geometry, Structure& structure) {
    const std::vector<uint8_t> seeThrough = findSeeThrough(scene, geometry);
    if (seeThrough.empty()) return;
    const auto ofId = [&](uint32_t id) { return seeThrough[geometry.storedTriangle(geometry.place(id))] != 0; };
    if (!structure.isInstanced()) {
        structure.markSeeThrough(ofId);
        return;
    }
    for (const Bottom& bottom : structure.bottoms) {
        const auto ofMesh = [&](uint32_t id) { return seeThrough[geometry.stored[bottom.mesh].firstTriangle + id] != 0; };
        if (bottom.mesh == Bottom::writtenOut)
            structure.markSeeThrough(ofId, bottom.firstReference, bottom.references);
        else
            structure.markSeeThrough(ofMesh, bottom.firstReference, bottom.references);
    }
}

}  // namespace raig
