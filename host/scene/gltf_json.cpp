#include "scene/gltf_document.hpp"

#include <algorithm>
#include <climits>
#include <set>

namespace raig::gltf {

namespace {

using Json = nlohmann::json;
using Names = std::set<std::string_view>;

/// Deeper than any real file (about 10), shallow enough for recursion.
constexpr int deepestNesting = 200;

const Names supportedExtensions = {
    "EXT_mesh_gpu_instancing", "KHR_implicit_shapes",        "KHR_lights_punctual", "KHR_materials_emissive_strength",
    "KHR_materials_ior",       "KHR_materials_transmission", "KHR_materials_unlit", "KHR_materials_volume",
    "KHR_mesh_quantization",   "KHR_texture_transform"};

/// Members that must be non-negative integers, wherever they hold no array or object.
const Names integerMembers = {"buffer",        "bufferView", "byteLength", "byteOffset", "byteStride", "camera",
                              "componentType", "count",      "index",      "indices",    "input",      "inverseBindMatrices",
                              "light",         "material",   "mesh",       "mode",       "node",       "output",
                              "sampler",       "scene",      "shape",      "skeleton",   "skin",       "source",
                              "texCoord",      "wrapS",      "wrapT"};
/// The ones among them that may exceed an int.
const Names sizeMembers = {"byteLength", "byteOffset", "byteStride", "count"};
/// Arrays whose elements, unless objects, must be non-negative integers.
const Names integerArrays = {"children", "joints", "nodes"};
/// Members that must be numbers, or arrays of numbers.
const Names numberMembers = {"aspectRatio",
                             "attenuationColor",
                             "attenuationDistance",
                             "baseColorFactor",
                             "color",
                             "emissiveFactor",
                             "emissiveStrength",
                             "innerConeAngle",
                             "intensity",
                             "ior",
                             "matrix",
                             "metallicFactor",
                             "offset",
                             "outerConeAngle",
                             "radius",
                             "range",
                             "rotation",
                             "roughnessFactor",
                             "scale",
                             "thicknessFactor",
                             "translation",
                             "transmissionFactor",
                             "weights",
                             "xmag",
                             "yfov",
                             "ymag",
                             "zfar",
                             "znear"};
const Names stringMembers = {"alphaMode", "interpolation", "minVersion", "path", "type", "uri", "version"};
const Names objectMembers = {"asset",
                             "attributes",
                             "baseColorTexture",
                             "emissiveTexture",
                             "extensions",
                             "metallicRoughnessTexture",
                             "normalTexture",
                             "occlusionTexture",
                             "orthographic",
                             "pbrMetallicRoughness",
                             "perspective",
                             "sparse",
                             "sphere",
                             "spot",
                             "transmissionTexture"};
const Names arrayMembers = {
    "accessors",      "animations", "bufferViews", "buffers", "cameras",   "channels", "children", "extensionsRequired",
    "extensionsUsed", "images",     "joints",      "lights",  "materials", "meshes",   "nodes",    "primitives",
    "samplers",       "scenes",     "shapes",      "skins",   "targets",   "textures"};

/// The way from the root to a value, kept on the call stack and spelt out only for a message.
struct Step {
    const Step* parent = nullptr;
    std::string_view key;
    size_t index = 0;
    bool isIndex = false;

    std::string pointer() const {
        if (!parent) return "";
        return parent->pointer() + "/" + (isIndex ? fmt::format("{}", index) : printable(key));
    }
    bool isInside(std::string_view name) const { return parent && ((!isIndex && key == name) || parent->isInside(name)); }
};

/// Walks the document once, checking the kind of each known member and taking out what nobody reads.
class ShapeCheck {
public:
    explicit ShapeCheck(const std::string& file) : file_(file) {}

    void walk(Json& value, const Step& at) {
        if (value.is_object()) walkObject(value, at);
        if (value.is_array()) walkArray(value, at);
    }

private:
    void walkObject(Json& object, const Step& at) {
        object.erase("extras");
        const bool areExtensions = !at.isIndex && at.key == "extensions";
        if (areExtensions) eraseUnsupported(object);
        const bool isPrimitive = at.isIndex && at.parent && at.parent->key == "primitives";
        const auto extensions = object.find("extensions");
        // tinygltf knows no primitives without attributes.
        if (isPrimitive && !object.contains("attributes") && extensions != object.end() && extensions->is_object() &&
            extensions->contains("KHR_implicit_shapes"))
            object["attributes"] = Json::object();
        // A morph target is an object of attributes, too.
        const bool areAttributes =
            at.isIndex ? at.parent && !at.parent->isIndex && at.parent->key == "targets" : at.key == "attributes";
        for (auto& [key, child] : object.items()) {
            const Step step{&at, key, 0, false};
            if (areAttributes) {
                requireInteger(child, step, INT_MAX);
            } else if (areExtensions) {
                require(child.is_object(), step, "an object");
            } else {
                checkMember(key, child, step);
            }
            walk(child, step);
        }
    }

