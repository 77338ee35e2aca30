/// glTF 2.0 and GLB: https://registry.khronos.org/glTF/specs/2.0/glTF-2.0.html
///
/// The steps, one file each: the JSON's shape (gltf_json), the bytes (gltf_document, gltf_uri), indices and ranges
/// (gltf_check), then materials, meshes and nodes, which rely on those checks.
#include "scene/gltf_parts.hpp"
#include "scene/import.hpp"
#include "scene/spheres.hpp"
#include "scene/validate.hpp"

namespace raig {

Scene importGltf(const std::filesystem::path& path) {
    const gltf::Document document = gltf::readDocument(path);
    gltf::checkModel(document);

    Scene scene;
    gltf::Remarks remarks;
    for (const std::string& name : document.ignoredExtensions) remarks.add("the extension " + name + " is not used");
    if (document.animationCount > 0) remarks.add("animations are not played: everything is in its rest pose");
    if (document.skinCount > 0) remarks.add("skins are not applied: meshes are in their rest pose, moved by their nodes");
    if (document.morphedCount > 0) remarks.add("morph targets are not applied");
    const std::vector<gltf::UvSource> uvSources = gltf::addMaterials(document, scene, remarks);
    gltf::addMeshes(document, uvSources, scene, remarks);
    gltf::addNodes(document, scene, remarks);
    if (const size_t deformed = writeOutDeformedSpheres(scene, document.file); deformed > 0)
        remarks.add("a sphere that its node scales unevenly is written out as triangles", deformed);
    scene.remarks = remarks.lines();

    const std::optional<std::string> fault = findFault(scene);
    if (fault) throw inputError(document.file, "{}", *fault);
    return scene;
}

}  // namespace raig
