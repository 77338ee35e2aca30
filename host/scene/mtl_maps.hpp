/// The pictures that MTL's materials name, as a scene's images and textures. Internal to the OBJ importer.
#pragma once

#include "scene/obj.hpp"

#include <map>
#include <set>
#include <tuple>

namespace raig {

/// The path of `name`, which is relative to `base`, as seen from the folder that `base` is relative to; nothing if it leads
/// out of that folder.
std::optional<std::filesystem::path> pathInside(const std::filesystem::path& base, const std::string& name);

/// The look-up of image `image` that a map's options ask for. OBJ's v counts upwards, a scene's downwards: MTL's
/// (u, v) -> scale (u, v) + offset is turned round with it.
Texture textureOf(const MtlMap& map, uint32_t image);

/// Reads pictures, each once. What is missing, unreadable or outside the scene's folder becomes a remark.
class MtlMaps {
public:
    /// Keeps a reference to `scene`, to which it adds images and remarks.
    MtlMaps(Scene& scene, std::filesystem::path folder) : scene_(scene), folder_(std::move(folder)) {}

    /// Adds the textures that `stated` names, in a library at `library` inside the folder, to `material`: also whether alpha
    /// varies, the strength of normals, and, under a map_Ke without Ke, the emission. Requires that it is
    /// toMaterial(stated).
    void addTextures(const MtlMaterial& stated, const std::filesystem::path& library, Material& material);
    /// Names the kinds of maps of all these materials that are not read, in one remark.
    void remarkLeftOut();

private:
    /// What a file holds, until a texture looks it up as it is: then the scene does.
    struct Picture {
        Texels texels;
        std::optional<uint32_t> image;
        bool hasAlpha = false;
        std::optional<bool> showsNormals;  ///< once it is known
    };
    using Merge = std::tuple<const Picture*, const Picture*, char>;  ///< colour (or null), opacity and its channel

    Picture* find(const std::filesystem::path& library, const MtlMap& map);
    std::optional<Picture> load(const std::filesystem::path& path);
    const Texels& texelsOf(const Picture& picture) const;
    uint32_t place(Picture& picture);
    std::optional<Texture> textureFor(const std::filesystem::path& library, const MtlMap& map);
    std::optional<Texture> colorTexture(const MtlMaterial& stated, const std::filesystem::path& library, Material& material);
    std::optional<Texture> normalTexture(const MtlMaterial& stated, const std::filesystem::path& library,
                                         Material& material);
    std::optional<uint32_t> merged(const Merge& merge);
    std::optional<uint32_t> makeMerged(const Merge& merge);
    bool isOpaque(const Picture& picture, char channel);
    void remarkOnce(const std::string& remark);

    Scene& scene_;
    std::filesystem::path folder_;
    std::map<std::filesystem::path, std::optional<Picture>> pictures_;
    std::map<Merge, std::optional<uint32_t>> merged_;
    std::map<std::pair<const Picture*, char>, bool> opaque_;
    uint64_t mergedTexels_ = 0;
    std::set<std::string> said_;
    std::set<std::string_view> leftOut_;
};

}  // namespace raig
