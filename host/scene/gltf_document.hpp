/// A glTF file as its parts read it: the model as tinygltf understands it, and the bytes behind it as we read them.
///
/// Internal to the glTF importer (scene/gltf.cpp). The bytes (GLB chunks, data URIs, files) never pass through tinygltf,
/// which neither bounds what it reads nor keeps to the scene's folder; and the JSON is checked before tinygltf sees it,
/// since it crashes on deep nesting, wraps large integers, and skips in silence what has the wrong type.
#pragma once

#include "base/error.hpp"
#include "scene/scene.hpp"

#include <tiny_gltf.h>
#include <nlohmann/json.hpp>

#include <filesystem>
#include <map>
#include <span>
#include <string_view>

namespace raig::gltf {

using Bytes = std::span<const std::byte>;

/// Where an image's encoded bytes are: in a buffer view, or behind a URI.
struct ImageSource {
    int bufferView = -1;
    std::string uri;
};

struct Document {
    std::string file;                           ///< the path given, for messages
    std::filesystem::path folder;               ///< what URIs are relative to, and may not leave
    tinygltf::Model model;                      ///< without buffers, images, animations, skins and extras
    std::vector<std::byte> bytes;               ///< the file
    std::vector<std::vector<std::byte>> owned;  ///< what URIs held
    std::vector<Bytes> buffers;                 ///< each of its declared length
    std::vector<ImageSource> images;
    std::vector<std::string> ignoredExtensions;  ///< used, not required, and not supported
    nlohmann::json animations;                   ///< arrays of objects, of which only the members' kinds are checked
    nlohmann::json skins;
};

/// What was left out or assumed, each once with how often.
class Remarks {
public:
    void add(const std::string& text, size_t times = 1) { counts_[text] += times; }
    std::vector<std::string> lines() const;

private:
    std::map<std::string, size_t> counts_;
};

/// Names taken from a file, made fit for a one-line message: no control characters, at most `most` bytes.
std::string printable(std::string_view text, size_t most = 80);

/// inputError at a JSON pointer of the document: "scene.gltf#/nodes/3: ...".
template <class... Args>
[[nodiscard]] Error errorAt(const Document& document, const std::string& pointer, fmt::format_string<Args...> format,
                            Args&&... args) {
    return inputError(document.file + "#" + pointer, format, std::forward<Args>(args)...);
}

/// Parses glTF's JSON (gltf_json.cpp).
///
/// Ensures   nesting of at most 200; members that name or count things are non-negative integers that tinygltf's int or
///           size_t hold; numbers, booleans, strings, arrays and objects are where the specification wants them.
///           `extras` and unsupported extensions are taken out. Primitives that are shapes get attributes, none.
/// Throws    inputError with the JSON pointer.
nlohmann::json parseJson(std::string_view text, const std::string& file);

/// True for the extensions that the importer understands.
bool isSupportedExtension(std::string_view name);

/// The bytes of a data URI or of a file below `folder` (gltf_uri.cpp). Throws inputError naming `place`.
std::vector<std::byte> readUri(const std::string& uri, const std::filesystem::path& folder, const std::string& place);

/// Reads and parses a .gltf or .glb (told apart by content) and reads its buffers (gltf_document.cpp).
Document readDocument(const std::filesystem::path& path);

/// A number in JSON that names or counts things. Throws inputError at `pointer` if it is anything else.
size_t wholeNumber(const Document& document, const nlohmann::json& number, const std::string& pointer);

/// How many morph targets a mesh has: all of its primitives have as many.
size_t targetCount(const tinygltf::Mesh& mesh);

/// Checks every index, range and count of the model against the document (gltf_check.cpp). The other parts rely on it:
/// after it no index is out of range and no accessor reaches outside its buffer view.
void checkModel(const Document& document);

}  // namespace raig::gltf
