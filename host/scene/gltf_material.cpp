#include "scene/gltf_parts.hpp"
#include "scene/import.hpp"

#include <algorithm>

namespace raig::gltf {

namespace {

Wrap wrapOf(const Document& document, int sampler, int mode, const char* axis) {
    switch (mode) {
        case TINYGLTF_TEXTURE_WRAP_REPEAT:
            return Wrap::repeat;
        case TINYGLTF_TEXTURE_WRAP_CLAMP_TO_EDGE:
            return Wrap::clamp;
        case TINYGLTF_TEXTURE_WRAP_MIRRORED_REPEAT:
            return Wrap::mirror;
        default:
            throw errorAt(document, fmt::format("/samplers/{}/{}", sampler, axis), "is {}, which is no wrap mode", mode);
    }
}

/// Adds the file's materials to the scene, and the images they need.
class MaterialReader {
public:
    MaterialReader(const Document& document, Scene& scene, Remarks& remarks)
        : document_(document), scene_(scene), remarks_(remarks), places_(document.images.size(), notLoaded) {}

    UvSource add(size_t index);

private:
    static constexpr int notLoaded = -1;
    static constexpr int unusable = -2;

    void readExtensions(const tinygltf::ExtensionMap& extensions, const std::string& pointer, Material& material,
                        double& strength);
    UvSource readTextures(const tinygltf::Material& source, const std::string& pointer, Material& material);
    template <class Info>
    std::optional<Texture> readTexture(const Info& info, const std::string& pointer, UvSource& uvSource);
    void readTransform(const tinygltf::Value& transform, const std::string& pointer, Texture& texture, int& set);
    std::optional<uint32_t> findImage(int image);
    std::optional<Texels> loadImage(int image);
    std::optional<float> meanOf(int texture, const char* what);
    float fraction(double value, const std::string& pointer);
    float amount(double value, const std::string& pointer);

