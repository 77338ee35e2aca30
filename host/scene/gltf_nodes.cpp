#include "scene/gltf_parts.hpp"

namespace raig::gltf {

namespace {

/// An instance takes some 150 bytes: 2.5 GB at this many.
constexpr size_t mostInstances = size_t{1} << 20;  // a few bytes of a file make one, and it takes up to 1 kB

bool isFinite(const dmat4& m) {
    for (int column = 0; column < 4; ++column)
        for (int row = 0; row < 4; ++row)
            if (!std::isfinite(m[column][row])) return false;
    return true;
}

/// Each node has at most one parent, so what no walk from a parentless node reaches is a cycle.
void checkForest(const Document& document, const std::vector<int>& parents) {
    std::vector<int> open;
    std::vector<bool> reached(parents.size(), false);
    for (size_t i = 0; i < parents.size(); ++i)
        if (parents[i] < 0) open.push_back(static_cast<int>(i));
    while (!open.empty()) {
        const int node = open.back();
        open.pop_back();
        reached[node] = true;
        const std::vector<int>& children = document.model.nodes[node].children;
        open.insert(open.end(), children.begin(), children.end());
    }
    for (size_t i = 0; i < reached.size(); ++i)
        if (!reached[i]) throw errorAt(document, fmt::format("/nodes/{}", i), "is its own ancestor: the nodes form a cycle");
}

/// The default scene's roots; scene 0's if none is the default; every root if there is no scene.
std::vector<int> rootsOf(const Document& document, const std::vector<int>& parents, Remarks& remarks) {
    const tinygltf::Model& model = document.model;
    if (model.scenes.empty()) {
        std::vector<int> roots;
        for (size_t i = 0; i < parents.size(); ++i)
            if (parents[i] < 0) roots.push_back(static_cast<int>(i));
        return roots;
    }
    const size_t scene = model.defaultScene >= 0 ? static_cast<size_t>(model.defaultScene) : 0;
    if (model.scenes.size() > 1) remarks.add(fmt::format("of {} scenes, scene {} is used", model.scenes.size(), scene));
    std::vector<bool> seen(model.nodes.size(), false);
    for (const int root : model.scenes[scene].nodes) {
        if (seen[root]) throw errorAt(document, fmt::format("/scenes/{}/nodes", scene), "names node {} twice", root);
        seen[root] = true;
    }
    return model.scenes[scene].nodes;
}

void addNode(const Document& document, const PlacedNode& placed, uint32_t mesh, Scene& scene, Remarks& remarks) {
    const tinygltf::Node& node = document.model.nodes[placed.node];
    const std::string pointer = fmt::format("/nodes/{}", placed.node);
    if (node.mesh >= 0) {
        // A skinned mesh is in the world already: its joints have put it there, and its node has no say in it.
        const dmat4 toWorld = node.skin >= 0 ? dmat4(1.0) : placed.toWorld;
        for (const dmat4& copy : copiesOf(document, placed.node)) {
            const dmat4 copyToWorld = toWorld * copy;
            if (!isFinite(copyToWorld)) throw errorAt(document, pointer, "its transform to the world is not finite");
            scene.instances.push_back({mesh, copyToWorld});
        }
        if (scene.instances.size() > mostInstances)
            throw limitError("{}#{}: the scene has more than {} instances", document.file, pointer, mostInstances);
    }
    if (node.camera >= 0)
        if (const auto camera = cameraAt(document, node.camera, placed.toWorld, remarks)) scene.cameras.push_back(*camera);
    if (const int light = lightOf(document, placed.node); light >= 0)
        if (const auto shining = lightAt(document, light, placed.toWorld, remarks)) scene.lights.push_back(*shining);
}

}  // namespace

std::vector<int> parentsOf(const tinygltf::Model& model) {
    std::vector<int> parents(model.nodes.size(), -1);
    for (size_t i = 0; i < model.nodes.size(); ++i)
        for (const int child : model.nodes[i].children) parents[child] = static_cast<int>(i);
    return parents;
}

std::vector<PlacedNode> placeNodes(const Document& document, Remarks& remarks) {
    struct Open {
        int node;
        dmat4 parentToWorld;
    };
    const std::vector<int> parents = parentsOf(document.model);
    checkForest(document, parents);
    std::vector<PlacedNode> placed;
    std::vector<Open> open;
    const std::vector<int> roots = rootsOf(document, parents, remarks);
    for (auto root = roots.rbegin(); root != roots.rend(); ++root) open.push_back({*root, dmat4(1.0)});
    while (!open.empty()) {
        const Open at = open.back();
        open.pop_back();
        const dmat4 toWorld = at.parentToWorld * localTransform(document, at.node);
        if (!isFinite(toWorld))
            throw errorAt(document, fmt::format("/nodes/{}", at.node), "its transform to the world is not finite");
        placed.push_back({static_cast<size_t>(at.node), toWorld});
        const std::vector<int>& children = document.model.nodes[at.node].children;
        for (auto child = children.rbegin(); child != children.rend(); ++child) open.push_back({*child, toWorld});
    }
    return placed;
}

void addNodes(const Document& document, const std::vector<PlacedNode>& placed, const std::vector<uint32_t>& meshes,
              Scene& scene, Remarks& remarks) {
    for (size_t i = 0; i < placed.size(); ++i) addNode(document, placed[i], meshes[i], scene, remarks);
}

}  // namespace raig::gltf
