#include "scene/gltf_accessor.hpp"

#include <algorithm>
#include <cstring>

namespace raig::gltf {

namespace {

/// Elements one after another, `stride` bytes apart.
struct Elements {
    const std::byte* first;
    size_t stride;
    int type;
    bool normalized;
};

template <class T>
T load(const std::byte* from) {
    T value;  // the file's values need not be aligned
    std::memcpy(&value, from, sizeof value);
    return value;
}

/// One component as a float: glTF 2.0 specification, section 3.11 for normalized integers.
float loadFloat(const std::byte* from, int type, bool normalized) {
    const auto signedValue = [&](int value, float largest) {
        return normalized ? std::max(static_cast<float>(value) / largest, -1.0f) : static_cast<float>(value);
    };
    const auto unsignedValue = [&](unsigned value, float largest) {
        return normalized ? static_cast<float>(value) / largest : static_cast<float>(value);
    };
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
            return signedValue(load<int8_t>(from), 127.0f);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return unsignedValue(load<uint8_t>(from), 255.0f);
        case TINYGLTF_COMPONENT_TYPE_SHORT:
            return signedValue(load<int16_t>(from), 32767.0f);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return unsignedValue(load<uint16_t>(from), 65535.0f);
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
            return unsignedValue(load<uint32_t>(from), 4294967295.0f);
        default:
            return load<float>(from);
    }
}

uint32_t loadUnsigned(const std::byte* from, int type) {
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE) return load<uint8_t>(from);
    if (type == TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT) return load<uint16_t>(from);
    return load<uint32_t>(from);
}

const std::byte* viewStart(const Document& document, int view, size_t offset) {
    const tinygltf::BufferView& v = document.model.bufferViews[view];
    return document.buffers[v.buffer].data() + v.byteOffset + offset;
}

size_t elementBytes(const tinygltf::Accessor& accessor) {
    return componentBytes(accessor.componentType) * componentCount(accessor.type);
}

Elements elementsOf(const Document& document, const tinygltf::Accessor& accessor) {
    const size_t stride = document.model.bufferViews[accessor.bufferView].byteStride;
    return {viewStart(document, accessor.bufferView, accessor.byteOffset), stride ? stride : elementBytes(accessor),
            accessor.componentType, accessor.normalized};
}

/// Calls `put(i, first byte of its value)` for each element that has a value: all in the buffer view, then the sparse ones.
template <class Put>
void forEachElement(const Document& document, const tinygltf::Accessor& accessor, const Put& put) {
    if (accessor.bufferView >= 0) {
        const Elements elements = elementsOf(document, accessor);
        for (size_t i = 0; i < accessor.count; ++i) put(i, elements.first + i * elements.stride);
    }
    if (!accessor.sparse.isSparse) return;
    const std::vector<uint32_t> indices = readSparseIndices(document, accessor);
    const auto& values = accessor.sparse.values;
    for (size_t i = 0; i < indices.size(); ++i)
        put(indices[i], viewStart(document, values.bufferView, values.byteOffset) + i * elementBytes(accessor));
}

template <class Vector, int width>
std::vector<Vector> readVectors(const Document& document, int index, float fill) {
    const tinygltf::Accessor& accessor = document.model.accessors[index];
    const size_t bytes = componentBytes(accessor.componentType);
    const int given = std::min(static_cast<int>(componentCount(accessor.type)), width);
    Vector start(0.0f);
    for (int k = given; k < width; ++k) start[k] = fill;
    std::vector<Vector> vectors(accessor.count, start);
    forEachElement(document, accessor, [&](size_t i, const std::byte* from) {
        for (int k = 0; k < given; ++k)
            vectors[i][k] = loadFloat(from + k * bytes, accessor.componentType, accessor.normalized);
    });
    return vectors;
}

}  // namespace

size_t componentBytes(int type) {
    switch (type) {
        case TINYGLTF_COMPONENT_TYPE_BYTE:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
            return 1;
        case TINYGLTF_COMPONENT_TYPE_SHORT:
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
            return 2;
        case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
        case TINYGLTF_COMPONENT_TYPE_FLOAT:
            return 4;
        default:
            return 0;
    }
}

