#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/mtl_maps.hpp"
#include "scene/text.hpp"

#include <algorithm>
#include <set>
#include <unordered_map>

namespace raig {

namespace {

namespace fs = std::filesystem;

constexpr size_t largestLibrary = size_t{256} << 20;

struct Library {
    fs::path path;  ///< relative to the scene's folder
    std::vector<MtlMaterial> materials;
};

/// One library, or nothing with a remark.
std::optional<Library> loadLibrary(Scene& scene, const fs::path& folder, const fs::path& inside) {
    try {
        const std::vector<std::byte> bytes = readFile(folder / inside, largestLibrary);
        const std::string place = (folder / inside).string();
        return Library{inside, readMtl(text::checkText(bytes, place), place, scene.remarks)};
    } catch (const Error& error) {
        scene.remarks.push_back(fmt::format("material library left out: {}", error.what()));
        return std::nullopt;
    }
}

/// The files one mtllib statement names: itself, if such a file exists (names may hold blanks), else word by word.
std::vector<std::string> filesNamed(const fs::path& folder, std::string statement) {
    std::ranges::replace(statement, '\\', '/');
    std::error_code ignored;
    const auto whole = pathInside({}, statement);
    if (whole && fs::exists(folder / *whole, ignored)) return {statement};
    std::vector<std::string> names;
    text::Words words(statement);
    for (std::string_view word = words.next(); !word.empty(); word = words.next()) names.emplace_back(word);
    return names;
}

std::vector<Library> loadLibraries(Scene& scene, const fs::path& folder, const std::vector<std::string>& statements) {
    std::vector<Library> libraries;
    std::set<fs::path> seen;
    for (const std::string& statement : statements) {
        for (const std::string& name : filesNamed(folder, statement)) {
            const auto inside = pathInside({}, name);
            if (!inside) {
                scene.remarks.push_back(fmt::format(
                    "the material library {} lies outside the scene's folder and is not read", text::quoted(name)));
                continue;
            }
            if (!seen.insert(*inside).second) continue;
            if (auto library = loadLibrary(scene, folder, *inside)) libraries.push_back(std::move(*library));
        }
    }
    return libraries;
}

}  // namespace

void addMtlMaterials(Scene& scene, const fs::path& folder, const std::vector<std::string>& statements,
                     const std::vector<std::string>& names) {
    const std::vector<Library> libraries = loadLibraries(scene, folder, statements);
    std::unordered_map<std::string_view, std::pair<const Library*, const MtlMaterial*>> defined;
    for (const Library& library : libraries)
        for (const MtlMaterial& material : library.materials) defined.try_emplace(material.name, &library, &material);

    MtlMaps maps(scene, folder);
    for (const std::string& name : names) {
        Material material;
        material.name = name;
        if (const auto found = defined.find(name); found != defined.end()) {
            const auto& [library, stated] = found->second;
            material = toMaterial(*stated);
            maps.addTextures(*stated, library->path, material);
        } else if (!name.empty()) {
            scene.remarks.push_back(
                fmt::format("no library defines the material {}: a default one stands in", text::quoted(name)));
        }
        scene.materials.push_back(std::move(material));
    }
    maps.remarkLeftOut();
}

}  // namespace raig
