#include "rays/lights.hpp"

#include "base/parallel.hpp"
#include "scene/surface.hpp"

#include <algorithm>

namespace raig {

namespace {

double luminance(const vec3& c) { return 0.2126 * c.x + 0.7152 * c.y + 0.0722 * c.z; }

}  // namespace

std::vector<Emitter> listEmitters(const Scene& scene, const Geometry& geometry) {
    std::vector<double> brightness;
    for (const Material& material : scene.materials) brightness.push_back(luminance(surfaceOf(material).emission));
    std::vector<Emitter> emitters;
    if (std::none_of(brightness.begin(), brightness.end(), [](double b) { return b > 0.0; })) return emitters;

    std::vector<double> sums;
    double sum = 0.0;
    for (uint32_t i = 0; i < geometry.triangles.size(); ++i) {
        const double radiance = brightness[geometry.materials[i]];
        if (!(radiance > 0.0) || geometry.isSphere(i)) continue;
        const uvec3 t = geometry.triangles[i];
        const vec3 a = geometry.positions[t.x], b = geometry.positions[t.y], c = geometry.positions[t.z];
        if (!isUsable(a, b, c)) continue;
        const double area = 0.5 * glm::length(glm::cross(dvec3(b) - dvec3(a), dvec3(c) - dvec3(a)));
        if (!(static_cast<float>(area) > 0.0f)) continue;  // too small for a density in floats: it lights nothing
        sum += area * radiance;
        sums.push_back(sum);
        emitters.push_back({.triangle = i, .area = static_cast<float>(area), .cumulated = 0.0f});
    }
    for (size_t i = 0; i < emitters.size(); ++i) emitters[i].cumulated = static_cast<float>(sums[i] / sum);
    return emitters;
}

std::vector<uint8_t> findSeeThrough(const Scene& scene, const Geometry& geometry) {
    std::vector<uint8_t> passes;
    for (const Material& material : scene.materials)
        passes.push_back(glm::any(glm::greaterThan(surfaceOf(material).transmission, vec3(0.0f))));
    if (std::find(passes.begin(), passes.end(), 1) == passes.end()) return {};
    std::vector<uint8_t> result(geometry.triangles.size());
    parallelFor(result.size(), 65536, [&](size_t begin, size_t end) {
        for (size_t i = begin; i < end; ++i) result[i] = passes[geometry.materials[i]];
    });
    return result;
}

}  // namespace raig
