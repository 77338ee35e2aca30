#include "scene/validate.hpp"

#include "scene/geometry.hpp"

#include <fmt/format.h>

#include <cmath>

namespace raig {

namespace {

using Fault = std::optional<std::string>;

/// How far a squared length in float may be from 1: several roundings of 2^-24, doubled by squaring.
constexpr double unitTolerance = 1e-5;

template <class... Args>
Fault fault(fmt::format_string<Args...> format, Args&&... args) {
    return fmt::format(format, std::forward<Args>(args)...);
}

bool isUnit(const vec3& v) {
    return std::abs(glm::dot(dvec3(v), dvec3(v)) - 1.0) <= unitTolerance;
}

/// Finite and not negative; false for NaN.
bool isAmount(float x) {
    return x >= 0.0f && std::isfinite(x);
}
bool isAmount(const vec3& v) {
    return isAmount(v.x) && isAmount(v.y) && isAmount(v.z);
}
bool isFraction(float x) {
    return x >= 0.0f && x <= 1.0f;
}

Fault findMeshFault(const Mesh& mesh, size_t materialCount) {
    const size_t vertexCount = mesh.positions.size();
    if (!mesh.normals.empty() && mesh.normals.size() != vertexCount)
        return fault("{} normals for {} vertices", mesh.normals.size(), vertexCount);
    if (!mesh.uvs.empty() && mesh.uvs.size() != vertexCount)
        return fault("{} uvs for {} vertices", mesh.uvs.size(), vertexCount);
    if (!mesh.moreUvs.empty() && mesh.moreUvs.size() != vertexCount)
        return fault("{} uvs of a second set for {} vertices", mesh.moreUvs.size(), vertexCount);
    if (!mesh.tangents.empty() && mesh.tangents.size() != vertexCount)
        return fault("{} tangents for {} vertices", mesh.tangents.size(), vertexCount);
    if (!mesh.colors.empty() && mesh.colors.size() != vertexCount)
        return fault("{} colours for {} vertices", mesh.colors.size(), vertexCount);
    if (!mesh.alphas.empty() && (mesh.alphas.size() != vertexCount || mesh.colors.empty()))
        return fault("{} alphas for {} vertices with {} colours", mesh.alphas.size(), vertexCount, mesh.colors.size());
    if (mesh.materials.size() != mesh.primitiveCount())
        return fault("{} material indices for {} triangles and spheres", mesh.materials.size(), mesh.primitiveCount());
    for (size_t i = 0; i < mesh.triangles.size(); ++i) {
        const uvec3 t = mesh.triangles[i];
        const uint32_t last = std::max(std::max(t.x, t.y), t.z);
        if (last >= vertexCount) return fault("triangle {} names vertex {} of {}", i, last, vertexCount);
    }
    for (size_t i = 0; i < mesh.materials.size(); ++i)
        if (mesh.materials[i] >= materialCount)
            return fault("primitive {} names material {} of {}", i, mesh.materials[i], materialCount);
    for (size_t i = 0; i < mesh.normals.size(); ++i)
        if (mesh.normals[i] != vec3(0.0f) && !isUnit(mesh.normals[i])) return fault("normal {} is neither unit nor zero", i);
    for (size_t i = 0; i < mesh.uvs.size(); ++i)
        if (!isUsableUv(mesh.uvs[i])) return fault("uv {} is too large", i);
    for (size_t i = 0; i < mesh.moreUvs.size(); ++i)
        if (!isUsableUv(mesh.moreUvs[i])) return fault("uv {} of the second set is too large", i);
    for (size_t i = 0; i < mesh.tangents.size(); ++i)
        if (const vec4& t = mesh.tangents[i]; t != vec4(0.0f) && !(isUnit(vec3(t)) && std::abs(t.w) == 1.0f))
            return fault("tangent {} is neither unit, with a w of 1 or -1, nor zero", i);
    for (size_t i = 0; i < mesh.colors.size(); ++i)
        if (!isAmount(mesh.colors[i])) return fault("colour {} is negative or not finite", i);
    for (size_t i = 0; i < mesh.alphas.size(); ++i)
        if (!isFraction(mesh.alphas[i])) return fault("alpha {} is outside [0, 1]", i);
    return std::nullopt;
}

Fault findInstanceFault(const Instance& instance, const std::vector<Mesh>& meshes) {
    if (instance.mesh >= meshes.size()) return fault("names mesh {} of {}", instance.mesh, meshes.size());
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(instance.toWorld[column][row])) return fault("toWorld is not finite");
    const dmat4& m = instance.toWorld;
    if (m[0].w != 0.0 || m[1].w != 0.0 || m[2].w != 0.0 || m[3].w != 1.0) return fault("toWorld is not affine");
    if (!meshes[instance.mesh].spheres.empty() && !uniformScale(m)) return fault("toWorld makes no spheres of spheres");
    return std::nullopt;
}

Fault findTextureFault(const Texture& texture, size_t imageCount) {
    if (texture.image >= imageCount) return fault("its texture names image {} of {}", texture.image, imageCount);
    if (texture.set > 1) return fault("its texture names set {} of 2", texture.set);
    for (int k = 0; k < 3; ++k)
        if (!isUsableUv({texture.u[k], texture.v[k]})) return fault("its texture's transform is too large");
    return std::nullopt;
}

Fault findMaterialFault(const Material& m, size_t imageCount) {
    if (!isAmount(m.baseColor)) return fault("baseColor is negative or not finite");
    if (!isAmount(m.emission)) return fault("emission is negative or not finite");
    if (!isAmount(m.attenuationColor)) return fault("attenuationColor is negative or not finite");
    if (!isAmount(m.attenuationDistance)) return fault("attenuationDistance is negative or not finite");
    if (!isFraction(m.alpha)) return fault("alpha is outside [0, 1]");
    if (!isAmount(m.alphaCutoff)) return fault("alphaCutoff is negative or not finite");
    if (!isFraction(m.metallic)) return fault("metallic is outside [0, 1]");
    if (!isFraction(m.roughness)) return fault("roughness is outside [0, 1]");
    if (!isFraction(m.transmission)) return fault("transmission is outside [0, 1]");
    if (!isAmount(m.ior) || m.ior == 0.0f) return fault("ior is not positive and finite");
    if (!(std::abs(m.normalScale) <= mostNormalScale)) return fault("normalScale is too large");
    if (!isFraction(m.occlusionStrength)) return fault("occlusionStrength is outside [0, 1]");
    for (const auto* texture :
         {&m.baseColorTexture, &m.roughnessTexture, &m.normalTexture, &m.emissionTexture, &m.occlusionTexture})
        if (*texture)
            if (const Fault found = findTextureFault(**texture, imageCount)) return found;
    return std::nullopt;
}

Fault findImageFault(const Texels& image) {
    const uint64_t bytes = uint64_t{image.width} * image.height * 4;
    if (bytes == 0) return fault("is empty");
    if (image.rgba.size() != bytes)
        return fault("{} bytes for {} x {} texels of 4", image.rgba.size(), image.width, image.height);
    return std::nullopt;
}

Fault findLightFault(const Light& light) {
    if (!isFinite(light.position)) return fault("position is not finite");
    if (!isUnit(light.direction)) return fault("direction is not unit");
    if (!isAmount(light.intensity)) return fault("intensity is negative or not finite");
    if (!isAmount(light.range)) return fault("range is negative or not finite");
    if (!isAmount(light.innerConeAngle) || !isAmount(light.outerConeAngle) || light.innerConeAngle > light.outerConeAngle)
        return fault("cone angles are not 0 <= inner <= outer");
    return std::nullopt;
}

Fault findCameraFault(const Camera& camera) {
    if (!isFinite(camera.eye)) return fault("eye is not finite");
    if (!isUnit(camera.forward) || !isUnit(camera.right) || !isUnit(camera.up)) return fault("axes are not unit");
    const double skew = std::abs(glm::dot(dvec3(camera.forward), dvec3(camera.right))) +
                        std::abs(glm::dot(dvec3(camera.right), dvec3(camera.up))) +
                        std::abs(glm::dot(dvec3(camera.up), dvec3(camera.forward)));
    if (!(skew <= unitTolerance)) return fault("axes are not perpendicular");
    if (!isAmount(camera.aspect)) return fault("aspect is negative or not finite");
    if (camera.orthographic && !(isAmount(camera.xmag) && isAmount(camera.ymag) && camera.xmag > 0 && camera.ymag > 0))
        return fault("xmag and ymag are not positive and finite");
    if (!camera.orthographic && !(camera.yfov > 0.0f && camera.yfov < 3.14159265f)) return fault("yfov is outside (0, pi)");
    return std::nullopt;
}

/// The first fault that `find` sees in one of `items`, with the item's kind and index in front.
template <class Items, class Find>
Fault firstFault(const char* kind, const Items& items, const Find& find) {
    for (size_t i = 0; i < items.size(); ++i)
        if (const Fault found = find(items[i])) return fault("{} {}: {}", kind, i, *found);
    return std::nullopt;
}

}  // namespace

