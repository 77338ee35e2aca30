/// Surfaces that are there in part.
#pragma once

#include "support/rendering.hpp"

namespace raig::test {

/// As much of a surface as that, by the alpha of its texture and vertices, too.
inline Material covering(float alpha, const vec3& color = vec3(1.0f)) {
    Material m = matte(color);
    m.alpha = alpha;
    m.alphaVaries = true;
    return m;
}

/// White where the texture's alpha is at least that, else nothing.
inline Material cutOut(float cutoff) {
    Material m = covering(1.0f);
    m.alphaCutoff = cutoff;
    m.baseColorTexture = Texture{};
    return m;
}

/// Leaves and veils before and behind mirrors and glass, spheres among them, lit by a lamp and by a light.
inline Scene leafyScene() {
    Scene scene = variedRoom();
    scene.images.push_back({4, 4, {}});
    for (uint32_t i = 0; i < 16; ++i)
        for (const uint32_t byte : {60 + 9 * i, 200u, 80u, i * 37 % 256})
            scene.images.back().rgba.push_back(static_cast<uint8_t>(byte));
    Material leaf = cutOut(0.4f);
    leaf.baseColorTexture->image = 1;
    Material veil = covering(0.6f, vec3(0.9f, 0.4f, 0.3f));
    veil.baseColorTexture = Texture{1};
    veil.roughness = 0.2f;
    const auto addCard = [&](const vec3& at, const Material& material) {
        const uint32_t card = addQuad(scene, at, {1.6f, 0, -0.3f}, {0.1f, 1.8f, 0.2f}, material);
        scene.meshes[card].uvs = {{0, 2}, {2, 2}, {2, 0}, {0, 0}};
    };
    for (int i = 0; i < 4; ++i) addCard({-2.0f + 0.7f * float(i), 0.2f, 2.0f - 0.6f * float(i)}, i % 2 ? leaf : veil);
    addSphere(scene, {1.6f, 0.9f, 0.3f}, 0.8f, 8, true, metal(vec3(0.9f)));
    addSphere(scene, {0.2f, 0.7f, 1.2f}, 0.6f, 8, true, tintedGlass());
    addTrueSphere(scene, {-1.0f, 2.6f, 0.5f}, 0.6f, covering(0.5f, vec3(0.2f, 0.5f, 0.9f)));
    addQuad(scene, {-1, 4.5f, -1}, {2, 0, 0}, {0, 0, 2}, glowing(vec3(9.0f, 8.0f, 7.0f)));
    scene.lights = {{.type = Light::Type::point, .position = {3, 3, 3}, .intensity = vec3(6.0f)}};
    return scene;
}

}  // namespace raig::test
