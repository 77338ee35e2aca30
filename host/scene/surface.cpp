#include "scene/surface.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

float normalReflectance(float ior) {
    return ((ior - 1.0f) / (ior + 1.0f)) * ((ior - 1.0f) / (ior + 1.0f));
}

Surface surfaceOf(const Material& m) {
    const float polish = std::max(0.0f, 1.0f - 2.0f * m.roughness);
    const float blur = std::max(0.0f, 2.0f * m.roughness - 1.0f);
    const float shine = (1.0f - m.metallic) * (1.0f - blur * blur), along = normalReflectance(m.ior);
    const float through = (1.0f - m.metallic) * m.transmission;

    Surface s{};
    s.gloss = polish * polish;
    s.diffuse = m.baseColor * ((1.0f - m.metallic) * (1.0f - m.transmission));
    s.f0 = vec3(shine * along) + m.metallic * m.baseColor;
    s.f90 = shine * std::min(1.0f, 50.0f * along) + m.metallic;
    s.mirror = s.gloss * s.f0;
    s.transmission = through * m.baseColor;
    s.ior = m.ior;
    s.thin = m.thin;
    s.emission = m.emission;
    if (!s.thin && m.attenuationDistance > 0.0f)
        s.absorption = -glm::log(glm::clamp(m.attenuationColor, 1e-6f, 1.0f)) / m.attenuationDistance;
    return s;
}

float leastAlpha(const Material& m) {
    return m.alphaCutoff > 0.0f ? std::max(m.alphaCutoff - 0x1p-16f, 0x1p-17f) : 0.0f;
}

bool mayLetPass(const Scene& scene, const Material& m) {
    const bool blends = m.alphaCutoff <= 0.0f;
    if (blends && (1.0f - m.metallic) * m.transmission > 0.0f) return false;
    if (blends ? m.alpha < 1.0f : m.alpha < leastAlpha(m)) return true;
    if (!m.alphaVaries) return false;
    const auto varies = [](const Mesh& mesh) {
        return std::ranges::any_of(mesh.alphas, [](float alpha) { return alpha < 1.0f; });
    };
    if (std::ranges::any_of(scene.meshes, varies)) return true;
    if (!m.baseColorTexture) return false;
    const std::vector<uint8_t>& rgba = scene.images[m.baseColorTexture->image].rgba;
    for (size_t i = 3; i < rgba.size(); i += 4)
        if (rgba[i] < 255) return true;
    return false;
}

}  // namespace raig
