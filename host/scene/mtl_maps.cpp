#include "scene/mtl_maps.hpp"

#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/import.hpp"
#include "scene/text.hpp"

namespace raig {

namespace {

namespace fs = std::filesystem;

constexpr size_t largestFile = size_t{256} << 20;

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
    material.baseColorTexture = find(library, stated.kdMap);
    if (material.emission != vec3(0.0f)) material.emissionTexture = find(library, stated.keMap);
    // Ke is 1 for a picture's sake: where there is none to be had, nothing glows.
    if (!stated.ke && !material.emissionTexture) material.emission = vec3(0.0f);
}

std::optional<Texture> MtlMaps::find(const fs::path& library, const MtlMap& map) {
    if (map.isNone()) return std::nullopt;
    const auto inside = pathInside(library.parent_path(), map.file);
    if (!inside) {
        scene_.remarks.push_back(fmt::format("{}: the image {} lies outside the scene's folder and is not read",
                                             library.string(), text::quoted(map.file)));
        return std::nullopt;
    }
    const auto [entry, isNew] = indices_.try_emplace(*inside);
    if (isNew) entry->second = load(folder_ / *inside);
    return entry->second ? std::optional(textureOf(map, *entry->second)) : std::nullopt;
}

std::optional<uint32_t> MtlMaps::load(const fs::path& path) {
    try {
        scene_.images.push_back(decodeImage(readFile(path, largestFile), path));
        return static_cast<uint32_t>(scene_.images.size() - 1);
    } catch (const Error& error) {
        scene_.remarks.push_back(fmt::format("image left out: {}", error.what()));
        return std::nullopt;
    }
}

}  // namespace raig
