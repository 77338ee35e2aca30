#include "scene/import.hpp"

#include "base/error.hpp"
#include "scene/text.hpp"
#include "scene/validate.hpp"

namespace raig {

namespace {

using Importer = Scene (*)(const std::filesystem::path&);

struct Format {
    std::string_view ending;
    Importer import;  ///< null: glTF, which moves
};

constexpr Format formats[] = {
    {".gltf", nullptr}, {".glb", nullptr}, {".obj", importObj}, {".ply", importPly}, {".stl", importStl},
};

const Format& findFormat(const std::filesystem::path& path) {
    const std::string ending = path.extension();
    for (const Format& format : formats)
        if (text::equalsIgnoringCase(ending, format.ending)) return format;
    throw inputError(path, "{} is no scene format that can be read; these are: .gltf .glb .obj .ply .stl",
                     ending.empty() ? "a name without an ending" : text::quoted(ending));
}

const std::filesystem::path& checkMoves(const std::filesystem::path& path) {
    if (findFormat(path).import)
        throw usageError("--time-at and --frames: {} has no animation: only .gltf and .glb files have", path.string());
    return path;
}

Scene completed(Scene scene, const std::filesystem::path& path) {
    completeScene(scene);
    // The importers check what they read; a fault here is theirs, not the file's.
    if (const auto fault = findFault(scene)) checkFailed(__FILE__, __LINE__, path.string() + ": " + *fault);
    RAIG_CHECK(!scene.materials.empty() && !scene.cameras.empty());
    return scene;
}

}  // namespace

Scene importScene(const std::filesystem::path& path, const Moment& moment) {
    if (moment.seconds) checkMoves(path);
    const Importer import = findFormat(path).import;
    return completed(import ? import(path) : importGltf(path, moment), path);
}

MovingScene::MovingScene(const std::filesystem::path& path) : path_(path), file_(checkMoves(path)) {}

Scene MovingScene::at(const Moment& moment) {
    Scene scene = file_.at(moment);
    const bool lacksCamera = scene.cameras.empty();
    if (lacksCamera && added_) scene.cameras.push_back(*added_);
    scene = completed(std::move(scene), path_);
    if (lacksCamera) added_ = scene.cameras.front();
    return scene;
}

}  // namespace raig
