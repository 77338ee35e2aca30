#include "scene/mtl_maps.hpp"

#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/import.hpp"
#include "scene/mtl_opacity.hpp"
#include "scene/text.hpp"

#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

namespace raig {

namespace {

namespace fs = std::filesystem;

constexpr size_t largestFile = size_t{256} << 20;
/// 48 pictures of 2048 x 2048 have more: what a few small files could ask for has to end somewhere.
constexpr uint64_t mostMergedTexels = 200'000'000;

/// True if nine of ten texels are unit vectors, and not grey.
bool showsNormals(const Texels& picture) {
    size_t normals = 0;
    for (size_t i = 0; i < picture.rgba.size(); i += 4) {
        const uint8_t* texel = &picture.rgba[i];
        const auto [least, most] = std::minmax({texel[0], texel[1], texel[2]});
        const vec3 n = vec3(texel[0], texel[1], texel[2]) / 127.5f - 1.0f;
        normals += most - least >= 16 && n.z >= 0.0f && std::abs(glm::length(n) - 1.0f) < 0.15f;
    }
    return 10 * normals >= 9 * (picture.rgba.size() / 4);
}

}  // namespace

std::optional<fs::path> pathInside(const fs::path& base, const std::string& name) {
    const fs::path path = (base / name).lexically_normal();
    if (path.empty() || path.is_absolute() || *path.begin() == ".." || path == ".") return std::nullopt;
    return path;
}

Texture textureOf(const MtlMap& map, uint32_t image) {
    const Wrap wrap = map.clamps ? Wrap::clamp : Wrap::repeat;
    Texture texture{image, wrap, wrap};
    texture.u = vec3(map.scale.x, 0.0f, map.offset.x);
    texture.v = vec3(0.0f, map.scale.y, 1.0f - map.scale.y - map.offset.y);
    return texture;
}

void MtlMaps::addTextures(const MtlMaterial& stated, const fs::path& library, Material& material) {
    material.baseColorTexture = colorTexture(stated, library, material);
    if (!stated.ke || *stated.ke != vec3(0.0f)) material.emissionTexture = textureFor(library, stated.keMap);
    if (!stated.ke && material.emissionTexture) material.emission = vec3(1.0f);
    material.normalTexture = normalTexture(stated, library, material);
    leftOut_.insert(stated.otherMaps.begin(), stated.otherMaps.end());
}

/// That of map_Kd, with map_d as its alpha.
std::optional<Texture> MtlMaps::colorTexture(const MtlMaterial& stated, const fs::path& library, Material& material) {
    Picture* color = find(library, stated.kdMap);
    const bool isGlass = material.transmission > 0.0f;
    if (isGlass && !stated.dMap.isNone()) remarkOnce("map_d is left out where a material lets light through by itself");
    Picture* opacity = isGlass ? nullptr : find(library, stated.dMap);
    std::optional<uint32_t> image;
    if (opacity) {
        const char otherwise = opacity->hasAlpha ? 'm' : 'l';
        const char channel = stated.dMap.channel != 0 ? stated.dMap.channel : otherwise;
        const bool isSame = color == opacity && channel == 'm' && opacity->hasAlpha;
        image = isSame ? place(*color) : merged({color, opacity, channel});
    }
    material.alphaVaries = image.has_value();
    if (!image) return color ? std::optional(textureOf(stated.kdMap, place(*color))) : std::nullopt;
    if (!color) return textureOf(stated.dMap, *image);
    const Texture placed = textureOf(stated.kdMap, *image);
    if (placed != textureOf(stated.dMap, *image)) remarkOnce("map_d is placed as map_Kd is, whose options differ");
    return placed;
}

/// That of norm, else of map_Bump where its picture shows normals.
std::optional<Texture> MtlMaps::normalTexture(const MtlMaterial& stated, const fs::path& library, Material& material) {
    const bool isBump = stated.normMap.isNone();
    const MtlMap& map = isBump ? stated.bumpMap : stated.normMap;
    Picture* picture = find(library, map);
    if (!picture) return std::nullopt;
    if (isBump && !picture->showsNormals) picture->showsNormals = showsNormals(texelsOf(*picture));
    if (isBump && !*picture->showsNormals) {
        leftOut_.insert("map_Bump of heights");
        return std::nullopt;
    }
    material.normalScale = map.strength;
    return textureOf(map, place(*picture));
}

/// The image that has the one's colours and the other's opacity; nothing where that is opaque throughout, or too much.
std::optional<uint32_t> MtlMaps::merged(const Merge& merge) {
    const auto [entry, isNew] = merged_.try_emplace(merge);
    if (isNew) entry->second = makeMerged(merge);
    return entry->second;
}

std::optional<uint32_t> MtlMaps::makeMerged(const Merge& merge) {
    const auto [color, opacity, channel] = merge;
    const Texels* colors = color ? &texelsOf(*color) : nullptr;
    const Texels& opacities = texelsOf(*opacity);
    if (isOpaque(*opacity, channel)) return std::nullopt;
    const uvec2 size = mergedSize(colors, {opacities.width, opacities.height});
    const uint64_t texels = uint64_t{size.x} * size.y;
    if (mergedTexels_ + texels > mostMergedTexels) {
        remarkOnce(fmt::format("map_d is left out where pictures joined for it would have more than {} texels in all",
                               mostMergedTexels));
        return std::nullopt;
    }
    mergedTexels_ += texels;
    scene_.images.push_back(withOpacity(colors, opacityOf(opacities, channel)));
    return static_cast<uint32_t>(scene_.images.size() - 1);
}

/// Looked for once: many materials may share a large picture.
bool MtlMaps::isOpaque(const Picture& picture, char channel) {
    const auto [entry, isNew] = opaque_.try_emplace({&picture, channel});
    if (isNew) entry->second = opacityOf(texelsOf(picture), channel).isOpaque();
    return entry->second;
}

std::optional<Texture> MtlMaps::textureFor(const fs::path& library, const MtlMap& map) {
    Picture* picture = find(library, map);
    return picture ? std::optional(textureOf(map, place(*picture))) : std::nullopt;
}

/// Null if there is none, or it cannot be read.
MtlMaps::Picture* MtlMaps::find(const fs::path& library, const MtlMap& map) {
    if (map.isNone()) return nullptr;
    const auto inside = pathInside(library.parent_path(), map.file);
    if (!inside) {
        remarkOnce(fmt::format("{}: the image {} lies outside the scene's folder and is not read", library.string(),
                               text::quoted(map.file)));
        return nullptr;
    }
    const auto [entry, isNew] = pictures_.try_emplace(*inside);
    if (isNew) entry->second = load(folder_ / *inside);
    return entry->second ? &*entry->second : nullptr;
}

std::optional<MtlMaps::Picture> MtlMaps::load(const fs::path& path) {
    try {
        Picture picture;
        picture.texels = decodeImage(readFile(path, largestFile), path);
        picture.hasAlpha = hasAlpha(picture.texels);
        return picture;
    } catch (const Error& error) {
        scene_.remarks.push_back(fmt::format("image left out: {}", error.what()));
        return std::nullopt;
    }
}

const Texels& MtlMaps::texelsOf(const Picture& picture) const {
    return picture.image ? scene_.images[*picture.image] : picture.texels;
}

/// Its index among the scene's images.
uint32_t MtlMaps::place(Picture& picture) {
    if (!picture.image) {
        scene_.images.push_back(std::move(picture.texels));
        picture.image = static_cast<uint32_t>(scene_.images.size() - 1);
    }
    return *picture.image;
}

void MtlMaps::remarkLeftOut() {
    if (!leftOut_.empty()) remarkOnce(fmt::format("maps that are not read are left out: {}", fmt::join(leftOut_, ", ")));
}

void MtlMaps::remarkOnce(const std::string& remark) {
    if (said_.insert(remark).second) scene_.remarks.push_back(remark);
}

}  // namespace raig
