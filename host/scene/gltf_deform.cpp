#include "scene/gltf_deform.hpp"

#include "scene/gltf_accessor.hpp"
#include "scene/placement.hpp"

#include <algorithm>
#include <cmath>

namespace raig::gltf {

namespace {

using Attributes = std::map<std::string, int>;

/// Sets of joints and weights, four of each a vertex: real files have one or two.
constexpr int mostSets = 16;

int find(const Attributes& attributes, const std::string& name) {
    const auto found = attributes.find(name);
    return found == attributes.end() ? -1 : found->second;
}

vec3 unitOrZero(const dvec3& v) {
    const double length = std::sqrt(glm::dot(v, v));
    return length > 0.0 && std::isfinite(length) ? vec3(v / length) : vec3(0.0f);
}

int setCount(const tinygltf::Primitive& primitive) {
    int sets = 0;
    while (sets < mostSets && find(primitive.attributes, fmt::format("JOINTS_{}", sets)) >= 0) ++sets;
    return sets;
}

/// One of a primitive's morph targets, added to its vertices.
class Morph {
public:
    Morph(const Document& document, const tinygltf::Primitive& primitive, const std::string& pointer, Remarks& remarks)
        : document_(document), primitive_(primitive), pointer_(pointer), remarks_(remarks) {}

    void add(size_t target, double weight, std::vector<dvec3>& positions, std::vector<dvec3>& normals) const {
        const Attributes& attributes = primitive_.targets[target];
        addTo(positions, target, "POSITION", weight);
        addTo(normals, target, "NORMAL", weight);
        for (const auto& [name, accessor] : attributes)
            if (name != "POSITION" && name != "NORMAL" && name != "TANGENT")
                remarks_.add(fmt::format("morph targets' {} are left out", printable(name)));
    }

private:
    void addTo(std::vector<dvec3>& vectors, size_t target, const char* name, double weight) const {
        const int accessor = find(primitive_.targets[target], name);
        if (accessor < 0 || vectors.empty()) return;
        const bool isQuantized = std::ranges::count(document_.model.extensionsUsed, "KHR_mesh_quantization") > 0;
        checkType(document_, accessor,
                  {.components = 3,
                   .bytes = isQuantized,
                   .unsignedBytes = false,
                   .shorts = isQuantized,
                   .unsignedShorts = false,
                   .unsignedInts = false,
                   .floats = true,
                   .needsNormalized = false},
                  fmt::format("{}/targets/{}/{}", pointer_, target, name));
        const std::vector<vec3> more = readVec3(document_, accessor);
        for (size_t i = 0; i < vectors.size(); ++i) vectors[i] += weight * dvec3(more[i]);
    }

