#include "base/error.hpp"
#include "base/files.hpp"
#include "scene/import.hpp"
#include "scene/obj.hpp"
#include "scene/text.hpp"

#include <algorithm>
#include <cmath>
#include <map>
#include <unordered_map>

namespace raig {

namespace {

namespace fs = std::filesystem;

constexpr size_t largestLibrary = size_t{256} << 20;
constexpr size_t largestImageFile = size_t{256} << 20;

float luminance(const vec3& c) {
    return glm::dot(c, vec3(0.2126f, 0.7152f, 0.0722f));
}

/// A finite number, or nothing.
std::optional<float> readNumber(text::Words& words) {
    const auto value = text::parseFloat(words.next());
    return value && std::isfinite(*value) ? value : std::nullopt;
}

/// "r g b", or "r" for a grey: never negative.
std::optional<vec3> readColor(text::Words& words) {
    const auto r = readNumber(words);
    if (!r) return std::nullopt;
    if (words.rest().empty()) return vec3(std::max(*r, 0.0f));
    const auto g = readNumber(words);
    const auto b = readNumber(words);
    if (!g || !b) return std::nullopt;
    return glm::max(vec3(*r, *g, *b), vec3(0.0f));
}

/// How many words follow a texture option; for -o, -s and -t one to three numbers.
size_t optionArguments(std::string_view option) {
    if (option == "-mm") return 2;
    if (option == "-o" || option == "-s" || option == "-t") return 3;
    return 1;
}

/// The file name after the options, which may hold blanks.
void readKdMap(std::string_view arguments, MtlMaterial& material) {
    text::Words words(arguments);
    while (words.rest().starts_with('-')) {
        text::Words ahead = words;
        const std::string_view option = ahead.next();
        if (option.size() < 2 || text::parseFloat(option)) break;
        const size_t most = optionArguments(option);
        for (size_t i = 0; i < most; ++i) {
            text::Words after = ahead;
            const std::string_view argument = after.next();
            if (most == 3 && i > 0 && !text::parseFloat(argument)) break;
            if (option == "-clamp") material.clampsKdMap = argument == "on";
            ahead = after;
        }
        words = ahead;
    }
    material.kdMap = words.rest();
    std::ranges::replace(material.kdMap, '\\', '/');
}

/// Reads one statement into `m`. False if its numbers are malformed.
bool readStatement(std::string_view key, text::Words& words, MtlMaterial& m) {
    const auto keep = [](auto& member, const auto& value) {
        if (value) member = value;
        return value.has_value();
    };
    if (key == "Kd") return keep(m.kd, readColor(words));
    if (key == "Ks") return keep(m.ks, readColor(words));
    if (key == "Ke") return keep(m.ke, readColor(words));
    if (key == "Tf") return keep(m.tf, readColor(words));
    if (key == "Ns") return keep(m.ns, readNumber(words));
    if (key == "Ni") return keep(m.ni, readNumber(words));
    if (key == "d") {
        if (words.rest().starts_with("-halo")) words.next();
        return keep(m.opacity, readNumber(words));
    }
    if (key == "Tr") {
        const auto clearness = readNumber(words);
        // Where both are given they contradict each other more often than not: d is the standard's.
        if (clearness && !m.opacity) m.opacity = 1.0f - *clearness;
        return clearness.has_value();
    }
    if (key == "illum") {
        const auto model = text::parseInteger(words.next());
        if (model) m.illum = static_cast<int>(std::clamp<int64_t>(*model, 0, 100));
        return model.has_value();
    }
    if (key == "map_Kd") readKdMap(words.rest(), m);
    return true;
}

/// `name` inside `folder`, relative to `base` (itself relative to `folder`); nothing if it leads out of `folder`.
std::optional<fs::path> pathInside(const fs::path& base, const std::string& name) {
    const fs::path path = (base / name).lexically_normal();
    if (path.empty() || path.is_absolute() || *path.begin() == ".." || path == ".") return std::nullopt;
    return path;
}

/// Images by path, each decoded once.
class Images {
public:
    Images(Scene& scene, const fs::path& folder) : scene_(scene), folder_(folder) {}

    std::optional<uint32_t> find(const fs::path& library, const std::string& name) {
        const auto inside = pathInside(library.parent_path(), name);
        if (!inside) {
            scene_.remarks.push_back(fmt::format("{}: the image {} lies outside the scene's folder and is not read",
                                                 library.string(), text::quoted(name)));
            return std::nullopt;
        }
        const auto [entry, isNew] = indices_.try_emplace(*inside);
        if (isNew) entry->second = load(folder_ / *inside);
        return entry->second;
    }

private:
    std::optional<uint32_t> load(const fs::path& path) {
        try {
            scene_.images.push_back(decodeImage(readFile(path, largestImageFile), path));
            return static_cast<uint32_t>(scene_.images.size() - 1);
        } catch (const Error& error) {
            scene_.remarks.push_back(fmt::format("image left out: {}", error.what()));
            return std::nullopt;
        }
    }

