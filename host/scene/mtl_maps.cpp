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
    if (stated.kdMap.file.empty()) return;
    if (const auto image = find(library, stated.kdMap)) material.baseColorTexture = textureOf(stated.kdMap, *image);
}

std::optional<uint32_t> MtlMaps::find(const fs::path& library, const MtlMap& map) {
    const auto inside = pathInside(library.parent_path(), map.file);
    if (!inside) {
        scene_.remarks.push_back(fmt::format("{}: the image {} lies outside the scene's folder and is not read",
                                             library.string(), text::quoted(map.file)));
        return std::nullopt;
    }
    const auto [entry, isNew] = indices_.try_emplace(*inside);
    if (isNew) entry->second = load(folder_ / *inside);
    return entry->second;
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
