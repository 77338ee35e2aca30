#include "scene/gltf_parts.hpp"
#include "scene/import.hpp"

#include <array>

namespace raig::gltf {

namespace {

/// What an sRGB texel value means, in linear light: IEC 61966-2-1.
std::array<double, 256> linearValues() {
    std::array<double, 256> values{};
    for (int i = 0; i < 256; ++i) {
        const double s = i / 255.0;
        values[i] = s <= 0.04045 ? s / 12.92 : std::pow((s + 0.055) / 1.055, 2.4);
    }
    return values;
}

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
    void readMeans(const tinygltf::Material& source, Material& material);
    UvSource readBaseTexture(const tinygltf::TextureInfo& info, const std::string& pointer, Material& material);
    std::optional<Texels> loadImage(int image);
    std::optional<dvec3> meanOf(int texture, bool isColor, const char* what);
    float fraction(double value, const std::string& pointer);
    float amount(double value, const std::string& pointer);

    const Document& document_;
    Scene& scene_;
    Remarks& remarks_;
    std::vector<int> places_;  ///< of each image, its index in the scene
    std::map<std::pair<int, bool>, std::optional<dvec3>> means_;
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
    if (source.alphaMode == "BLEND") material.alpha = fraction(pbr.baseColorFactor[3], pbrPointer + "/baseColorFactor");
    if (source.alphaMode == "MASK") remarks_.add("alpha masks are not cut out: masked surfaces are drawn whole");
    double strength = 1.0;
    readExtensions(source.extensions, pointer, material, strength);
    for (int k = 0; k < 3; ++k)
        material.emission[k] = amount(source.emissiveFactor[k] * strength, pointer + "/emissiveFactor");
    readMeans(source, material);
    const UvSource uvSource = readBaseTexture(pbr.baseColorTexture, pbrPointer + "/baseColorTexture", material);
    if (source.normalTexture.index >= 0) remarks_.add("normal textures are not used");
    scene_.materials.push_back(std::move(material));
    return uvSource;
}

void MaterialReader::readExtensions(const tinygltf::ExtensionMap& extensions, const std::string& pointer, Material& material,
                                    double& strength) {
    const std::string place = pointer + "/extensions/";
    if (const auto* found = findExtension(extensions, "KHR_materials_emissive_strength"))
        strength = numberIn(*found, "emissiveStrength", 1.0);
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
            if (const auto mean = meanOf(index, false, "transmission")) material.transmission *= static_cast<float>(mean->x);
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

/// Factors that vary over a texture keep the right level by its mean, which the default factors of 1 would not.
void MaterialReader::readMeans(const tinygltf::Material& source, Material& material) {
    if (const auto mean = meanOf(source.pbrMetallicRoughness.metallicRoughnessTexture.index, false, "metallic-roughness")) {
        material.roughness *= static_cast<float>(mean->y);
        material.metallic *= static_cast<float>(mean->z);
    }
    if (material.emission != vec3(0.0f))
        if (const auto mean = meanOf(source.emissiveTexture.index, true, "emissive")) material.emission *= vec3(*mean);
}

std::optional<dvec3> MaterialReader::meanOf(int texture, bool isColor, const char* what) {
    if (texture < 0 || document_.model.textures[texture].source < 0) return std::nullopt;
    remarks_.add(fmt::format("{} textures are replaced by their mean", what));
    const int image = document_.model.textures[texture].source;
    const auto known = means_.find({image, isColor});
    if (known != means_.end()) return known->second;
    std::optional<dvec3> mean;
    if (const std::optional<Texels> texels = loadImage(image)) {
        static const std::array<double, 256> linear = linearValues();
        dvec3 sum(0.0);
        for (size_t i = 0; i < texels->rgba.size(); i += 4)
            for (int k = 0; k < 3; ++k) sum[k] += isColor ? linear[texels->rgba[i + k]] : texels->rgba[i + k] / 255.0;
        mean = sum / static_cast<double>(texels->rgba.size() / 4);
    }
    means_[{image, isColor}] = mean;
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

UvSource MaterialReader::readBaseTexture(const tinygltf::TextureInfo& info, const std::string& pointer, Material& material) {
    UvSource uvSource;
    uvSource.set = info.texCoord;
    if (info.index < 0) return uvSource;
    const tinygltf::Texture& texture = document_.model.textures[info.index];
    if (texture.source < 0) {
        remarks_.add("a texture is left out: it has no image of a supported format");
        return uvSource;
    }
    int& place = places_[texture.source];
    if (place == notLoaded) {
        std::optional<Texels> texels = loadImage(texture.source);
        place = texels ? static_cast<int>(scene_.images.size()) : unusable;
        if (texels) scene_.images.push_back(std::move(*texels));
    }
    if (place == unusable) return uvSource;
    Texture lookUp{static_cast<uint32_t>(place), Wrap::repeat, Wrap::repeat};
    if (texture.sampler >= 0) {
        const tinygltf::Sampler& sampler = document_.model.samplers[texture.sampler];
        lookUp.wrapU = wrapOf(document_, texture.sampler, sampler.wrapS, "wrapS");
        lookUp.wrapV = wrapOf(document_, texture.sampler, sampler.wrapT, "wrapT");
    }
    material.baseColorTexture = lookUp;
    uvSource.isUsed = true;
    if (const auto* transform = findExtension(info.extensions, "KHR_texture_transform")) {
        const auto pair = [&](const char* name, double otherwise) {
            const tinygltf::Value& value = transform->Get(name);
            if (value.Type() == tinygltf::NULL_TYPE) return dvec2(otherwise);
            if (value.ArrayLen() != 2) throw errorAt(document_, pointer, "{} must be 2 numbers", name);
            return dvec2(value.Get(0).GetNumberAsDouble(), value.Get(1).GetNumberAsDouble());
        };
        const dvec2 offset = pair("offset", 0.0), scale = pair("scale", 1.0);
        const double angle = numberIn(*transform, "rotation", 0.0);
        uvSource.u = vec3(std::cos(angle) * scale.x, std::sin(angle) * scale.y, offset.x);
        uvSource.v = vec3(-std::sin(angle) * scale.x, std::cos(angle) * scale.y, offset.y);
        if (!isFinite(uvSource.u) || !isFinite(uvSource.v))
            throw errorAt(document_, pointer, "its texture transform is not finite");
        uvSource.set = static_cast<int>(numberIn(*transform, "texCoord", uvSource.set));
    }
    return uvSource;
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