    void walkArray(Json& array, const Step& at) {
        const bool needsIntegers = !at.isIndex && integerArrays.contains(at.key);
        const bool needsNumbers = !at.isIndex && numberMembers.contains(at.key);
        const bool needsStrings = !at.isIndex && (at.key == "extensionsRequired" || at.key == "extensionsUsed");
        const bool needsObjects = !at.isIndex && arrayMembers.contains(at.key) && !needsStrings && !needsIntegers;
        for (size_t i = 0; i < array.size(); ++i) {
            const Step step{&at, {}, i, true};
            if (needsIntegers && !array[i].is_object()) requireInteger(array[i], step, INT_MAX);
            if (needsNumbers) require(array[i].is_number(), step, "a number");
            if (needsNumbers && array[i].is_number_integer()) array[i] = array[i].get<double>();
            if (needsStrings) require(array[i].is_string(), step, "a string");
            if (needsObjects) require(array[i].is_object(), step, "an object");
            walk(array[i], step);
        }
    }

    void checkMember(std::string_view key, Json& child, const Step& at) {
        if (integerMembers.contains(key) && !child.is_structured()) {
            const bool mayBeLarge = sizeMembers.contains(key) && !at.isInside("sparse");
            requireInteger(child, at, mayBeLarge ? uint64_t{1} << 53 : INT_MAX);
        }
        if (numberMembers.contains(key)) require(child.is_number() || child.is_array(), at, "a number or numbers");
        // tinygltf wraps whole numbers in extensions to an int.
        if (numberMembers.contains(key) && child.is_number_integer()) child = child.get<double>();
        if (stringMembers.contains(key)) require(child.is_string(), at, "a string");
        const bool isChannels = key == "target" && at.isInside("channels");  // a bufferView's is a number
        if (objectMembers.contains(key) || isChannels) require(child.is_object(), at, "an object");
        if (arrayMembers.contains(key)) require(child.is_array(), at, "an array");
        if (key == "normalized") require(child.is_boolean(), at, "true or false");
    }

    void eraseUnsupported(Json& extensions) {
        for (auto it = extensions.begin(); it != extensions.end();)
            it = isSupportedExtension(it.key()) ? std::next(it) : extensions.erase(it);
    }

    void requireInteger(const Json& value, const Step& at, uint64_t largest) {
        require(value.is_number_unsigned() && value.get<uint64_t>() <= largest, at, "a non-negative integer in range");
    }
    void require(bool holds, const Step& at, const char* kind) {
        if (!holds) throw inputError(file_ + "#" + at.pointer(), "must be {}", kind);
    }

    const std::string& file_;
};

/// Counts brackets outside strings, so that neither the parser nor tinygltf (which recurses) meets what is too deep.
void checkNesting(std::string_view text, const std::string& file) {
    int depth = 0;
    bool inString = false;
    for (size_t i = 0; i < text.size(); ++i) {
        const char c = text[i];
        if (inString) {
            if (c == '\\') ++i;
            inString = c != '"';
        } else if (c == '"') {
            inString = true;
        } else if (c == '{' || c == '[') {
            if (++depth > deepestNesting)
                throw inputError(file, "its JSON is nested more than {} levels deep, at byte {}", deepestNesting, i);
        } else if (c == '}' || c == ']') {
            --depth;
        }
    }
}

}  // namespace

bool isSupportedExtension(std::string_view name) {
    return supportedExtensions.contains(name);
}

std::string printable(std::string_view text, size_t most) {
    while (text.ends_with('\n')) text.remove_suffix(1);
    size_t length = std::min(text.size(), most);
    // Not in the middle of a UTF-8 sequence, whose bytes after the first are 10xxxxxx.
    while (length > 0 && length < text.size() && (text[length] & 0xc0) == 0x80) --length;
    std::string clean(text.substr(0, length));
    std::replace_if(
        clean.begin(), clean.end(), [](char c) { return (c >= 0 && c < 32) || c == 127; }, '?');
    return text.size() > length ? clean + "..." : clean;
}

nlohmann::json parseJson(std::string_view text, const std::string& file) {
    checkNesting(text, file);
    Json json;
    try {
        json = Json::parse(text);
    } catch (const Json::exception& problem) {
        throw inputError(file, "its JSON cannot be parsed: {}", printable(problem.what(), 200));
    }
    if (!json.is_object()) throw inputError(file, "its JSON is not an object; is this a glTF file?");
    ShapeCheck(file).walk(json, Step{});
    return json;
}

}  // namespace raig::gltf