    Scene& scene_;
    fs::path folder_;
    std::map<fs::path, std::optional<uint32_t>> indices_;
};

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
    std::vector<fs::path> seen;
    for (const std::string& statement : statements) {
        for (const std::string& name : filesNamed(folder, statement)) {
            const auto inside = pathInside({}, name);
            if (!inside) {
                scene.remarks.push_back(fmt::format(
                    "the material library {} lies outside the scene's folder and is not read", text::quoted(name)));
                continue;
            }
            if (std::ranges::find(seen, *inside) != seen.end()) continue;
            seen.push_back(*inside);
            if (auto library = loadLibrary(scene, folder, *inside)) libraries.push_back(std::move(*library));
        }
    }
    return libraries;
}

}  // namespace

std::vector<MtlMaterial> readMtl(std::string_view content, const std::string& place, std::vector<std::string>& remarks) {
    std::vector<MtlMaterial> materials;
    text::Statements statements(content);
    while (const auto statement = statements.next()) {
        text::Words words(*statement);
        const std::string_view key = words.next();
        if (key == "newmtl") {
            materials.push_back({});
            materials.back().name = words.rest();
        } else if (!materials.empty() && !readStatement(key, words, materials.back())) {
            remarks.push_back(fmt::format("{}:{}: {} is malformed and left out", place, statements.line(),
                                          text::quoted(text::trimmed(*statement))));
        }
    }
    return materials;
}

Material toMaterial(const MtlMaterial& m) {
    const int illum = m.illum.value_or(2);
    const float ni = m.ni.value_or(1.0f);
    const float opacity = std::clamp(m.opacity.value_or(1.0f), 0.0f, 1.0f);
    const vec3 kd = glm::min(m.kd.value_or(vec3(m.kdMap.empty() ? 0.8f : 1.0f)), 1.0f);
    const vec3 ks = glm::min(m.ks.value_or(vec3(0.0f)), 1.0f);
    const float blur = std::sqrt(2.0f / (std::max(m.ns.value_or(0.0f), 0.0f) + 2.0f));

    Material material;
    material.name = m.name;
    material.baseColor = kd;
    material.emission = m.ke.value_or(vec3(0.0f));
    const bool refracts = (illum == 6 || illum == 7) && m.tf && ni > 1.0001f;
    if (opacity < 1.0f || refracts) {
        material.transmission = 1.0f;
        material.roughness = 0.0f;
        material.thin = false;
        material.ior = ni > 1.0001f ? ni : 1.5f;
        material.baseColor = m.tf ? glm::min(*m.tf, 1.0f) : glm::mix(vec3(1.0f), kd, opacity);
    } else if ((illum == 3 || illum == 5 || illum == 8) && luminance(ks) > 0.0f) {
        material.baseColor = glm::min(kd + ks, 1.0f);
        material.metallic = luminance(ks) / luminance(kd + ks);
        material.roughness = m.ns ? blur : 0.0f;
    } else if (illum >= 2 && m.ns && luminance(ks) > 0.0f) {
        const float reflectance = std::sqrt(0.08f * luminance(ks));
        material.roughness = std::max(std::sqrt(blur), 0.5f);
        material.ior = (1.0f + reflectance) / (1.0f - reflectance);
    }
    return material;
}

void addMtlMaterials(Scene& scene, const fs::path& folder, const std::vector<std::string>& statements,
                     const std::vector<std::string>& names) {
    const std::vector<Library> libraries = loadLibraries(scene, folder, statements);
    std::unordered_map<std::string_view, std::pair<const Library*, const MtlMaterial*>> defined;
    for (const Library& library : libraries)
        for (const MtlMaterial& material : library.materials) defined.try_emplace(material.name, &library, &material);

    Images images(scene, folder);
    for (const std::string& name : names) {
        Material material;
        material.name = name;
        if (const auto found = defined.find(name); found != defined.end()) {
            const auto& [library, stated] = found->second;
            material = toMaterial(*stated);
            if (!stated->kdMap.empty()) {
                const Wrap wrap = stated->clampsKdMap ? Wrap::clamp : Wrap::repeat;
                if (const auto image = images.find(library->path, stated->kdMap))
                    material.baseColorTexture = Texture{*image, wrap, wrap};
            }
        } else if (!name.empty()) {
            scene.remarks.push_back(
                fmt::format("no library defines the material {}: a default one stands in", text::quoted(name)));
        }
        scene.materials.push_back(std::move(material));
    }
}

}  // namespace raig
