// KHR_implicit_shapes: spheres as primitives of meshes.
// https://github.com/KhronosGroup/glTF/tree/main/extensions/2.0/Khronos/KHR_implicit_shapes
#include "scene/gltf_parts.hpp"

namespace raig::gltf {

namespace {

constexpr const char* name = "KHR_implicit_shapes";

float radiusOf(const Document& document, const tinygltf::Value& shape, const std::string& pointer) {
    if (!shape.Has("sphere")) return 0.5f;  // the extension's default
    const tinygltf::Value& sphere = shape.Get("sphere");
    const std::string place = pointer + "/sphere/radius";
    if (sphere.Has("radius") && !sphere.Get("radius").IsNumber()) throw errorAt(document, place, "must be a number");
    const double given = numberIn(sphere, "radius", 0.5);
    const auto radius = static_cast<float>(given);
    if (!(radius > 0.0f && std::isfinite(radius)))
        throw errorAt(document, place, "is {}; a sphere's radius is a positive number that a float holds", given);
    return radius;
}

}  // namespace

std::vector<Shape> readShapes(const Document& document) {
    std::vector<Shape> shapes;
    const tinygltf::Value* extension = findExtension(document.model.extensions, name);
    if (extension == nullptr || !extension->Has("shapes")) return shapes;
    const tinygltf::Value& array = extension->Get("shapes");
    for (int i = 0; i < static_cast<int>(array.ArrayLen()); ++i) {
        const tinygltf::Value& shape = array.Get(i);
        const std::string pointer = fmt::format("/extensions/{}/shapes/{}", name, i);
        if (!shape.IsObject() || !shape.Has("type")) throw errorAt(document, pointer + "/type", "is missing");
        const auto type = shape.Get("type").Get<std::string>();
        shapes.push_back({printable(type), type == "sphere" ? radiusOf(document, shape, pointer) : 0.0f});
    }
    return shapes;
}

const Shape* shapeOf(const Document& document, const std::vector<Shape>& shapes, const tinygltf::Primitive& primitive,
                     const std::string& pointer) {
    const tinygltf::Value* extension = findExtension(primitive.extensions, name);
    if (extension == nullptr) return nullptr;
    const std::string place = fmt::format("{}/extensions/{}/shape", pointer, name);
    if (!extension->Has("shape") || !extension->Get("shape").IsNumber()) throw errorAt(document, place, "is missing");
    const int index = extension->Get("shape").GetNumberAsInt();
    if (index < 0 || static_cast<size_t>(index) >= shapes.size())
        throw errorAt(document, place, "names shape {} of {}", index, shapes.size());
    return &shapes[index];
}

}  // namespace raig::gltf
