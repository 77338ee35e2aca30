#include "scene/gltf_accessor.hpp"
#include "scene/gltf_deform.hpp"
#include "scene/gltf_parts.hpp"

#include <cmath>

namespace raig::gltf {

namespace {

size_t nodeOf(const Document& document, const nlohmann::json& index, const std::string& place) {
    const size_t node = wholeNumber(document, index, place);
    if (node >= document.model.nodes.size())
        throw errorAt(document, place, "names node {}, but there are {}", node, document.model.nodes.size());
    return node;
}

void checkSkin(const Document& document, size_t index) {
    const nlohmann::json& skin = document.skins[index];
    const std::string pointer = fmt::format("/skins/{}", index);
    if (!skin.contains("joints") || skin["joints"].empty()) throw errorAt(document, pointer, "has no joints");
    const nlohmann::json& joints = skin["joints"];
    for (size_t i = 0; i < joints.size(); ++i) nodeOf(document, joints[i], fmt::format("{}/joints/{}", pointer, i));
    if (skin.contains("skeleton")) nodeOf(document, skin["skeleton"], pointer + "/skeleton");
    if (!skin.contains("inverseBindMatrices")) return;
    const std::string place = pointer + "/inverseBindMatrices";
    const size_t accessor = wholeNumber(document, skin["inverseBindMatrices"], place);
    if (accessor >= document.model.accessors.size())
        throw errorAt(document, place, "names accessor {}, but there are {}", accessor, document.model.accessors.size());
    const tinygltf::Accessor& source = document.model.accessors[accessor];
    if (source.type != TINYGLTF_TYPE_MAT4 || source.componentType != TINYGLTF_COMPONENT_TYPE_FLOAT)
        throw errorAt(document, place, "accessor {} does not hold 4 x 4 matrices of floats", accessor);
    if (source.count < joints.size())
        throw errorAt(document, place, "has {} matrices for {} joints", source.count, joints.size());
}

bool isFinite(const dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(m[column][row])) return false;
    return true;
}

/// One a joint; identities where the file has none.
std::vector<dmat4> inverseBindMatrices(const Document& document, int skin) {
    const nlohmann::json& source = document.skins[skin];
    std::vector<dmat4> matrices(source["joints"].size(), dmat4(1.0));
    if (!source.contains("inverseBindMatrices")) return matrices;
    const std::vector<float> numbers = readFloats(document, source["inverseBindMatrices"].get<int>());
    for (size_t i = 0; i < matrices.size(); ++i) {
        const auto first = numbers.begin() + static_cast<std::ptrdiff_t>(16 * i);
        const std::string place = fmt::format("/skins/{}/inverseBindMatrices", skin);
        matrices[i] = readMatrix(document, {first, first + 16}, place);
        if (!isFinite(matrices[i])) throw errorAt(document, place, "matrix {} is not finite", i);
    }
    return matrices;
}

}  // namespace

Skins::Skins(const Document& document) : document_(document), parents_(parentsOf(document.model)) {
    for (size_t i = 0; i < document.skins.size(); ++i) checkSkin(document, i);
}

const dmat4& Skins::worldOf(size_t node) {
    std::vector<size_t> path;  // up to a node that is known, or has no parent
    for (int at = static_cast<int>(node); at >= 0 && !known_.contains(at); at = parents_[at]) path.push_back(at);
    for (auto at = path.rbegin(); at != path.rend(); ++at) {
        const int parent = parents_[*at];
        const dmat4 local = localTransform(document_, *at);
        known_[*at] = parent < 0 ? local : known_.at(parent) * local;
    }
    return known_.at(node);
}

const std::vector<dmat4>& Skins::matrices(int skin) {
    const auto [entry, isNew] = matrices_.try_emplace(skin);
    std::vector<dmat4>& matrices = entry->second;
    if (!isNew) return matrices;
    matrices = inverseBindMatrices(document_, skin);
    for (size_t i = 0; i < matrices.size(); ++i) {
        matrices[i] = worldOf(document_.skins[skin]["joints"][i].get<size_t>()) * matrices[i];
        if (!isFinite(matrices[i]))
            throw errorAt(document_, fmt::format("/skins/{}/joints/{}", skin, i),
                          "its transform to the world is not finite");
    }
    return matrices;
}

}  // namespace raig::gltf