    const Document& document_;
    const tinygltf::Primitive& primitive_;
    const std::string& pointer_;
    Remarks& remarks_;
};

/// The joints that a primitive's vertices hang on, and how much.
struct Influences {
    size_t perVertex = 0;
    std::vector<uint32_t> joints;  ///< all below the skin's count
    std::vector<float> weights;    ///< finite and not negative
};

std::vector<uint32_t> readJoints(const Document& document, int accessor, size_t count, const std::string& place) {
    checkType(document, accessor,
              {.components = 4,
               .bytes = false,
               .unsignedBytes = true,
               .shorts = false,
               .unsignedShorts = true,
               .unsignedInts = false,
               .floats = false,
               .needsNormalized = false},
              place);
    std::vector<uint32_t> joints = readIndices(document, accessor);
    for (size_t i = 0; i < joints.size(); ++i)
        if (joints[i] >= count)
            throw errorAt(document, place, "element {} names joint {}, but the skin has {}", i / 4, joints[i], count);
    return joints;
}

std::vector<float> readWeights(const Document& document, int accessor, const std::string& place) {
    checkType(document, accessor,
              {.components = 4,
               .bytes = false,
               .unsignedBytes = true,
               .shorts = false,
               .unsignedShorts = true,
               .unsignedInts = false,
               .floats = true,
               .needsNormalized = true},
              place);
    std::vector<float> weights = readFloats(document, accessor);
    for (size_t i = 0; i < weights.size(); ++i)
        if (!(weights[i] >= 0.0f && std::isfinite(weights[i])))
            throw errorAt(document, place, "element {} holds {}, which is negative or not finite", i / 4, weights[i]);
    return weights;
}

/// Of each vertex the sets one after the other.
Influences readInfluences(const Document& document, const tinygltf::Primitive& primitive, const std::string& pointer,
                          size_t jointCount, size_t vertices) {
    const int sets = setCount(primitive);
    if (sets == 0)
        throw errorAt(document, pointer + "/attributes", "has no JOINTS_0, but a node shows the mesh with a skin");
    Influences result;
    result.perVertex = static_cast<size_t>(sets) * 4;
    result.joints.resize(vertices * result.perVertex);
    result.weights.resize(vertices * result.perVertex);
    for (int set = 0; set < sets; ++set) {
        const std::string jointsName = fmt::format("JOINTS_{}", set), weightsName = fmt::format("WEIGHTS_{}", set);
        const int weightsAccessor = find(primitive.attributes, weightsName);
        if (weightsAccessor < 0)
            throw errorAt(document, pointer + "/attributes", "has {}, but no {}", jointsName, weightsName);
        const std::string place = pointer + "/attributes/";
        const auto joints = readJoints(document, find(primitive.attributes, jointsName), jointCount, place + jointsName);
        const auto weights = readWeights(document, weightsAccessor, place + weightsName);
        for (size_t i = 0; i < joints.size(); ++i) {
            const size_t at = i / 4 * result.perVertex + static_cast<size_t>(set) * 4 + i % 4;
            result.joints[at] = joints[i];
            result.weights[at] = weights[i];
        }
    }
    return result;
}

/// The average of a vertex's joints' matrices; that of the first joint where it has no weight.
dmat4 blend(const Influences& influences, size_t vertex, const std::vector<dmat4>& matrices, bool& isWeightless) {
    const size_t first = vertex * influences.perVertex;
    double sum = 0.0;
    for (size_t k = 0; k < influences.perVertex; ++k) sum += influences.weights[first + k];
    isWeightless = !(sum > 0.0);
    if (isWeightless) return matrices[influences.joints[first]];
    dmat4 average(0.0);
    for (size_t k = 0; k < influences.perVertex; ++k) {
        const double weight = influences.weights[first + k];
        if (weight > 0.0) average += weight / sum * matrices[influences.joints[first + k]];
    }
    // As rounding has it, the weights' sum may miss 1 by a little.
    average[0].w = average[1].w = average[2].w = 0.0;
    average[3].w = 1.0;
    return average;
}

}  // namespace

Bend bendOf(const Document& document, const tinygltf::Node& node) {
    Bend bend{node.skin, node.weights.empty() ? document.model.meshes[node.mesh].weights : node.weights};
    if (std::ranges::all_of(bend.weights, [](double weight) { return weight == 0.0; })) bend.weights.clear();
    return bend;
}

std::vector<int> bendAccessors(const tinygltf::Primitive& primitive, const Bend& bend) {
    std::vector<int> accessors;
    if (bend.skin >= 0)
        for (int set = 0; set < setCount(primitive); ++set)
            for (const char* name : {"JOINTS_{}", "WEIGHTS_{}"})
                accessors.push_back(find(primitive.attributes, fmt::format(fmt::runtime(name), set)));
    for (size_t target = 0; target < bend.weights.size(); ++target)
        if (bend.weights[target] != 0.0)
            for (const char* name : {"POSITION", "NORMAL"}) accessors.push_back(find(primitive.targets[target], name));
    return accessors;
}

size_t bendCost(const tinygltf::Primitive& primitive, const Bend& bend, size_t vertices) {
    return bendAccessors(primitive, bend).size() * vertices;
}

std::vector<bool> bend(const Document& document, const tinygltf::Primitive& primitive, const std::string& pointer,
                       const Bend& how, Skins& skins, std::span<vec3> positions, std::span<vec3> normals, Remarks& remarks) {
    std::vector<dvec3> places(positions.begin(), positions.end()), directions(normals.begin(), normals.end());
    const Morph morph(document, primitive, pointer, remarks);
    for (size_t target = 0; target < how.weights.size(); ++target)
        if (how.weights[target] != 0.0) morph.add(target, how.weights[target], places, directions);
    if (!how.weights.empty()) std::ranges::transform(directions, normals.begin(), unitOrZero);
    std::vector<bool> mirrored;
    if (how.skin >= 0) {
        const Influences influences =
            readInfluences(document, primitive, pointer, skins.jointCount(how.skin), positions.size());
        const std::vector<dmat4>& matrices = skins.matrices(how.skin);
        mirrored.resize(positions.size());
        size_t weightless = 0;
        for (size_t i = 0; i < places.size(); ++i) {
            bool isWeightless = false;
            const dmat4 toWorld = blend(influences, i, matrices, isWeightless);
            weightless += isWeightless;
            places[i] = dvec3(toWorld * dvec4(places[i], 1.0));
            if (!normals.empty()) normals[i] = shared::placeNormal(normalPlacementOf(toWorld), normals[i]);
            mirrored[i] = mirrors(toWorld);
        }
        if (weightless > 0) remarks.add("a vertex of a skinned mesh has no weight: it follows its first joint", weightless);
    }
    std::ranges::transform(places, positions.begin(), [](const dvec3& place) { return vec3(place); });
    return mirrored;
}

}  // namespace raig::gltf
