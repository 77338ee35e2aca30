#include "scene/gltf_accessor.hpp"
#include "scene/gltf_parts.hpp"

#include <algorithm>

namespace raig::gltf {

namespace {

/// How far from 0 0 0 1 a matrix's last row may be and still be read as that: exporters compute it in float.
constexpr double affineTolerance = 1e-6;

/// Translation times rotation times scale. The rotation is (x, y, z, w), of any length but zero.
dmat4 compose(const dvec3& translation, const dvec4& rotation, const dvec3& scale) {
    const dvec4 q = rotation / std::sqrt(glm::dot(rotation, rotation));
    const double xx = q.x * q.x, yy = q.y * q.y, zz = q.z * q.z;
    const double xy = q.x * q.y, xz = q.x * q.z, yz = q.y * q.z;
    const double wx = q.w * q.x, wy = q.w * q.y, wz = q.w * q.z;
    return {dvec4(1 - 2 * (yy + zz), 2 * (xy + wz), 2 * (xz - wy), 0) * scale.x,
            dvec4(2 * (xy - wz), 1 - 2 * (xx + zz), 2 * (yz + wx), 0) * scale.y,
            dvec4(2 * (xz + wy), 2 * (yz - wx), 1 - 2 * (xx + yy), 0) * scale.z, dvec4(translation, 1)};
}

/// Throws unless `numbers` is empty or of `size` elements.
void checkSize(const Document& document, const std::vector<double>& numbers, size_t size, const std::string& pointer) {
    if (!numbers.empty() && numbers.size() != size)
        throw errorAt(document, pointer, "must be {} numbers, not {}", size, numbers.size());
}

void checkRotation(const Document& document, const dvec4& q, const std::string& pointer) {
    const double square = glm::dot(q, q);
    if (!(square > 0.0 && std::isfinite(square))) throw errorAt(document, pointer, "the rotation is zero or not finite");
}

/// The instancing attribute's accessor, its type checked; -1 if absent.
int instancingAccessor(const Document& document, const tinygltf::Value& attributes, const char* name, int components,
                       const std::string& pointer) {
    if (!attributes.Has(name)) return -1;
    const std::string place = pointer + "/" + name;
    const int index = attributes.Get(name).GetNumberAsInt();
    if (static_cast<size_t>(index) >= document.model.accessors.size())
        throw errorAt(document, place, "names accessor {} of {}", index, document.model.accessors.size());
    const bool isRotation = components == 4;
    checkType(document, index,
              {.components = components,
               .bytes = isRotation,
               .unsignedBytes = false,
               .shorts = isRotation,
               .unsignedShorts = false,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              place);
    return index;
}

}  // namespace

dmat4 readMatrix(const Document& document, const std::vector<double>& numbers, const std::string& pointer) {
    dmat4 m;
    for (int i = 0; i < 16; ++i) m[i / 4][i % 4] = numbers[i];
    // The zero matrix is a way to hide a node that real files use.
    const bool isZero = std::all_of(numbers.begin(), numbers.end(), [](double x) { return x == 0.0; });
    const bool isAffine = std::abs(m[0].w) <= affineTolerance && std::abs(m[1].w) <= affineTolerance &&
                          std::abs(m[2].w) <= affineTolerance && std::abs(m[3].w - 1.0) <= affineTolerance;
    if (!isZero && !isAffine) throw errorAt(document, pointer, "its last row is not 0 0 0 1");
    for (int column = 0; column < 4; ++column) m[column].w = column == 3 ? 1.0 : 0.0;
    return m;
}

dmat4 localTransform(const Document& document, size_t node) {
    const tinygltf::Node& source = document.model.nodes[node];
    const std::string pointer = fmt::format("/nodes/{}", node);
    checkSize(document, source.matrix, 16, pointer + "/matrix");
    checkSize(document, source.translation, 3, pointer + "/translation");
    checkSize(document, source.rotation, 4, pointer + "/rotation");
    checkSize(document, source.scale, 3, pointer + "/scale");
    if (!source.matrix.empty()) return readMatrix(document, source.matrix, pointer + "/matrix");
    const auto& t = source.translation;
    const auto& r = source.rotation;
    const auto& s = source.scale;
    const dvec4 rotation = r.empty() ? dvec4(0, 0, 0, 1) : dvec4(r[0], r[1], r[2], r[3]);
    checkRotation(document, rotation, pointer + "/rotation");
    return compose(t.empty() ? dvec3(0.0) : dvec3(t[0], t[1], t[2]), rotation,
                   s.empty() ? dvec3(1.0) : dvec3(s[0], s[1], s[2]));
}

std::vector<dmat4> copiesOf(const Document& document, size_t node) {
    const tinygltf::Value* extension = findExtension(document.model.nodes[node].extensions, "EXT_mesh_gpu_instancing");
    if (!extension || !extension->Get("attributes").IsObject()) return {dmat4(1.0)};
    const std::string pointer = fmt::format("/nodes/{}/extensions/EXT_mesh_gpu_instancing/attributes", node);
    const tinygltf::Value& attributes = extension->Get("attributes");
    const int translation = instancingAccessor(document, attributes, "TRANSLATION", 3, pointer);
    const int rotation = instancingAccessor(document, attributes, "ROTATION", 4, pointer);
    const int scale = instancingAccessor(document, attributes, "SCALE", 3, pointer);
    std::optional<size_t> count;
    for (const int accessor : {translation, rotation, scale}) {
        if (accessor < 0) continue;
        const size_t here = document.model.accessors[accessor].count;
        if (count && *count != here)
            throw errorAt(document, pointer, "the attributes have {} and {} elements", *count, here);
        count = here;
    }
    if (!count) return {dmat4(1.0)};
    const auto translations = translation < 0 ? std::vector<vec3>(*count, vec3(0.0f)) : readVec3(document, translation);
    const auto rotations = rotation < 0 ? std::vector<vec4>(*count, vec4(0, 0, 0, 1)) : readVec4(document, rotation);
    const auto scales = scale < 0 ? std::vector<vec3>(*count, vec3(1.0f)) : readVec3(document, scale);
    std::vector<dmat4> copies;
    copies.reserve(*count);
    for (size_t i = 0; i < *count; ++i) {
        checkRotation(document, dvec4(rotations[i]), pointer + "/ROTATION");
        copies.push_back(compose(dvec3(translations[i]), dvec4(rotations[i]), dvec3(scales[i])));
    }
    return copies;
}

}  // namespace raig::gltf
