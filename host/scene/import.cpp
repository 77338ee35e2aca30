#include "scene/import.hpp"

#include "base/error.hpp"
#include "scene/text.hpp"
#include "scene/validate.hpp"

namespace raig {

namespace {

using Importer = Scene (*)(const std::filesystem::path&);

struct Format {
    std::string_view ending;
    Importer import;
};

constexpr Format formats[] = {
    {".gltf", importGltf}, {".glb", importGltf}, {".obj", importObj}, {".ply", importPly}, {".stl", importStl},
};

Importer findImporter(const std::filesystem::path& path) {
    const std::string ending = path.extension();
    for (const Format& format : formats)
        if (text::equalsIgnoringCase(ending, format.ending)) return format.import;
    throw inputError(path, "{} is no scene format that can be read; these are: .gltf .glb .obj .ply .stl",
                     ending.empty() ? "a name without an ending" : text::quoted(ending));
}

}  // namespace

Scene importScene(const std::filesystem::path& path) {
    Scene scene = findImporter(path)(path);
    completeScene(scene);
    // The importers check what they read; a fault here is theirs, not the file's.
    if (const auto fault = findFault(scene)) checkFailed(__FILE__, __LINE__, path.string() + ": " + *fault);
    RAIG_CHECK(!scene.materials.empty() && !scene.cameras.empty());
    return scene;
}

}  // namespace raig
