#include "scene/surface.hpp"

#include <algorithm>
#include <cmath>

namespace raig {

float normalReflectance(float ior) {
    return ((ior - 1.0f) / (ior + 1.0f)) * ((ior - 1.0f) / (ior + 1.0f));
}

Surface surfaceOf(const Material& m) {
    const float polish = std::max(0.0f, 1.0f - 2.0f * m.roughness);
    const float through = (1.0f - m.metallic) * m.transmission;

    Surface s{};
    s.gloss = polish * polish;
    s.diffuse = m.alpha * m.baseColor * ((1.0f - m.metallic) * (1.0f - m.transmission) + m.metallic * (1.0f - s.gloss));
    s.mirror = s.gloss * glm::mix(vec3(normalReflectance(m.ior)), m.baseColor, m.metallic);
    s.transmission = through * m.baseColor;
    s.ior = m.ior;
    s.thin = m.thin;
    s.emission = m.emission;
    s.tintsThrough = true;
    if (through <= 0.0f && m.alpha < 1.0f) {
        s.transmission = vec3(1.0f - m.alpha);
        s.ior = 1.0f;
        s.thin = true;
        s.tintsThrough = false;
    }
    if (!s.thin && m.attenuationDistance > 0.0f)
        s.absorption = -glm::log(glm::clamp(m.attenuationColor, 1e-6f, 1.0f)) / m.attenuationDistance;
    return s;
}

}  // namespace raig
