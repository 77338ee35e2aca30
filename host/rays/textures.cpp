#include "rays/textures.hpp"

#include "base/error.hpp"
#include "base/parallel.hpp"
#include "scene/color.hpp"

#include <algorithm>
#include <array>
#include <bit>
#include <cmath>
#include <map>

namespace raig {

using namespace shared;

namespace {

/// A texel's share in one of the next level, along one axis.
struct Share {
    uint32_t texel;
    double weight;
};

/// For each of `to` texels, what they cover of `from`.
std::vector<std::vector<Share>> coverage(uint32_t from, uint32_t to) {
    std::vector<std::vector<Share>> covered(to);
    const double step = double{static_cast<double>(from)} / to;
    for (uint32_t i = 0; i < to; ++i) {
        const double begin = i * step, end = (i + 1) * step;
        for (auto texel = static_cast<uint32_t>(begin); texel < from && texel < end; ++texel) {
            const double overlap = std::min(end, texel + 1.0) - std::max(begin, double(texel));
            if (overlap > 1e-9 * step) covered[i].push_back({texel, overlap / step});
        }
    }
    return covered;
}

Texels halved(const Texels& image, const ByteEncoding& color, const ByteEncoding& linear) {
    Texels half{std::max(1u, image.width / 2), std::max(1u, image.height / 2), {}};
    half.rgba.resize(size_t{half.width} * half.height * 4);
    const auto columns = coverage(image.width, half.width), rows = coverage(image.height, half.height);
    const size_t grain = std::max<size_t>(1, 16384 / half.width);
    parallelFor(half.height, grain, [&](size_t begin, size_t end) {
        for (size_t y = begin; y < end; ++y)
            for (size_t x = 0; x < half.width; ++x) {
                std::array<double, 4> sum{};
                for (const Share& row : rows[y])
                    for (const Share& column : columns[x]) {
                        const uint8_t* texel = &image.rgba[4 * (size_t{row.texel} * image.width + column.texel)];
                        const double weight = row.weight * column.weight;
                        for (int k = 0; k < 3; ++k) sum[k] += weight * color.values[texel[k]];
                        sum[3] += weight * linear.values[texel[3]];
                    }
                uint8_t* texel = &half.rgba[4 * (y * half.width + x)];
                for (int k = 0; k < 3; ++k) texel[k] = color.byteOf(sum[k]);
                texel[3] = linear.byteOf(sum[3]);
            }
    });
    return half;
}

bool isPlain(const Texture& t) {
    return t.u == vec3(1.0f, 0.0f, 0.0f) && t.v == vec3(0.0f, 1.0f, 0.0f);
}

uvec4 packed(const vec3& v) {
    return {std::bit_cast<uvec3>(v), 0u};
}

}  // namespace

std::vector<Texels> pyramidOf(const Texels& image, bool encoded) {
    const ByteEncoding linear(false), color(encoded);
    std::vector<Texels> levels = {image};
    while (levels.back().width > 1 || levels.back().height > 1) levels.push_back(halved(levels.back(), color, linear));
    return levels;
}

TextureList listTextures(const Scene& scene, const Geometry& geometry, const std::vector<bool>& isUsed) {
    TextureList list;
    const auto numberOf = [&](const std::optional<Texture>& texture, bool encoded) {
        if (!texture || (texture->set == 0 ? geometry.uvs : geometry.moreUvs).empty()) return NO_TEXTURE;
        const auto known = std::ranges::find_if(list.entries, [&](const TextureList::Entry& entry) {
            return entry.texture == *texture && entry.encoded == encoded;
        });
        if (known != list.entries.end()) return static_cast<uint32_t>(known - list.entries.begin());
        list.entries.push_back({*texture, encoded});
        return static_cast<uint32_t>(list.entries.size() - 1);
    };
    for (size_t i = 0; i < scene.materials.size(); ++i) {
        const Material& m = scene.materials[i];
        list.ofMaterial.emplace_back();
        if (!isUsed[i]) continue;
        list.ofMaterial.back() = {numberOf(m.baseColorTexture, true), numberOf(m.roughnessTexture, false),
                                  numberOf(m.normalTexture, false), numberOf(m.emissionTexture, true),
                                  numberOf(m.occlusionTexture, false)};
    }
    return list;
}

uint32_t textureFeatures(const TextureList& list) {
    uint32_t features = list.entries.empty() ? 0 : FEATURE_TEXTURES | FEATURE_UVS;
    for (const TextureList::Numbers& numbers : list.ofMaterial)
        features |= (numbers.color != NO_TEXTURE ? FEATURE_COLOR_TEXTURES : 0) |
                    (numbers.roughness != NO_TEXTURE ? FEATURE_ROUGHNESS_TEXTURES : 0) |
                    (numbers.normal != NO_TEXTURE ? FEATURE_NORMAL_TEXTURES : 0) |
                    (numbers.emission != NO_TEXTURE ? FEATURE_EMISSION_TEXTURES : 0) |
                    (numbers.occlusion != NO_TEXTURE ? FEATURE_OCCLUSION_TEXTURES : 0);
    for (const TextureList::Entry& entry : list.entries)
        features |=
            (isPlain(entry.texture) ? 0 : FEATURE_TEXTURE_TRANSFORMS) | (entry.texture.set == 1 ? FEATURE_MORE_UVS : 0);
    return features;
}

std::vector<uvec4> packTextures(const Scene& scene, const TextureList& list) {
    struct Stored {
        uint32_t levelsAt, levels;
    };
    std::map<std::pair<uint32_t, bool>, Stored> stored;
    std::vector<uvec4> elements(list.entries.size() * TEXTURE_STRIDE);
    const auto store = [&](uint32_t image, bool encoded) {
        const std::vector<Texels> levels = pyramidOf(scene.images.at(image), encoded);
        const size_t levelsAt = elements.size();
        size_t texelsAt = levelsAt + levels.size(), all = texelsAt;
        for (const Texels& level : levels) all += (level.rgba.size() + 15) / 16;
        if (all > 0xffffffffu) throw limitError("the scene's images need {} elements of shading data; 2^32 fit", all);
        elements.resize(all);
        for (size_t i = 0; i < levels.size(); ++i) {
            elements[levelsAt + i] = uvec4(texelsAt, levels[i].width, levels[i].height, 0u);
            std::ranges::copy(levels[i].rgba, reinterpret_cast<uint8_t*>(&elements[texelsAt]));
            texelsAt += (levels[i].rgba.size() + 15) / 16;
        }
        return Stored{static_cast<uint32_t>(levelsAt), static_cast<uint32_t>(levels.size())};
    };
    for (size_t i = 0; i < list.entries.size(); ++i) {
        const auto& [texture, encoded] = list.entries[i];
        const std::pair key(texture.image, encoded);
        if (!stored.contains(key)) stored[key] = store(texture.image, encoded);
        const Texels& image = scene.images[texture.image];
        const dvec3 u(texture.u), v(texture.v);
        const double texels = std::sqrt(std::abs(u.x * v.y - u.y * v.x) * image.width * image.height);
        const uint32_t wraps = static_cast<uint32_t>(texture.wrapU) | static_cast<uint32_t>(texture.wrapV) << 2;
        elements[i * TEXTURE_STRIDE] = {stored[key].levelsAt, stored[key].levels, wraps | texture.set << 4,
                                        std::bit_cast<uint32_t>(static_cast<float>(texels))};
        elements[i * TEXTURE_STRIDE + 1] = packed(texture.u);
        elements[i * TEXTURE_STRIDE + 2] = packed(texture.v);
    }
    return elements;
}

std::vector<uvec4> decodingTable() {
    std::array<float, 256> values{};
    for (size_t i = 0; i < values.size(); ++i) values[i] = static_cast<float>(linearFromSrgb(static_cast<double>(i) / 255.0));
    std::vector<uvec4> elements(64);
    static_assert(sizeof(values) == 64 * sizeof(uvec4));
    std::copy_n(reinterpret_cast<const std::byte*>(values.data()), sizeof(values),
                reinterpret_cast<std::byte*>(elements.data()));
    return elements;
}

}  // namespace raig
