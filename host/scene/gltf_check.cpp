#include "scene/gltf_accessor.hpp"

namespace raig::gltf {

namespace {

/// Elements of an accessor without a buffer view are all zero: legal, and free in the file, so they are bounded here.
constexpr size_t mostZeroElements = size_t{1} << 22;

/// Throws unless 0 <= index < count.
void checkIndex(const Document& document, const std::string& pointer, const char* kind, int index, size_t count) {
    if (index < 0 || static_cast<size_t>(index) >= count)
        throw errorAt(document, pointer, "names {} {}, but there are {}", kind, index, count);
}

/// As checkIndex where -1 stands for "none".
void checkOptional(const Document& document, const std::string& pointer, const char* kind, int index, size_t count) {
    if (index != -1) checkIndex(document, pointer, kind, index, count);
}

void checkBufferViews(const Document& document) {
    const auto& views = document.model.bufferViews;
    for (size_t i = 0; i < views.size(); ++i) {
        const std::string pointer = fmt::format("/bufferViews/{}", i);
        checkIndex(document, pointer, "buffer", views[i].buffer, document.buffers.size());
        const size_t size = document.buffers[views[i].buffer].size();
        if (views[i].byteOffset > size || views[i].byteLength > size - views[i].byteOffset)
            throw errorAt(document, pointer, "reaches from byte {} over {} bytes, but its buffer has {}",
                          views[i].byteOffset, views[i].byteLength, size);
        if (views[i].byteStride > 252)
            throw errorAt(document, pointer, "has a byteStride of {}; at most 252 is allowed", views[i].byteStride);
    }
}

/// Throws unless `count` elements of `bytes`, `stride` apart, lie in the view from `offset` on. No sum can overflow: stride
/// and bytes are at most 252, and count is compared with the view's length before it is multiplied.
void checkRange(const Document& document, const std::string& pointer, int view, size_t offset, size_t count, size_t bytes,
                size_t stride) {
    const size_t length = document.model.bufferViews[view].byteLength;
    const bool fits = count == 0 || (offset <= length && bytes <= length - offset && count <= length &&
                                     (count - 1) * stride <= length - offset - bytes);
    if (!fits)
        throw errorAt(document, pointer, "{} elements of {} bytes from byte {} on do not fit into bufferView {} of {} bytes",
                      count, bytes, offset, view, length);
}

void checkSparse(const Document& document, const tinygltf::Accessor& accessor, const std::string& pointer, size_t bytes) {
    const auto& sparse = accessor.sparse;
    const size_t viewCount = document.model.bufferViews.size();
    if (sparse.count < 0 || static_cast<size_t>(sparse.count) > accessor.count)
        throw errorAt(document, pointer + "/sparse", "has {} values for {} elements", sparse.count, accessor.count);
    const auto type = sparse.indices.componentType;
    if (type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_BYTE && type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_SHORT &&
        type != TINYGLTF_COMPONENT_TYPE_UNSIGNED_INT)
        throw errorAt(document, pointer + "/sparse/indices", "has component type {}, which is not unsigned", type);
    checkIndex(document, pointer + "/sparse/indices", "bufferView", sparse.indices.bufferView, viewCount);
    checkIndex(document, pointer + "/sparse/values", "bufferView", sparse.values.bufferView, viewCount);
    if (sparse.indices.byteOffset < 0 || sparse.values.byteOffset < 0)
        throw errorAt(document, pointer + "/sparse", "has a negative byteOffset");
    checkRange(document, pointer + "/sparse/indices", sparse.indices.bufferView, sparse.indices.byteOffset, sparse.count,
               componentBytes(type), componentBytes(type));
    checkRange(document, pointer + "/sparse/values", sparse.values.bufferView, sparse.values.byteOffset, sparse.count, bytes,
               bytes);
    const std::vector<uint32_t> indices = readSparseIndices(document, accessor);
    for (size_t i = 0; i < indices.size(); ++i)
        if (indices[i] >= accessor.count || (i > 0 && indices[i] <= indices[i - 1]))
            throw errorAt(document, pointer + "/sparse/indices",
                          "index {} ({}) is out of range or not greater than the one before", i, indices[i]);
}

void checkAccessors(const Document& document) {
    const auto& accessors = document.model.accessors;
    for (size_t i = 0; i < accessors.size(); ++i) {
        const tinygltf::Accessor& accessor = accessors[i];
        const std::string pointer = fmt::format("/accessors/{}", i);
        checkOptional(document, pointer, "bufferView", accessor.bufferView, document.model.bufferViews.size());
        const size_t bytes = componentBytes(accessor.componentType) * componentCount(accessor.type);
        if (bytes == 0)
            throw errorAt(document, pointer, "has component type {}, which glTF does not have", accessor.componentType);
        if (accessor.bufferView < 0 && accessor.count > mostZeroElements)
            throw errorAt(document, pointer, "has no bufferView for its {} elements; at most {} may be zero", accessor.count,
                          mostZeroElements);
        if (accessor.bufferView >= 0) {
            const size_t given = document.model.bufferViews[accessor.bufferView].byteStride;
            const size_t stride = given ? given : bytes;
            if (stride < bytes)
                throw errorAt(document, pointer, "elements of {} bytes overlap at a byteStride of {}", bytes, stride);
            checkRange(document, pointer, accessor.bufferView, accessor.byteOffset, accessor.count, bytes, stride);
        }
        if (accessor.sparse.isSparse) checkSparse(document, accessor, pointer, bytes);
    }
}

void checkPrimitive(const Document& document, const tinygltf::Primitive& primitive, const std::string& pointer) {
    const auto& accessors = document.model.accessors;
    if (primitive.mode < TINYGLTF_MODE_POINTS || primitive.mode > TINYGLTF_MODE_TRIANGLE_FAN)
        throw errorAt(document, pointer + "/mode", "is {}; 0 to 6 are allowed", primitive.mode);
    checkOptional(document, pointer + "/material", "material", primitive.material, document.model.materials.size());
    checkOptional(document, pointer + "/indices", "accessor", primitive.indices, accessors.size());
    const auto position = primitive.attributes.find("POSITION");
    for (const auto& [name, index] : primitive.attributes) {
        const std::string place = pointer + "/attributes/" + printable(name);
        checkIndex(document, place, "accessor", index, accessors.size());
        if (position == primitive.attributes.end()) continue;
        checkIndex(document, pointer + "/attributes/POSITION", "accessor", position->second, accessors.size());
        if (accessors[index].count != accessors[position->second].count)
            throw errorAt(document, place, "has {} elements, but there are {} positions", accessors[index].count,
                          accessors[position->second].count);
    }
    for (size_t t = 0; t < primitive.targets.size(); ++t)
        for (const auto& [name, index] : primitive.targets[t]) {
            const std::string place = fmt::format("{}/targets/{}/{}", pointer, t, printable(name));
            checkIndex(document, place, "accessor", index, accessors.size());
            if (position != primitive.attributes.end() && accessors[index].count != accessors[position->second].count)
                throw errorAt(document, place, "has {} elements, but there are {} positions", accessors[index].count,
                              accessors[position->second].count);
        }
}

/// Throws unless there are no weights, or one for each morph target.
void checkWeights(const Document& document, size_t weights, size_t targets, const std::string& pointer) {
    if (weights != 0 && weights != targets)
        throw errorAt(document, pointer, "has {} weights for {} morph targets", weights, targets);
}

void checkMeshes(const Document& document) {
    const auto& meshes = document.model.meshes;
    for (size_t m = 0; m < meshes.size(); ++m) {
        const std::string pointer = fmt::format("/meshes/{}", m);
        const std::vector<tinygltf::Primitive>& primitives = meshes[m].primitives;
        for (size_t p = 0; p < primitives.size(); ++p) {
            const std::string place = fmt::format("{}/primitives/{}", pointer, p);
            checkPrimitive(document, primitives[p], place);
            if (primitives[p].targets.size() != primitives[0].targets.size())
                throw errorAt(document, place + "/targets", "has {} morph targets, but the mesh's first primitive {}",
                              primitives[p].targets.size(), primitives[0].targets.size());
        }
        checkWeights(document, meshes[m].weights.size(), targetCount(meshes[m]), pointer + "/weights");
    }
}

/// The node graph must be a forest; that it has no cycles shows when it is walked (scene/gltf_nodes.cpp).
void checkNodes(const Document& document) {
    const tinygltf::Model& model = document.model;
    std::vector<int> parents(model.nodes.size(), -1);
    for (size_t i = 0; i < model.nodes.size(); ++i) {
        const tinygltf::Node& node = model.nodes[i];
        const std::string pointer = fmt::format("/nodes/{}", i);
        checkOptional(document, pointer + "/mesh", "mesh", node.mesh, model.meshes.size());
        checkOptional(document, pointer + "/camera", "camera", node.camera, model.cameras.size());
        checkOptional(document, pointer + "/skin", "skin", node.skin, document.skins.size());
        checkWeights(document, node.weights.size(), node.mesh < 0 ? 0 : targetCount(model.meshes[node.mesh]),
                     pointer + "/weights");
        for (const int child : node.children) {
            checkIndex(document, pointer + "/children", "node", child, model.nodes.size());
            if (parents[child] != -1)
                throw errorAt(document, pointer + "/children", "node {} already has the parent {}", child, parents[child]);
            parents[child] = static_cast<int>(i);
        }
    }
    checkOptional(document, "/scene", "scene", model.defaultScene, model.scenes.size());
    for (size_t s = 0; s < model.scenes.size(); ++s)
        for (const int root : model.scenes[s].nodes) {
            checkIndex(document, fmt::format("/scenes/{}/nodes", s), "node", root, model.nodes.size());
            if (parents[root] != -1)
                throw errorAt(document, fmt::format("/scenes/{}/nodes", s),
                              "node {} is not a root: it is a child of node {}", root, parents[root]);
        }
}

void checkTextures(const Document& document) {
    const tinygltf::Model& model = document.model;
    for (size_t i = 0; i < document.images.size(); ++i)
        checkOptional(document, fmt::format("/images/{}", i), "bufferView", document.images[i].bufferView,
                      model.bufferViews.size());
    for (size_t i = 0; i < model.textures.size(); ++i) {
        const std::string pointer = fmt::format("/textures/{}", i);
        checkOptional(document, pointer + "/source", "image", model.textures[i].source, document.images.size());
        checkOptional(document, pointer + "/sampler", "sampler", model.textures[i].sampler, model.samplers.size());
    }
    for (size_t i = 0; i < model.materials.size(); ++i) {
        const tinygltf::Material& material = model.materials[i];
        const std::string pointer = fmt::format("/materials/{}", i);
        for (const int index : {material.pbrMetallicRoughness.baseColorTexture.index,
                                material.pbrMetallicRoughness.metallicRoughnessTexture.index, material.emissiveTexture.index,
                                material.normalTexture.index, material.occlusionTexture.index})
            checkOptional(document, pointer, "texture", index, model.textures.size());
    }
}

}  // namespace

size_t wholeNumber(const Document& document, const nlohmann::json& number, const std::string& pointer) {
    if (!number.is_number_unsigned()) throw errorAt(document, pointer, "must be a non-negative integer");
    return number.get<size_t>();
}

size_t targetCount(const tinygltf::Mesh& mesh) {
    return mesh.primitives.empty() ? 0 : mesh.primitives[0].targets.size();
}

void checkModel(const Document& document) {
    checkBufferViews(document);
    checkAccessors(document);
    checkMeshes(document);
    checkNodes(document);
    checkTextures(document);
}

}  // namespace raig::gltf
