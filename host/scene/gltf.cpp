/// glTF 2.0 and GLB: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
///
/// The steps, one file each: the JSON's shape (gltf_json), the bytes (gltf_document, gltf_uri), indices and ranges
/// (gltf_check), which the rest relies on; then materials; and then, for each moment, where nodes are (gltf_animation,
/// gltf_nodes), meshes as they are bent (gltf_mesh, gltf_deform), and what stands at the nodes.
#include "scene/gltf_animation.hpp"
#include "scene/gltf_parts.hpp"
#include "scene/import.hpp"
#include "scene/spheres.hpp"
#include "scene/validate.hpp"

namespace raig {

struct GltfFile::State {
    gltf::Document document;
    std::vector<tinygltf::Node> nodesAtRest;
    Scene still;  ///< materials and images, which no moment changes
    std::vector<gltf::UvSource> uvSources;
    gltf::Remarks remarks;
};

GltfFile::GltfFile(const std::filesystem::path& path) : state_(std::make_unique<State>()) {
    gltf::Document& document = state_->document;
    document = gltf::readDocument(path);
    gltf::checkModel(document);
    state_->nodesAtRest = document.model.nodes;
    for (const std::string& name : document.ignoredExtensions) state_->remarks.add("the extension " + name + " is not used");
    state_->uvSources = gltf::addMaterials(document, state_->still, state_->remarks);
    state_->still.clips = gltf::listAnimations(document);
}

GltfFile::~GltfFile() = default;

Scene GltfFile::at(const Moment& moment) const {
    Scene scene = state_->still;
    finish(scene, moment);
    return scene;
}

Scene GltfFile::lastAt(const Moment& moment) {
    Scene scene = std::move(state_->still);
    finish(scene, moment);
    return scene;
}

void GltfFile::finish(Scene& scene, const Moment& moment) const {
    gltf::Document& document = state_->document;
    gltf::Remarks remarks = state_->remarks;
    document.model.nodes = state_->nodesAtRest;
    gltf::pose(document, moment, remarks);
    const std::vector<gltf::PlacedNode> placed = gltf::placeNodes(document, remarks);
    const std::vector<uint32_t> meshes = gltf::addMeshes(document, state_->uvSources, placed, scene, remarks);
    gltf::addNodes(document, placed, meshes, scene, remarks);
    if (const size_t deformed = writeOutDeformedSpheres(scene, document.file); deformed > 0)
        remarks.add("a sphere that its node scales unevenly is written out as triangles", deformed);
    scene.remarks = remarks.lines();

    const std::optional<std::string> fault = findFault(scene);
    if (fault) throw inputError(document.file, "{}", *fault);
}

Scene importGltf(const std::filesystem::path& path, const Moment& moment) {
    return GltfFile(path).lastAt(moment);
}

}  // namespace raig