size_t componentCount(int type) {
    switch (type) {
        case TINYGLTF_TYPE_SCALAR:
            return 1;
        case TINYGLTF_TYPE_VEC2:
            return 2;
        case TINYGLTF_TYPE_VEC3:
            return 3;
        case TINYGLTF_TYPE_VEC4:
        case TINYGLTF_TYPE_MAT2:
            return 4;
        case TINYGLTF_TYPE_MAT3:
            return 9;
        default:
            return 16;
    }
}

void checkType(const Document& document, int index, const Allowed& allowed, const std::string& use) {
    const tinygltf::Accessor& accessor = document.model.accessors[index];
    const bool isMatrix = accessor.type == TINYGLTF_TYPE_MAT2;
    if (isMatrix || componentCount(accessor.type) != static_cast<size_t>(allowed.components))
        throw errorAt(document, use, "accessor {} has {} components an element, not {}", index,
                      componentCount(accessor.type), allowed.components);
    const bool fits = [&] {
        switch (accessor.componentType) {
            case TINYGLTF_COMPONENT_TYPE_BYTE:
                return allowed.bytes;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE:
                return allowed.unsignedBytes;
            case TINYGLTF_COMPONENT_TYPE_SHORT:
                return allowed.shorts;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT:
                return allowed.unsignedShorts;
            case TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT:
                return allowed.unsignedInts;
            default:
                return allowed.floats;
        }
    }();
    if (!fits)
        throw errorAt(document, use, "accessor {} has component type {}, which is not allowed here", index,
                      accessor.componentType);
    const bool isFloat = accessor.componentType == TINYGLTF_COMPONENT_TYPE_FLOAT;
    if (allowed.needsNormalized && !isFloat && !accessor.normalized)
        throw errorAt(document, use, "accessor {} holds integers that are not normalized", index);
}

std::vector<vec2> readVec2(const Document& document, int index) {
    return readVectors<vec2, 2>(document, index, 0.0f);
}
std::vector<vec3> readVec3(const Document& document, int index) {
    return readVectors<vec3, 3>(document, index, 0.0f);
}
std::vector<vec4> readVec4(const Document& document, int index, float fill) {
    return readVectors<vec4, 4>(document, index, fill);
}

std::vector<float> readFloats(const Document& document, int index) {
    const tinygltf::Accessor& accessor = document.model.accessors[index];
    const size_t components = componentCount(accessor.type), bytes = componentBytes(accessor.componentType);
    std::vector<float> values(accessor.count * components, 0.0f);
    forEachElement(document, accessor, [&](size_t i, const std::byte* from) {
        for (size_t k = 0; k < components; ++k)
            values[i * components + k] = loadFloat(from + k * bytes, accessor.componentType, accessor.normalized);
    });
    return values;
}

std::vector<uint32_t> readIndices(const Document& document, int index) {
    const tinygltf::Accessor& accessor = document.model.accessors[index];
    const size_t components = componentCount(accessor.type), bytes = componentBytes(accessor.componentType);
    std::vector<uint32_t> values(accessor.count * components, 0);
    forEachElement(document, accessor, [&](size_t i, const std::byte* from) {
        for (size_t k = 0; k < components; ++k)
            values[i * components + k] = loadUnsigned(from + k * bytes, accessor.componentType);
    });
    return values;
}

std::vector<uint32_t> readSparseIndices(const Document& document, const tinygltf::Accessor& accessor) {
    const auto& source = accessor.sparse.indices;
    std::vector<uint32_t> indices(accessor.sparse.count);
    const std::byte* from = viewStart(document, source.bufferView, source.byteOffset);
    for (uint32_t& index : indices) {
        index = loadUnsigned(from, source.componentType);
        from += componentBytes(source.componentType);
    }
    return indices;
}

}  // namespace raig::gltf
