#include "scene/mtl_maps.hpp"
#include "scene/text.hpp"

#include <algorithm>
#include <array>
#include <cmath>

namespace raig {

namespace {

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

/// How many words follow a texture option at most; for -o, -s and -t one to three numbers.
size_t optionArguments(std::string_view option) {
    if (option == "-mm") return 2;
    if (option == "-o" || option == "-s" || option == "-t") return 3;
    return 1;
}

/// Reads one option of a map and what follows it. False if that is malformed where it counts, or a number too large.
bool readOption(text::Words& words, MtlMap& map) {
    const std::string_view option = words.next();
    vec2* pair = option == "-o" ? &map.offset : option == "-s" ? &map.scale : nullptr;
    const bool counts = pair || option == "-bm";
    const float largest = pair ? mostUv / 4.0f : mostNormalScale;  // so that sums for v, turned round, are none too large
    const size_t most = optionArguments(option);
    const bool mayBeFewer = most == 3;
    for (size_t i = 0; i < most; ++i) {
        text::Words ahead = words;
        const std::string_view argument = ahead.next();
        const auto number = text::parseFloat(argument);
        if (mayBeFewer && i > 0 && !number) break;
        if (option == "-clamp" && argument != "on" && argument != "off") return false;
        if (option == "-clamp") map.clamps = argument == "on";
        const bool isChannel = argument.size() == 1 && std::string_view("rgbmlz").find(argument) != argument.npos;
        if (option == "-imfchan" && !isChannel) return false;
        if (option == "-imfchan" && argument != "z") map.channel = argument.front();
        if (counts && !(number && std::abs(*number) <= largest)) return false;
        if (pair && i < 2) (*pair)[static_cast<int>(i)] = *number;
        if (option == "-bm") map.strength = *number;
        words = ahead;
    }
    return true;
}

/// The options, and the file name after them, which may hold blanks. False without one, and if options are malformed.
bool readMap(std::string_view arguments, MtlMap& map) {
    MtlMap read;
    const std::string joined = text::joinedLines(arguments);
    text::Words words(joined);
    while (words.rest().starts_with('-')) {
        text::Words ahead = words;
        const std::string_view option = ahead.next();
        if (option.size() < 2 || text::parseFloat(option)) break;
        if (!readOption(words, read)) return false;
    }
    read.file = words.rest();
    if (read.isNone()) return false;
    std::ranges::replace(read.file, '\\', '/');
    map = std::move(read);
    return true;
}

/// What the kinds of maps that are not read are called in a remark.
constexpr std::array<std::string_view, 9> unreadMaps{"disp",   "decal",  "refl",   "map_Ks", "map_Ns",
                                                     "map_Pr", "map_Pm", "map_Ps", "map_Tr"};

/// Reads the statement of a map into `m`, if it is one, in any case of letters, as these are mixed up often. False if it is
/// malformed.
bool readMapStatement(std::string_view key, text::Words& words, MtlMaterial& m) {
    const auto is = [key](std::string_view kind) { return text::equalsIgnoringCase(key, kind); };
    if (is("map_Kd")) return readMap(words.rest(), m.kdMap);
    if (is("map_Ke")) return readMap(words.rest(), m.keMap);
    if (is("map_d")) return readMap(words.rest(), m.dMap);
    if (is("norm")) return readMap(words.rest(), m.normMap);
    if (is("bump") || is("map_Bump")) return readMap(words.rest(), m.bumpMap);
    for (const std::string_view kind : unreadMaps)
        if (is(kind)) m.otherMaps.insert(kind);
    return true;
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
    return readMapStatement(key, words, m);
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
    const vec3 kd = glm::min(m.kd.value_or(vec3(m.kdMap.isNone() ? 0.8f : 1.0f)), 1.0f);
    const vec3 ks = glm::min(m.ks.value_or(vec3(0.0f)), 1.0f);
    const float blur = std::sqrt(2.0f / (std::max(m.ns.value_or(0.0f), 0.0f) + 2.0f));

    Material material;
    material.name = m.name;
    material.baseColor = kd;
    material.emission = m.ke.value_or(vec3(0.0f));
    const bool refracts = (illum == 6 || illum == 7) && m.tf && ni > 1.0001f;
    const bool blends = !m.dMap.isNone() && !refracts;
    if (blends) material.alpha = opacity;
    if (refracts || (opacity < 1.0f && !blends)) {
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

}  // namespace raig
