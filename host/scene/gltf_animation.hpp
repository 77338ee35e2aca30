/// What glTF's animations do to nodes. Internal to the glTF importer (scene/gltf.cpp).
#pragma once

#include "scene/gltf_document.hpp"
#include "scene/import.hpp"

namespace raig::gltf {

/// The animations' names, and how long they are as the file says (the largest time that a sampler's accessor declares).
std::vector<Clip> listAnimations(const Document& document);

/// Sets the nodes that the moment's animation moves to where they are then; at rest it only remarks what is not played.
/// Translations, rotations, scales and weights; other things are remarked. Before the first and after the last keyframe of
/// a channel its first and last value hold.
///
/// Requires  checkModel(document) has passed, and the nodes are as in the file.
/// Throws    usageError if there is no such animation; inputError where one that is played has something that is missing,
///           out of range, not finite, not in order, or of a wrong count or type; limitError if its channels would read
///           more than 2^28 numbers. Animations that are not played may be anything.
/// Source    glTF 2.0 specification, sections 3.11 and appendix C.
void pose(Document& document, const Moment& moment, Remarks& remarks);

}  // namespace raig::gltf
