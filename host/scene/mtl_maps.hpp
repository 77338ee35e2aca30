/// The pictures that MTL's materials name, as a scene's images and textures. Internal to the OBJ importer.
#pragma once

#include "scene/obj.hpp"

#include <map>

namespace raig {

/// `name` inside a folder, relative to it as `base` is; nothing if it leads out.
std::optional<std::filesystem::path> pathInside(const std::filesystem::path& base, const std::string& name);

/// The look-up of image `image` that a map's options ask for. OBJ's v counts upwards, a scene's downwards: MTL's
/// (u, v) -> scale (u, v) + offset is turned round with it.
Texture textureOf(const MtlMap& map, uint32_t image);

/// Reads pictures, each once. What is missing, unreadable or outside the scene's folder becomes a remark.
class MtlMaps {
public:
    /// Keeps a reference to `scene`, to which it adds images and remarks.
    MtlMaps(Scene& scene, std::filesystem::path folder) : scene_(scene), folder_(std::move(folder)) {}

    /// Adds the textures that `stated` names, in a library at `library` inside the folder, to the material made of it.
    void addTextures(const MtlMaterial& stated, const std::filesystem::path& library, Material& material);

private:
    std::optional<Texture> find(const std::filesystem::path& library, const MtlMap& map);
    std::optional<uint32_t> load(const std::filesystem::path& path);

    Scene& scene_;
    std::filesystem::path folder_;
    std::map<std::filesystem::path, std::optional<uint32_t>> indices_;
};

}  // namespace raig