    const Document& document_;
    Scene& scene_;
    Remarks& remarks_;
    std::vector<int> places_;  ///< of each image, its index in the scene
    std::map<int, std::optional<float>> means_;
};

/// Clamped to [0, 1] as the specification bounds it.
float MaterialReader::fraction(double value, const std::string& pointer) {
    if (std::isfinite(value) && value >= 0.0 && value <= 1.0) return static_cast<float>(value);
    remarks_.add("a material's factor outside [0, 1] was clamped, first at " + pointer);
    return value > 0.0 ? 1.0f : 0.0f;
}

float MaterialReader::amount(double value, const std::string& pointer) {
    const auto narrow = static_cast<float>(value);
    if (!(narrow >= 0.0f && std::isfinite(narrow))) throw errorAt(document_, pointer, "{} is negative or too large", value);
    return narrow;
}

UvSource MaterialReader::add(size_t index) {
    const tinygltf::Material& source = document_.model.materials[index];
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const std::string pointer = fmt::format("/materials/{}", index);
    const std::string pbrPointer = pointer + "/pbrMetallicRoughness";
    Material material;
    material.name = source.name;
    for (int k = 0; k < 3; ++k) material.baseColor[k] = fraction(pbr.baseColorFactor[k], pbrPointer + "/baseColorFactor");
    material.metallic = fraction(pbr.metallicFactor, pbrPointer + "/metallicFactor");
    material.roughness = fraction(pbr.roughnessFactor, pbrPointer + "/roughnessFactor");
    if (source.alphaMode == "BLEND" || source.alphaMode == "MASK") {
        material.alpha = fraction(pbr.baseColorFactor[3], pbrPointer + "/baseColorFactor");
        material.alphaVaries = true;
    }
    if (source.alphaMode != "OPAQUE" && source.alphaMode != "BLEND" && source.alphaMode != "MASK" &&
        !source.alphaMode.empty())
        remarks_.add("an alphaMode that glTF does not know is taken for OPAQUE, first at " + pointer + "/alphaMode");
    // A cutoff of 0 leaves everything.
    if (source.alphaMode == "MASK") {
        material.alphaCutoff = amount(source.alphaCutoff, pointer + "/alphaCutoff");
        if (material.alphaCutoff == 0.0f) material.alphaVaries = false;
        if (material.alphaCutoff == 0.0f) material.alpha = 1.0f;
    }
    double strength = 1.0;
    readExtensions(source.extensions, pointer, material, strength);
    for (int k = 0; k < 3; ++k)
        material.emission[k] = amount(source.emissiveFactor[k] * strength, pointer + "/emissiveFactor");
    if (source.alphaMode == "BLEND" && material.transmission > 0.0f)
        remarks_.add("alpha is left out where a material blends that lets light through by itself");
    UvSource uvSource = readTextures(source, pointer, material);
    scene_.materials.push_back(std::move(material));
    return uvSource;
}

void MaterialReader::readExtensions(const tinygltf::ExtensionMap& extensions, const std::string& pointer, Material& material,
                                    double& strength) {
    const std::string place = pointer + "/extensions/";
    if (const auto* found = findExtension(extensions, "KHR_materials_emissive_strength")) {
        strength = numberIn(*found, "emissiveStrength", 1.0);
        // Here, so that its fault is not that of the product with emissiveFactor.
        amount(strength, place + "KHR_materials_emissive_strength/emissiveStrength");
    }
    if (const auto* found = findExtension(extensions, "KHR_materials_ior")) {
        material.ior = amount(numberIn(*found, "ior", 1.5), place + "KHR_materials_ior/ior");
        // The extension's mark for materials converted from specular-glossiness: not an index of anything.
        if (material.ior == 0.0f) material.ior = 1.5f;
    }
    if (const auto* found = findExtension(extensions, "KHR_materials_transmission")) {
        const std::string at = place + "KHR_materials_transmission/transmission";
        material.transmission = fraction(numberIn(*found, "transmissionFactor", 0.0), at + "Factor");
        const tinygltf::Value& texture = found->Get("transmissionTexture");
        if (texture.IsObject() && texture.Get("index").IsInt()) {
            const int index = texture.Get("index").GetNumberAsInt();
            if (static_cast<size_t>(index) >= document_.model.textures.size())
                throw errorAt(document_, at + "Texture", "names texture {} of {}", index, document_.model.textures.size());
            if (const auto mean = meanOf(index, "transmission")) material.transmission *= *mean;
        }
    }
    if (const auto* found = findExtension(extensions, "KHR_materials_volume")) {
        material.thin = false;
        const dvec3 color = colorIn(document_, *found, "attenuationColor", place + "KHR_materials_volume");
        for (int k = 0; k < 3; ++k)
            material.attenuationColor[k] = fraction(color[k], place + "KHR_materials_volume/attenuationColor");
        // Absent is infinite: nothing is absorbed, which the scene writes as 0.
        material.attenuationDistance =
            amount(numberIn(*found, "attenuationDistance", 0.0), place + "KHR_materials_volume/attenuationDistance");
    }
    if (findExtension(extensions, "KHR_materials_unlit")) {
        material.metallic = 0.0f;
        material.roughness = 1.0f;
        remarks_.add("unlit materials are lit as plain base colour");
    }
}

/// The mean of the red channel: where a factor cannot vary, it keeps the right level so.
std::optional<float> MaterialReader::meanOf(int texture, const char* what) {
    if (texture < 0 || document_.model.textures[texture].source < 0) return std::nullopt;
    remarks_.add(fmt::format("{} textures are replaced by their mean", what));
    const int image = document_.model.textures[texture].source;
    const auto known = means_.find(image);
    if (known != means_.end()) return known->second;
    std::optional<float> mean;
    if (const std::optional<Texels> texels = loadImage(image)) {
        double sum = 0.0;
        for (size_t i = 0; i < texels->rgba.size(); i += 4) sum += texels->rgba[i] / 255.0;
        mean = static_cast<float>(sum / static_cast<double>(texels->rgba.size() / 4));
    }
    means_[image] = mean;
    return mean;
}

/// The image, or nothing and a remark: a picture without one of its textures is better than none.
std::optional<Texels> MaterialReader::loadImage(int image) {
    const ImageSource& source = document_.images[image];
    const std::string place = document_.file + fmt::format("#/images/{}", image);
    try {
        if (source.bufferView < 0) return decodeImage(readUri(source.uri, document_.folder, place), place);
        const tinygltf::BufferView& view = document_.model.bufferViews[source.bufferView];
        return decodeImage(document_.buffers[view.buffer].subspan(view.byteOffset, view.byteLength), place);
    } catch (const Error& problem) {
        remarks_.add(std::string("a texture is left out: ") + problem.what());
        return std::nullopt;
    }
}

UvSource MaterialReader::readTextures(const tinygltf::Material& source, const std::string& pointer, Material& material) {
    const tinygltf::PbrMetallicRoughness& pbr = source.pbrMetallicRoughness;
    const std::string pbrPointer = pointer + "/pbrMetallicRoughness";
    UvSource uvSource;
    material.baseColorTexture = readTexture(pbr.baseColorTexture, pbrPointer + "/baseColorTexture", uvSource);
    material.roughnessTexture =
        readTexture(pbr.metallicRoughnessTexture, pbrPointer + "/metallicRoughnessTexture", uvSource);
    if (material.emission != vec3(0.0f))
        material.emissionTexture = readTexture(source.emissiveTexture, pointer + "/emissiveTexture", uvSource);
    if (source.normalTexture.scale != 0.0) {
        material.normalTexture = readTexture(source.normalTexture, pointer + "/normalTexture", uvSource);
        material.normalScale = static_cast<float>(source.normalTexture.scale);
        if (!(std::abs(material.normalScale) <= mostNormalScale))
            throw errorAt(document_, pointer + "/normalTexture/scale", "is beyond {}", mostNormalScale);
        uvSource.hasNormals = material.normalTexture.has_value();
    }
    material.occlusionTexture = readTexture(source.occlusionTexture, pointer + "/occlusionTexture", uvSource);
    material.occlusionStrength = fraction(source.occlusionTexture.strength, pointer + "/occlusionTexture/strength");
    return uvSource;
}

std::optional<uint32_t> MaterialReader::findImage(int image) {
    int& place = places_[image];
    if (place == notLoaded) {
        std::optional<Texels> texels = loadImage(image);
        place = texels ? static_cast<int>(scene_.images.size()) : unusable;
        if (texels) scene_.images.push_back(std::move(*texels));
    }
    return place == unusable ? std::nullopt : std::optional<uint32_t>(place);
}

/// A texture of any kind, or nothing. The sets of coordinates that it is the first to ask for join `uvSource`.
template <class Info>
std::optional<Texture> MaterialReader::readTexture(const Info& info, const std::string& pointer, UvSource& uvSource) {
    if (info.index < 0) return std::nullopt;
    const tinygltf::Texture& source = document_.model.textures[info.index];
    if (source.source < 0) {
        remarks_.add("a texture is left out: it has no image of a supported format");
        return std::nullopt;
    }
    const std::optional<uint32_t> image = findImage(source.source);
    if (!image) return std::nullopt;
    Texture texture{.image = *image};
    if (source.sampler >= 0) {
        const tinygltf::Sampler& sampler = document_.model.samplers[source.sampler];
        texture.wrapU = wrapOf(document_, source.sampler, sampler.wrapS, "wrapS");
        texture.wrapV = wrapOf(document_, source.sampler, sampler.wrapT, "wrapT");
    }
    int set = info.texCoord;
    if (const auto* transform = findExtension(info.extensions, "KHR_texture_transform"))
        readTransform(*transform, pointer, texture, set);
    const auto known = std::ranges::find(uvSource.sets, set);
    if (known == uvSource.sets.end() && uvSource.sets.size() == 2) {
        remarks_.add("a texture is left out: its material has others of two sets of texture coordinates already");
        return std::nullopt;
    }
    texture.set = static_cast<uint32_t>(known - uvSource.sets.begin());
    if (known == uvSource.sets.end()) uvSource.sets.push_back(set);
    return texture;
}

/// Source: KHR_texture_transform.
void MaterialReader::readTransform(const tinygltf::Value& transform, const std::string& pointer, Texture& texture,
                                   int& set) {
    const auto pair = [&](const char* name, double otherwise) {
        const tinygltf::Value& value = transform.Get(name);
        if (value.Type() == tinygltf::NULL_TYPE) return dvec2(otherwise);
        if (value.ArrayLen() != 2) throw errorAt(document_, pointer, "{} must be 2 numbers", name);
        return dvec2(value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble());
    };
    const dvec2 offset = pair("offset", 0.0), scale = pair("scale", 1.0);
    const double angle = numberIn(transform, "rotation", 0.0);
    texture.u = vec3(std::cos(angle) * scale.x, std::sin(angle) * scale.y, offset.x);
    texture.v = vec3(-std::sin(angle) * scale.x, std::cos(angle) * scale.y, offset.y);
    for (int k = 0; k < 3; ++k)
        if (!isUsableUv({texture.u[k], texture.v[k]}))
            throw errorAt(document_, pointer, "its texture transform has a number beyond {}", mostUv);
    set = static_cast<int>(numberIn(transform, "texCoord", set));
}

}  // namespace

double numberIn(const tinygltf::Value& object, const char* name, double otherwise) {
    const tinygltf::Value& value = object.Get(name);
    return value.IsNumber() ? value.GetNumberAsDouble() : otherwise;
}

const tinygltf::Value* findExtension(const tinygltf::ExtensionMap& extensions, const char* name) {
    const auto found = extensions.find(name);
    return found == extensions.end() || !found->second.IsObject() ? nullptr : &found->second;
}

dvec3 colorIn(const Document& document, const tinygltf::Value& object, const char* name, const std::string& pointer) {
    const tinygltf::Value& value = object.Get(name);
    if (value.Type() == tinygltf::NULL_TYPE) return dvec3(1.0);
    if (value.ArrayLen() != 3) throw errorAt(document, pointer + "/" + name, "must be 3 numbers");
    return {value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble(), value.Get(2).GetNumberAsDouble()};
}

std::vector<UvSource> addMaterials(const Document& document, Scene& scene, Remarks& remarks) {
    MaterialReader reader(document, scene, remarks);
    std::vector<UvSource> uvSources;
    for (size_t i = 0; i < document.model.materials.size(); ++i) uvSources.push_back(reader.add(i));
    return uvSources;
}

}  // namespace raig::gltf
