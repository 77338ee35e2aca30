/// Skins and morph targets: meshes bent as nodes show them. Internal to the glTF importer (scene/gltf.cpp).
#pragma once

#include "scene/gltf_document.hpp"

namespace raig::gltf {

/// A node of the scene that is shown, and where it is.
struct PlacedNode {
    size_t node = 0;
    dmat4 toWorld{1.0};
};

/// How a mesh is bent. Meshes that are bent alike are stored once.
struct Bend {
    int skin = -1;                ///< -1: none
    std::vector<double> weights;  ///< one a morph target; empty if all are zero

    bool isNone() const { return skin < 0 && weights.empty(); }
    bool operator==(const Bend&) const = default;
};

/// How a node bends its mesh: its weights, or else the mesh's.
Bend bendOf(const Document& document, const tinygltf::Node& node);

/// The joints of a document's skins, as its nodes place them.
class Skins {
public:
    /// Throws inputError where a skin has no joints, or names something that is not there, or matrices of a wrong type or
    /// too few. Requires a node graph without cycles, as placeNodes has it.
    explicit Skins(const Document& document);

    /// What each joint does to a vertex of a mesh that has the skin: inverse bind matrix, then the joint to the world. Read
    /// once; throws inputError where one is not finite or not affine.
    const std::vector<dmat4>& matrices(int skin);
    size_t jointCount(int skin) const { return document_.skins[skin]["joints"].size(); }

private:
    const dmat4& worldOf(size_t node);

    const Document& document_;
    std::vector<int> parents_;
    std::map<size_t, dmat4> known_;  ///< nodes to the world
    std::map<int, std::vector<dmat4>> matrices_;
};

/// How many vectors bend() reads for `vertices` of them.
size_t bendCost(const tinygltf::Primitive& primitive, const Bend& bend, size_t vertices);

/// The accessors that bend() reads for a primitive: primitives with other attributes alike share vertices only if these are.
std::vector<int> bendAccessors(const tinygltf::Primitive& primitive, const Bend& bend);

/// Bends the vertices of a primitive, whose positions and normals (unit or zero; or none) are as its attributes have them:
/// morph targets are added, weighted; then, with a skin, vertices go where their joints' matrices, averaged by weight, put
/// them in the world. Normals go with the cofactors of that average, outside stays outside, and are unit or zero after it.
/// Returns, with a skin, whether a vertex is mirrored; else nothing.
///
/// Throws   inputError where a skinned primitive lacks joints or weights, one of them is of a wrong type or out of range, or
///          a target is of a wrong type.
/// Source   glTF 2.0 specification, sections 3.7.2.2 and 3.7.3.3.
std::vector<bool> bend(const Document& document, const tinygltf::Primitive& primitive, const std::string& pointer,
                       const Bend& how, Skins& skins, std::span<vec3> positions, std::span<vec3> normals, Remarks& remarks);

}  // namespace raig::gltf
