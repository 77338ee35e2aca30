/// The steps from a checked document to a scene. Internal to the glTF importer (scene/gltf.cpp).
///
/// All require that checkModel(document) has passed, and throw inputError with a JSON pointer.
#pragma once

#include "scene/gltf_deform.hpp"
#include "scene/gltf_document.hpp"

namespace raig::gltf {

/// What a material's textures ask of a mesh.
struct UvSource {
    std::vector<int> sets;   ///< of texture coordinates, at most 2: Texture::set counts these
    bool hasNormals = false; ///< a normal texture is among them: tangents are of use
};

/// Appends every material, and the images that textures use, each once. A texture of transmission is replaced by its mean.
/// Returns one UvSource a material.
std::vector<UvSource> addMaterials(const Document& document, Scene& scene, Remarks& remarks);

/// A shape of KHR_implicit_shapes: only spheres have a radius here.
struct Shape {
    std::string type;
    float radius = 0.0f;

    bool isSphere() const { return radius > 0.0f; }
};

/// The document's shapes. Throws where one has no type, or a sphere no positive radius.
std::vector<Shape> readShapes(const Document& document);

/// The shape that a mesh's primitive is, or null. Throws if there is no such shape.
const Shape* shapeOf(const Document& document, const std::vector<Shape>& shapes, const tinygltf::Primitive& primitive,
                     const std::string& pointer);

/// The default scene's nodes, in depth-first order, and where they are. Transforms are multiplied in double precision.
/// Throws if the node graph has a cycle.
std::vector<PlacedNode> placeNodes(const Document& document, Remarks& remarks);

/// Of each node its parent, or -1.
std::vector<int> parentsOf(const tinygltf::Model& model);

/// Appends every mesh, in the file's order: bent as the first of `placed` that shows it has it, and, after all of them,
/// those that are shown bent otherwise, too. Primitives of one mesh are concatenated, all triangles before all spheres;
/// those that share their attributes share their vertices. Throws limitError if more than 2^28 vertices or indices would
/// have to be written out. Returns the scene's mesh that each of `placed` shows, 0 for those that show none.
std::vector<uint32_t> addMeshes(const Document& document, const std::vector<UvSource>& uvSources,
                                const std::vector<PlacedNode>& placed, Scene& scene, Remarks& remarks);

/// Appends an instance for each mesh, a camera for each camera and a light for each light among `placed`, in their order.
/// `meshes`: as addMeshes returns them.
void addNodes(const Document& document, const std::vector<PlacedNode>& placed, const std::vector<uint32_t>& meshes,
              Scene& scene, Remarks& remarks);

/// A matrix of 16 numbers, column by column; zero ones are read as one that maps all to the origin. Throws if it is not
/// affine.
dmat4 readMatrix(const Document& document, const std::vector<double>& numbers, const std::string& pointer);

/// A node's own transform, affine. Throws if it is not.
dmat4 localTransform(const Document& document, size_t node);

/// EXT_mesh_gpu_instancing's transforms, relative to the node; one identity without the extension.
std::vector<dmat4> copiesOf(const Document& document, size_t node);

/// The camera or light that stands at `toWorld`, or nothing (and a remark) if it has no direction there.
std::optional<Camera> cameraAt(const Document& document, int camera, const dmat4& toWorld, Remarks& remarks);
std::optional<Light> lightAt(const Document& document, int light, const dmat4& toWorld, Remarks& remarks);

/// The light that KHR_lights_punctual puts at a node, or -1. Throws if there is no such light.
int lightOf(const Document& document, size_t node);

/// A member of an extension's object, as a number; `otherwise` if it is absent.
double numberIn(const tinygltf::Value& object, const char* name, double otherwise);

/// A material's extension of that name, or null.
const tinygltf::Value* findExtension(const tinygltf::ExtensionMap& extensions, const char* name);

/// Three numbers in an extension's object, 1 each if absent. Throws if there are more or fewer.
dvec3 colorIn(const Document& document, const tinygltf::Value& object, const char* name, const std::string& pointer);

}  // namespace raig::gltf