std::optional<std::string> findFault(const Scene& scene) {
    if (scene.materials.empty()) return fault("there is no material");
    if (const Fault f =
            firstFault("mesh", scene.meshes, [&](const Mesh& mesh) { return findMeshFault(mesh, scene.materials.size()); }))
        return f;
    if (const Fault f = firstFault("instance", scene.instances,
                                   [&](const Instance& instance) { return findInstanceFault(instance, scene.meshes); }))
        return f;
    if (const Fault f = firstFault("material", scene.materials, [&](const Material& material) {
            return findMaterialFault(material, scene.images.size());
        }))
        return f;
    if (const Fault f = firstFault("image", scene.images, findImageFault)) return f;
    if (const Fault f = firstFault("light", scene.lights, findLightFault)) return f;
    if (const Fault f = firstFault("camera", scene.cameras, findCameraFault)) return f;
    if (!isAmount(scene.sky.zenith) || !isAmount(scene.sky.horizon) || !isAmount(scene.sky.ground))
        return fault("sky: a colour is negative or not finite");
    if (scene.environment && !std::ranges::all_of(scene.environment->texels, [](const vec3& c) { return isAmount(c); }))
        return fault("environment: a colour is negative or not finite");
    if (!isAmount(scene.ambient)) return fault("ambient is negative or not finite");
    return std::nullopt;
}

}  // namespace raig
