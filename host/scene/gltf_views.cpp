#include "scene/gltf_parts.hpp"

namespace raig::gltf {

namespace {

constexpr double pi = 3.14159265358979323846;

/// `v` at unit length, or nothing if it has none (zero, or out of range).
std::optional<dvec3> unit(const dvec3& v) {
    const double length = std::sqrt(glm::dot(v, v));
    if (!(length > 1e-150 && std::isfinite(length))) return std::nullopt;
    return v / length;
}

/// What is left of `v` at right angles to unit vector `axis`, at unit length; nothing if they are parallel.
std::optional<dvec3> unitAcross(const dvec3& v, const dvec3& axis) {
    const std::optional<dvec3> direction = unit(v);
    if (!direction) return std::nullopt;
    const dvec3 across = *direction - axis * glm::dot(*direction, axis);
    if (glm::dot(across, across) < 1e-12) return std::nullopt;
    // Once more: the first difference may have cancelled nearly all of it.
    const dvec3 once = *unit(across);
    return unit(once - axis * glm::dot(once, axis));
}

/// Sets eye and axes from a node's transform. A node that mirrors keeps its mirrored picture.
bool place(Camera& camera, const dmat4& toWorld) {
    const std::optional<dvec3> forward = unit(-dvec3(toWorld[2]));
    if (!forward) return false;
    const std::optional<dvec3> up = unitAcross(dvec3(toWorld[1]), *forward);
    if (!up) return false;
    const dvec3 right = glm::cross(*forward, *up);
    camera.eye = vec3(dvec3(toWorld[3]));
    camera.forward = vec3(*forward);
    camera.up = vec3(*up);
    camera.right = vec3(glm::dot(right, dvec3(toWorld[0])) < 0.0 ? -right : right);
    return isFinite(camera.eye);
}

/// A float that is positive and finite, from a double that must be.
float positive(const Document& document, double value, const std::string& pointer) {
    const auto narrow = static_cast<float>(value);
    if (!(narrow > 0.0f && std::isfinite(narrow))) throw errorAt(document, pointer, "is {}; it must be positive", value);
    return narrow;
}

void readCones(const Document& document, const tinygltf::SpotLight& spot, const std::string& pointer, Light& light) {
    const double inner = spot.innerConeAngle, outer = spot.outerConeAngle;
    // A little more than a right angle is what a float makes of it.
    if (!(inner >= 0.0 && inner < outer && outer <= pi / 2 + 1e-6))
        throw errorAt(document, pointer + "/spot", "needs 0 <= innerConeAngle < outerConeAngle <= pi / 2, and has {} and {}",
                      inner, outer);
    light.innerConeAngle = static_cast<float>(inner);
    light.outerConeAngle = static_cast<float>(outer);
}

}  // namespace

std::optional<Camera> cameraAt(const Document& document, int camera, const dmat4& toWorld, Remarks& remarks) {
    const tinygltf::Camera& source = document.model.cameras[camera];
    const std::string pointer = fmt::format("/cameras/{}", camera);
    Camera result;
    result.name = source.name;
    if (source.type == "perspective") {
        const tinygltf::PerspectiveCamera& lens = source.perspective;
        result.yfov = positive(document, lens.yfov, pointer + "/perspective/yfov");
        if (!(result.yfov < static_cast<float>(pi)))
            throw errorAt(document, pointer + "/perspective/yfov", "is {}; it must be below pi", lens.yfov);
        if (lens.aspectRatio != 0.0)
            result.aspect = positive(document, lens.aspectRatio, pointer + "/perspective/aspectRatio");
    } else {
        result.orthographic = true;
        result.xmag = positive(document, std::abs(source.orthographic.xmag), pointer + "/orthographic/xmag");
        result.ymag = positive(document, std::abs(source.orthographic.ymag), pointer + "/orthographic/ymag");
        result.aspect = positive(document, double(result.xmag) / double(result.ymag), pointer + "/orthographic");
    }
    if (place(result, toWorld)) return result;
    remarks.add("a camera whose node has no direction (scaled to nothing) is left out");
    return std::nullopt;
}

std::optional<Light> lightAt(const Document& document, int index, const dmat4& toWorld, Remarks& remarks) {
    const tinygltf::Light& source = document.model.lights[index];
    const std::string pointer = fmt::format("/extensions/KHR_lights_punctual/lights/{}", index);
    if (source.color.size() != 0 && source.color.size() != 3)
        throw errorAt(document, pointer + "/color", "must be 3 numbers");
    Light light;
    if (source.type == "spot") {
        light.type = Light::Type::spot;
        readCones(document, source.spot, pointer, light);
    } else if (source.type == "directional") {
        light.type = Light::Type::directional;
    } else if (source.type != "point") {
        throw errorAt(document, pointer + "/type", "is '{}'; point, spot and directional are known", printable(source.type));
    }
    for (int k = 0; k < 3; ++k) {
        light.intensity[k] = static_cast<float>(source.intensity * (source.color.empty() ? 1.0 : source.color[k]));
        if (!(light.intensity[k] >= 0.0f && std::isfinite(light.intensity[k])))
            throw errorAt(document, pointer, "its intensity times color is negative or too large");
    }
    if (source.range != 0.0) light.range = positive(document, source.range, pointer + "/range");
    light.position = vec3(dvec3(toWorld[3]));
    if (!isFinite(light.position)) throw errorAt(document, pointer, "its position in the world is not finite");
    const std::optional<dvec3> direction = unit(-dvec3(toWorld[2]));
    if (direction) light.direction = vec3(*direction);
    if (direction || light.type == Light::Type::point) return light;
    remarks.add("a light whose node has no direction (scaled to nothing) is left out");
    return std::nullopt;
}

int lightOf(const Document& document, size_t node) {
    const tinygltf::Value* extension = findExtension(document.model.nodes[node].extensions, "KHR_lights_punctual");
    if (!extension || !extension->Get("light").IsInt()) return -1;
    const int light = extension->Get("light").GetNumberAsInt();
    if (static_cast<size_t>(light) >= document.model.lights.size())
        throw errorAt(document, fmt::format("/nodes/{}/extensions/KHR_lights_punctual/light", node), "names light {} of {}",
                      light, document.model.lights.size());
    return light;
}

}  // namespace raig::gltf
