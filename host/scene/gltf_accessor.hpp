/// Reading accessors: typed, strided, normalized and sparse. Internal to the glTF importer.
#pragma once

#include "scene/gltf_document.hpp"

namespace raig::gltf {

/// Bytes of a component of `type` (5120...5126); 0 for a type that glTF 2.0 does not have.
size_t componentBytes(int type);

/// Components of an element of tinygltf's `type` (SCALAR...MAT4).
size_t componentCount(int type);

/// What an accessor may be, for one use of it.
struct Allowed {
    int components;               ///< 1...4
    bool bytes, unsignedBytes;    ///< 8 bits
    bool shorts, unsignedShorts;  ///< 16 bits
    bool unsignedInts;
    bool floats;
    bool needsNormalized;  ///< integers only if normalized
};

/// Throws inputError at `use` (a JSON pointer) if accessor `index` is not of an allowed type.
/// Requires  checkModel(document) has passed; so do the functions below.
void checkType(const Document& document, int index, const Allowed& allowed, const std::string& use);

/// Element by element, `width` components each (fewer are filled with `fill`), integers converted and normalized as the
/// accessor says, sparse values put in. Cost O(count). Source: glTF 2.0 specification, sections 3.6.2 and 3.11.
std::vector<vec2> readVec2(const Document& document, int index);
std::vector<vec3> readVec3(const Document& document, int index);
std::vector<vec4> readVec4(const Document& document, int index, float fill = 1.0f);

/// All components of all elements, one after the other. For scalars and matrices: of the latter columns of floats only.
std::vector<float> readFloats(const Document& document, int index);

/// The same of unsigned integers, which are not normalized.
std::vector<uint32_t> readIndices(const Document& document, int index);

/// The sparse part's indices.
std::vector<uint32_t> readSparseIndices(const Document& document, const tinygltf::Accessor& accessor);

}  // namespace raig::gltf
