#include "scene/gltf_document.hpp"

#include "base/files.hpp"

#include <cstring>

namespace raig::gltf {

namespace {

using Json = nlohmann::json;

/// tinygltf and our own checks need some ten times the text's size.
constexpr size_t longestJson = size_t{512} << 20;

uint32_t readWord(Bytes bytes, size_t offset) {
    uint32_t word = 0;
    for (int i = 3; i >= 0; --i) word = word << 8 | std::to_integer<uint32_t>(bytes[offset + i]);
    return word;
}

struct Chunks {
    Bytes json;
    Bytes binary;  ///< empty if there is none
};

bool isGlb(Bytes bytes) {
    return bytes.size() >= 4 && std::memcmp(bytes.data(), "glTF", 4) == 0;
}

/// The chunks of a GLB: glTF 2.0 specification, section 4.4.
Chunks splitGlb(Bytes bytes, const std::string& file) {
    constexpr uint32_t jsonType = 0x4e4f534a, binaryType = 0x004e4942;
    if (bytes.size() < 20) throw inputError(file, "is too short for a GLB");
    if (readWord(bytes, 4) != 2) throw inputError(file, "is GLB version {}; only version 2 is read", readWord(bytes, 4));
    const uint32_t length = readWord(bytes, 8);
    if (length > bytes.size())
        throw inputError(file, "says it holds {} bytes but has {}; it may be cut short", length, bytes.size());
    bytes = bytes.first(length);
    Chunks chunks;
    for (size_t at = 12, count = 0; at < bytes.size(); ++count) {
        if (bytes.size() - at < 8) throw inputError(file, "chunk {} is cut short", count);
        const uint32_t size = readWord(bytes, at), type = readWord(bytes, at + 4);
        if (size > bytes.size() - at - 8) throw inputError(file, "chunk {} reaches beyond the end of the file", count);
        const Bytes chunk = bytes.subspan(at + 8, size);
        if (count == 0 && type != jsonType) throw inputError(file, "its first chunk is not JSON");
        if (count == 0) chunks.json = chunk;
        if (count == 1 && type == binaryType) chunks.binary = chunk;
        at += 8 + size_t{size};
    }
    if (chunks.json.empty()) throw inputError(file, "has no JSON chunk");
    return chunks;
}

void checkVersion(const Document& document, const Json& json) {
    const Json asset = json.value("asset", Json::object());
    const std::string version = asset.value("version", "");
    if (version.empty()) throw errorAt(document, "/asset/version", "is missing; is this a glTF file?");
    if (!version.starts_with("2."))
        throw errorAt(document, "/asset/version", "is {}; only glTF 2 is read", printable(version));
    const std::string minVersion = asset.value("minVersion", "2.0");
    if (minVersion != "2.0")
        throw errorAt(document, "/asset/minVersion", "asks for glTF {}; only 2.0 is read", printable(minVersion));
}

void checkExtensions(Document& document, const Json& json) {
    const Json required = json.value("extensionsRequired", Json::array());
    for (size_t i = 0; i < required.size(); ++i)
        if (const auto name = required[i].get<std::string>(); !isSupportedExtension(name))
            throw errorAt(document, fmt::format("/extensionsRequired/{}", i),
                          "the scene needs the extension {}, which is not supported", printable(name));
    for (const Json& used : json.value("extensionsUsed", Json::array()))
        if (const auto name = used.get<std::string>(); !isSupportedExtension(name))
            document.ignoredExtensions.push_back(printable(name));
}

void readBuffers(Document& document, const Json& buffers, Bytes binaryChunk) {
    document.owned.reserve(buffers.size());  // spans point into it
    for (size_t i = 0; i < buffers.size(); ++i) {
        const std::string pointer = fmt::format("/buffers/{}", i);
        if (!buffers[i].contains("byteLength")) throw errorAt(document, pointer, "has no byteLength");
        const uint64_t length = buffers[i]["byteLength"].get<uint64_t>();
        Bytes bytes = binaryChunk;
        if (buffers[i].contains("uri")) {
            const auto& uri = buffers[i]["uri"].get_ref<const std::string&>();
            document.owned.push_back(readUri(uri, document.folder, document.file + "#" + pointer));
            bytes = document.owned.back();
        } else if (i != 0 || binaryChunk.empty()) {
            throw errorAt(document, pointer, "has neither a uri nor a binary chunk");
        }
        if (length > bytes.size()) throw errorAt(document, pointer, "declares {} bytes but has {}", length, bytes.size());
        document.buffers.push_back(bytes.first(length));
    }
}

void listImages(Document& document, const Json& images) {
    for (size_t i = 0; i < images.size(); ++i) {
        ImageSource source;
        source.uri = images[i].value("uri", "");
        if (images[i].contains("bufferView")) source.bufferView = images[i]["bufferView"].get<int>();
        if (images[i].contains("bufferView") == images[i].contains("uri"))
            throw errorAt(document, fmt::format("/images/{}", i), "must have either a uri or a bufferView");
        document.images.push_back(std::move(source));
    }
}

/// Takes member `name` out of the document; an empty array if it is not there.
Json take(Json& json, const char* name) {
    const auto found = json.find(name);
    if (found == json.end()) return Json::array();
    Json taken = std::move(*found);
    json.erase(found);
    return taken;
}

/// What is left, without bytes or files in it, in tinygltf's terms.
void parseModel(Document& document, const Json& json) {
    tinygltf::TinyGLTF parser;
    std::string errors, warnings;
    const std::string text = json.dump();
    bool parsed = false;
    try {
        parsed = parser.LoadASCIIFromString(&document.model, &errors, &warnings, text.data(),
                                            static_cast<unsigned>(text.size()), "");
    } catch (const std::bad_alloc&) {
        throw;
    } catch (const std::exception& problem) {
        errors = problem.what();
    }
    // tinygltf also reports trouble with optional members while it returns true, and drops what they belong to.
    if (!parsed || !errors.empty()) throw inputError(document.file, "is not valid glTF: {}", printable(errors, 200));
}

}  // namespace

std::vector<std::string> Remarks::lines() const {
    std::vector<std::string> lines;
    for (const auto& [text, count] : counts_) lines.push_back(count == 1 ? text : fmt::format("{} ({} times)", text, count));
    return lines;
}

Document readDocument(const std::filesystem::path& path) {
    Document document;
    document.file = path.string();
    document.folder = path.parent_path();
    document.bytes = readFile(path);
    Chunks chunks{document.bytes, {}};
    if (isGlb(document.bytes)) chunks = splitGlb(document.bytes, document.file);
    if (chunks.json.size() > longestJson)
        throw limitError("{}: holds {} bytes of JSON, more than the {} that can be read", document.file, chunks.json.size(),
                         longestJson);
    const std::string_view text(reinterpret_cast<const char*>(chunks.json.data()), chunks.json.size());
    Json json = parseJson(text, document.file);
    checkVersion(document, json);
    checkExtensions(document, json);
    readBuffers(document, take(json, "buffers"), chunks.binary);
    listImages(document, take(json, "images"));
    document.animations = take(json, "animations");
    document.skins = take(json, "skins");
    parseModel(document, json);
    return document;
}

}  // namespace raig::gltf
